"""Random terms and formulas for `generate`."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

from tests.reference.vocabulary import (
    NUMBERS,
    PROPERTIES,
    PROPOSITIONS,
    RESULTS,
    SYMBOLS,
    VALUES,
    WILD,
)

Datum = Any
"""A word, or a tuple of data."""


class Words:
    """Where random terms come from: the variables of a RAP and the constants.

    `known` are variables likely to be bound, `free` others, `resources` sets and
    counters; `methods` names of methods.
    """

    def __init__(self, rng: random.Random, known: Sequence[str]) -> None:
        self.rng = rng
        self.known = list(known)
        self.free = ["?u", "?v", "?w"]
        self.sets: list[str] = []
        self.counters: list[str] = []
        self.methods: list[str] = ["one"]

    def chance(self, share: float) -> bool:
        """True in this share of cases."""
        return self.rng.random() < share

    def pick(self, words: Sequence[Datum]) -> Datum:
        """One of some words."""
        return words[self.rng.randrange(len(words))]

    # --- terms ----------------------------------------------------------------------

    def item(self) -> Datum:
        """What a fact may be about."""
        roll = self.rng.random()
        if roll < 0.35 and self.known:
            return self.pick(self.known)
        if roll < 0.5:
            return self.pick(self.free)
        if roll < 0.53:
            return "?"
        return self.pick(SYMBOLS) if roll < 0.97 else self.pick(WILD)

    def value(self) -> Datum:
        """What a fact may say."""
        roll = self.rng.random()
        if roll < 0.15 and self.known:
            return self.pick(self.known)
        if roll < 0.4:
            return self.pick(self.free)
        if roll < 0.47:
            return "?"
        if roll < 0.52:
            return self.computed()
        return self.pick(VALUES) if roll < 0.95 else self.pick(WILD)

    def ground(self) -> Datum:
        """A term that should have a value."""
        roll = self.rng.random()
        if roll < 0.5 and self.known:
            return self.pick(self.known)
        if roll < 0.58:
            return self.computed()
        if roll < 0.61:
            return self.pick(self.free)
        return self.pick((*SYMBOLS, *VALUES))

    def number(self) -> Datum:
        """A term that should be a number."""
        roll = self.rng.random()
        if roll < 0.25:
            return self.computed()
        if roll < 0.35 and self.known:
            return self.pick(self.known)
        return self.pick(NUMBERS) if roll < 0.97 else self.pick(WILD)

    def computed(self) -> Datum:
        """Arithmetic, resources, functions; at times ill-typed."""
        roll = self.rng.random()
        if roll < 0.2 and self.counters:
            return ("value", self.pick(self.counters))
        if roll < 0.3 and self.sets:
            return ("size-of", self.pick(self.sets))
        if roll < 0.5:
            name = self.pick(("twice", "look-up", "peek"))
            return (name, self.pick((*self.known, *SYMBOLS, *NUMBERS)))
        sign = self.pick(("+", "-", "*", "/"))
        return (sign, self.number(), self.pick((*NUMBERS, *self.known)))

    def time(self, most: int = 8) -> Datum:
        """A time: nearly always a small number."""
        roll = self.rng.random()
        if roll < 0.93:
            return str(self.rng.randrange(most + 1))
        return self.number()

    # --- formulas -------------------------------------------------------------------

    def formula(self, depth: int = 2) -> Datum:
        """A formula, nested at most so deep."""
        roll = self.rng.random()
        if depth > 0 and roll < 0.25:
            count = self.rng.randrange(1, 4)
            return ("and", *(self.formula(depth - 1) for _ in range(count)))
        if depth > 0 and roll < 0.33:
            count = self.rng.randrange(1, 3)
            return ("or", *(self.formula(depth - 1) for _ in range(count)))
        if depth > 0 and roll < 0.46:
            return ("not", self.formula(depth - 1))
        if roll < 0.56:
            return self.compare()
        if roll < 0.64:
            age = self.pick((*NUMBERS, *NUMBERS, "?u", "?w", "?", self.number()))
            return ("believe", self.pattern(), age)
        if roll < 0.70:
            return self.odd()
        return self.pattern()

    def watched(self) -> Datum:
        """A formula that what the script does makes true and false."""
        roll = self.rng.random()
        if roll < 0.25:
            return self.formula()
        name = self.pick(("p", "q", "b"))
        item = self.pick((*SYMBOLS, *self.known, "?u"))
        fact: Datum = (name, item)
        if name != "q":
            fact = (name, item, self.pick((*VALUES, "?v")))
        if roll < 0.55:
            fact = ("believe", fact, self.pick((*NUMBERS, *NUMBERS, "?w")))
        return ("not", fact) if self.chance(0.4) else fact

    def pattern(self) -> Datum:
        """A proposition or property, at times without its value."""
        if self.chance(0.3):
            name = self.pick(list(PROPOSITIONS))
            return (name, *(self.item() for _ in range(PROPOSITIONS[name])))
        name = self.pick(("p", "p", "p", *PROPERTIES))
        index = tuple(self.item() for _ in range(PROPERTIES[name]))
        return (
            (name, *index)
            if index and self.chance(0.1)
            else (name, *index, self.value())
        )

    def compare(self) -> Datum:
        """A comparison."""
        if self.chance(0.5):
            return (self.pick(("=", "n=")), self.ground(), self.ground())
        return (self.pick(("<", ">", "<=", ">=")), self.number(), self.number())

    def odd(self) -> Datum:
        """What is asked more rarely."""
        kind = self.rng.randrange(8)
        if kind == 0 and self.sets:
            return ("member", self.pick(self.sets), self.ground())
        if kind == 1 and self.sets:
            return ("empty", self.pick(self.sets))
        if kind == 2:
            return ("last-result", self.pick((*RESULTS, "?u")))
        if kind == 3:
            return ("method-tried", self.pick(self.methods))
        if kind == 4:
            result = self.pick((*RESULTS, "?v"))
            return ("result-with-method", self.pick(self.methods), result)
        if kind == 5:
            return ("odd", self.number())
        if kind == 6:
            value = self.pick(((), ("true",), ("false",)))
            return ("know-sensor-name", self.item(), *value)
        return self.pick(("true", "nil", "t", "false"))
