"""Random terms: variables of a RAP, constants, computed terms."""

from __future__ import annotations

import random
from collections.abc import Collection, Sequence
from typing import Any

from tests.reference.vocabulary import NUMBERS, SYMBOLS, VALUES, WILD

Datum = Any
"""A word, or a tuple of data."""


class Words:
    """Where the random terms of one RAP or method come from.

    `wild` is the share of oddities that are let through, from 0 to 1. `known` are
    variables likely to be bound, `free` others; `sets` and `counters` are resources,
    `queries` the named queries that may be used, `forms` the kinds of forms.
    """

    def __init__(self, rng: random.Random, wild: float, known: Sequence[str]) -> None:
        self.rng = rng
        self.wild = wild
        self.known = list(known)
        self.free = ["?u", "?v", "?w"]
        self.sets: list[str] = []
        self.counters: list[str] = []
        self.queries: Sequence[str] = ()
        self.forms: Collection[str] = ()

    def inner(self, known: Sequence[str] | None = None) -> Words:
        """The words for a part of this, which may come to know more variables."""
        inner = Words(self.rng, self.wild, self.known if known is None else known)
        inner.sets, inner.counters = self.sets, self.counters
        inner.queries, inner.forms = self.queries, self.forms
        return inner

    def among(self, kind: str, share: float) -> bool:
        """True in this share of cases where a kind of forms is used."""
        return kind in self.forms and self.chance(share)

    def chance(self, share: float) -> bool:
        """True in this share of cases."""
        return self.rng.random() < share

    def odd(self, share: float) -> bool:
        """True in this share of cases, fewer where little is wild."""
        return self.rng.random() < share * self.wild

    def pick(self, words: Sequence[Datum]) -> Datum:
        """One of some words."""
        return words[self.rng.randrange(len(words))]

    # --- terms --------------------------------------------------------------------

    def item(self) -> Datum:
        """What a fact may be about."""
        if self.known and self.chance(0.35):
            return self.pick(self.known)
        if self.chance(0.2):
            return self.pick((*self.free, *self.free, "?"))
        return self.pick(WILD) if self.odd(0.05) else self.pick(SYMBOLS)

    def value(self) -> Datum:
        """What a fact may say."""
        if self.known and self.chance(0.15):
            return self.pick(self.known)
        if self.chance(0.4):
            return self.pick((*self.free, *self.free, "?"))
        if self.odd(0.08):
            return self.computed()
        return self.pick(WILD) if self.odd(0.08) else self.pick(VALUES)

    def ground(self) -> Datum:
        """A term that should have a value."""
        if self.known and self.chance(0.5):
            return self.pick(self.known)
        if self.odd(0.2):
            return self.computed()
        if self.odd(0.06):
            return self.pick(self.free)
        return self.pick((*SYMBOLS, *VALUES))

    def number(self) -> Datum:
        """A term that should be a number."""
        if self.chance(0.2):
            return self.computed()
        if self.known and self.odd(0.15):
            return self.pick(self.known)
        return self.pick(WILD) if self.odd(0.04) else self.pick(NUMBERS)

    def computed(self) -> Datum:
        """Arithmetic, resources, functions; at times ill-typed."""
        if self.counters and self.chance(0.4):
            return ("value", self.pick(self.counters))
        if self.sets and self.chance(0.3):
            return ("size-of", self.pick(self.sets))
        if self.chance(0.3):
            name = self.pick(("twice", "look-up", "peek"))
            return (name, self.pick((*self.known, *SYMBOLS, *NUMBERS)))
        if self.chance(0.05):
            return ("-", self.number())
        sign = self.pick(("+", "-", "*", "/"))
        last = self.pick((*NUMBERS, *self.known) if self.odd(1) else ("1", "2", "3"))
        return (sign, self.number(), last)

    def time(self, most: int = 8) -> Datum:
        """A time: nearly always a small number."""
        return self.number() if self.odd(0.1) else str(self.rng.randrange(most + 1))
