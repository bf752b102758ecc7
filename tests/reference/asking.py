"""Random libraries that ask about few things, so that their formulas often clash."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from typing import Any

import msgspec

from rapc.worlds.script import Row
from tests.reference.case import Case
from tests.reference.vocabulary import DECLARATIONS, SYMBOLS
from tests.reference.words import Datum

QUERIES: tuple[Datum, ...] = (
    ("define-query", ("near", "?i"), ("not", ("q", "?i"))),
    ("define-query", ("far", "?i"), ("and", ("q", "?i"), ("n=", "?i", "a"))),
)

VALUES = ("a", "1", "unknown", "false", "true", "?")


class Asking:
    """Formulas of a few shapes in a few variables.

    Args:
        rng: draws them.
        names: the terms that stand in them.
    """

    def __init__(self, rng: random.Random, names: Sequence[str]) -> None:
        self.rng = rng
        self._names = names
        some = rng.choice((1, 1, 2, 2, 3))
        self._shapes = [rng.choice(_SHAPES) for _ in range(some)]

    def name(self) -> str:
        """A variable or a symbol."""
        return self.rng.choice(self._names)

    def value(self) -> str:
        """What may stand for the value of a property."""
        return self.rng.choice((*self._names, *VALUES))

    def formula(self, depth: int = 2) -> Datum:
        """A formula, nested at most so deep."""
        roll = self.rng.random()
        if depth and roll < 0.55:
            many = self.rng.choice((2, 2, 3))
            return ("and", *(self.formula(depth - 1) for _ in range(many)))
        if depth and roll < 0.65:
            return ("or", self.formula(depth - 1), self.formula(depth - 1))
        if depth and roll < 0.85:
            return ("not", self.formula(depth - 1))
        return self.rng.choice(self._shapes)(self)


_SHAPES: tuple[Callable[[Asking], Datum], ...] = (
    lambda asking: ("q", asking.name()),
    lambda asking: ("q", asking.name()),
    lambda asking: ("r", asking.name(), asking.name()),
    lambda asking: ("p", asking.name(), asking.value()),
    lambda asking: ("b", asking.name(), asking.value()),
    lambda asking: ("k", asking.name(), asking.name(), asking.value()),
    lambda asking: ("mode", asking.value()),
    lambda asking: ("believe", ("p", asking.name(), asking.value()), "9"),
    lambda asking: ("believe", ("q", asking.name()), asking.rng.choice(("9", "?w"))),
    lambda asking: ("near", asking.name()),
    lambda asking: ("far", asking.name()),
    lambda asking: ("last-result", asking.rng.choice(("okay", "bad", "?u", "?"))),
    lambda asking: ("know-sensor-name", asking.name()),
    lambda asking: ("member", "?s", asking.name()),
    lambda asking: (asking.rng.choice("<>"), ("value", "?c"), asking.rng.choice("012")),
    lambda asking: (asking.rng.choice(("=", "n=")), asking.name(), asking.name()),
)


def asking(seed: int, runs: int) -> Sequence[Case]:
    """The cases of a seed: one library, with other facts in each."""
    rng = random.Random(f"{seed}:asking")
    free = rng.choice((("?x",), ("?x", "?y"), ("?x", "?y", "?z")))
    made = Asking(rng, ("?i", "a", *free * 2, rng.choice(("c", "?"))))
    forms = (*DECLARATIONS, *QUERIES, *_raps(made, free), *_rules(made))
    whole = Case(seed=seed, forms=forms, until=40, cycles=60)
    return [_begun(whole, random.Random(f"{seed}:{at}")) for at in range(runs)]


def _raps(made: Asking, free: Sequence[str]) -> Sequence[Datum]:
    rng = made.rng
    clauses: list[Datum] = [("resources", ("set", "?s"), ("counter", "?c"))]
    for name in ("monitor-state", "preconditions", "constraints", "repeat-while"):
        if rng.random() < 0.25:
            clauses.append((name, made.formula()))
    if rng.random() < 0.6:
        clauses.append(("succeed", rng.choice((made.formula(1), "nil"))))
    for at in range(rng.choice((1, 2, 2, 3))):
        own: list[Datum] = []
        if rng.random() < 0.85:
            own.append(("context", made.formula()))
        if rng.random() < 0.3:
            own.append(("constraints", made.formula()))
        clauses.append(("method", f"m{at}", *own, _net(made, free)))
    found = ("and", ("last-result", "okay"), ("p", "?i", "?o"))
    step: Datum = (
        *("define-rap", ("index", ("sub", "?i", "=>", "?o"))),
        *(("succeed", found), ("method", ("primitive", ("act", "?i")))),
    )
    return ("define-rap", ("index", ("r0", "?i")), *clauses), step


def _net(made: Asking, free: Sequence[str]) -> Datum:
    first = ("sub", "?i", "=>", made.rng.choice((*free, "?")))
    return (
        "task-net",
        ("t1", first, (made.formula(), "for", "t2"), ("set-add", "?s", "a")),
        ("t2", ("sub", "a", "=>", "?"), (made.formula(), "for", "t3")),
        ("t3", ("sub", "c", "=>", "?"), ("counter-add", "?c", "1")),
    )


def _rules(made: Asking) -> Sequence[Datum]:
    def rule() -> Datum:
        return ("rule", (made.formula(), ("mem-add", ("q", "a"))))

    return (
        (
            *("define-memory-rule", ("r0", "?i"), ":finish"),
            ("match-result", ("?y", rule())),
        ),
        (
            *("define-memory-rule", ("sub", "?y", "=>", "?x"), ":finish"),
            ("match-result", ("succeed", rule())),
        ),
        ("define-event-rule", (":go", "?x"), rule()),
    )


def _begun(case: Case, rng: random.Random) -> Case:
    host: list[tuple[Any, str, str]] = []
    for time in range(1, 12):
        if rng.random() < 0.5:
            host.append((time, rng.choice(("assert", "assert", "erase")), _fact(rng)))
        if rng.random() < 0.2:
            host.append((time, "signal", f"(:go {rng.choice(SYMBOLS)})"))
    rows = (Row(("act", "?x"), "bad", times=1, after=1),) * rng.randrange(2)
    return msgspec.structs.replace(
        case,
        rows=(*rows, Row(("act", "?x"), "okay", after=1)),
        facts=tuple([_fact(rng) for _ in range(rng.randrange(9))]),
        tasks=("(r0 a)", "(r0 c)"),
        host=tuple(host),
    )


def _fact(rng: random.Random) -> str:
    name = rng.choice(("q", "q", "r", "p", "p", "b", "k", "mode"))
    count = {"mode": 0, "k": 2, "r": 1, "q": 0}.get(name, 1)
    index = [rng.choice(SYMBOLS) for _ in range(count)]
    values = (*SYMBOLS, "1", "unknown", "true", "false")
    value = rng.choice(SYMBOLS if name in ("q", "r") else values)
    return f"({' '.join((name, *index, value))})"
