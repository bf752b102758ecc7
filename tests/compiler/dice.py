"""Random memories, and random formulas many of which have answers in them.

What is thrown depends on the seed and the size alone; hypothesis draws both, and
makes the size small where something fails.
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from hypothesis import strategies as st

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Atom, Fact, Text
from rapc.ir import nodes

from .memories import PROPERTIES, PROPOSITIONS, Change

ATOMS: Sequence[Atom] = ("a", "b", "c", "a", "b", "true", 1, 2, 1.5, Text("a"))
NAMES = ("?x", "?x", "?y", "?y", "?z")
PLACES = ("a", "b", "external")

T = TypeVar("T")


@dataclass
class Case:
    """A memory, formulas to ask of it, and what is bound beforehand."""

    changes: list[Change]
    parts: list[nodes.Formula]
    env: dict[str, Value]


class Dice:
    """Throws everything that a test of queries needs."""

    def __init__(self, seed: int) -> None:
        self.rng = random.Random(seed)
        self.known: list[Fact] = []

    def one(self, options: Sequence[T]) -> T:
        """One of some options."""
        return self.rng.choice(options)

    def odds(self, chance: float) -> bool:
        """True with some probability."""
        return self.rng.random() < chance

    # --- memories ----------------------------------------------------------------

    def changes(self, size: int) -> list[Change]:
        """The history of a memory."""
        return [self.change() for _ in range(size)]

    def change(self) -> Change:
        """One change of a memory."""
        verb = self.one(("assert",) * 10 + ("erase", "wait", "wait", "else"))
        if verb == "assert":
            fact = self.fact()
            self.known.append(fact)
            return verb, fact
        if verb == "erase":
            fact = self.one(self.known) if self.known else self.fact()
            return verb, fact[: self.rng.randint(1, len(fact))]
        if verb == "wait":
            return verb, self.one((1, 2, 0.5))
        what = self.one(("arrive", "arrive", "expire", "introduce", "introduce"))
        if what == "introduce":
            return what, (self.one("abi"), self.one(PLACES))
        return what, self.one(PLACES[:2])

    def fact(self) -> Fact:
        """A fact; a property may lack the value `true`."""
        name = self.one((*PROPERTIES, *PROPOSITIONS, "q", "p", "color", "location"))
        arity = PROPERTIES[name][0] if name in PROPERTIES else PROPOSITIONS[name]
        values: list[Atom] = [self.one(ATOMS) for _ in range(arity)]
        if name in ("location", "class"):
            values[0], values[-1] = self.one("abi"), self.one(PLACES)
        return (name, *values)

    def env(self) -> dict[str, Value]:
        """A variable bound in one case of three, and the set in most."""
        env: dict[str, Value] = {}
        if self.odds(0.3):
            env["?x"] = self.one((*ATOMS, Counter(self.rng.randint(0, 2))))
        if self.odds(0.8):
            members = [self.one(ATOMS) for _ in range(self.rng.randint(0, 3))]
            env["?set"] = SetResource(dict.fromkeys(members))
        return env

    # --- formulas ------------------------------------------------------------------

    def term(self, value: Atom | None = None) -> nodes.Term:
        """A term; `value` is one that would match."""
        throw = self.rng.random()
        if throw < 0.55:
            return nodes.Var(self.one(NAMES))
        if throw < 0.65:
            return nodes.Var("?")
        if throw < 0.70:
            return self.call()
        known = value is not None and throw < 0.92
        return nodes.Const(value if known and value is not None else self.one(ATOMS))

    def call(self) -> nodes.Call:
        """A computed term, often without a value."""
        function = self.one(("+", "-", "*", "/", "next-to", "value", "size-of"))
        if function == "size-of" and self.odds(0.7):
            return nodes.Call(function, (nodes.Var("?set"),))
        count = self.rng.randint(1, 3) if function in "+-*/" else 1
        args = [self.one((self.term(), nodes.Const(2))) for _ in range(count)]
        return nodes.Call(function, tuple(args))

    def pattern(self) -> nodes.Proposition:
        """A proposition or property that often matches a fact that is there."""
        fact = self.one(self.known) if self.known and self.odds(0.8) else self.fact()
        name, *values = fact
        short = name in PROPERTIES and 1 < len(values) == PROPERTIES[str(name)][0]
        if short and values[-1] == "true" and self.odds(0.7):
            values = values[:-1]
        return nodes.Proposition(str(name), tuple(self.term(value) for value in values))

    def test(self) -> nodes.Formula:
        """A formula that is no connective and no proposition."""
        one, two, three = self.term(), self.term(), self.term()
        flag = nodes.Const(self.one(("true", "false")))
        method: Atom = self.one(("one", "no"))
        in_set = nodes.Var("?set")
        ops: Any = ("=", "n=", "<", ">", "<=", ">=")
        options: Sequence[nodes.Formula] = (
            nodes.Compare(self.one(ops), one, two),
            nodes.Compare(self.one(ops), one, two),
            nodes.Is(one, two),
            nodes.SetTest("member", (in_set, one)),
            nodes.SetTest("empty", (in_set,)),
            nodes.HistoryTest("method-tried", (nodes.Const(method),)),
            nodes.HistoryTest(
                "last-result", (self.one((one, nodes.Const("dropped"))),)
            ),
            nodes.HistoryTest(
                "result-with-method", (self.one((nodes.Const(2), one)), two)
            ),
            nodes.SensorName(one, self.one((flag, two))),
            nodes.SensorName(one, flag),
            nodes.Count(nodes.Const("thing"), nodes.Const(self.one(PLACES)), one),
            nodes.Count(one, two, three),
            nodes.Truth(self.odds(0.5)),
            nodes.Proposition("odd", (one,)),
        )
        return self.one(options)

    def simple(self) -> nodes.Formula:
        """A formula without connectives."""
        throw = self.rng.random()
        if throw < 0.6:
            return self.pattern()
        if throw < 0.75:
            age = self.one((nodes.Const(3), nodes.Const(1), nodes.Const(0)))
            return nodes.Believe(self.pattern(), self.one((age, self.term())))
        return self.test()

    def formula(self, leaves: int) -> nodes.Formula:
        """A formula with about so many parts that are no connectives."""
        if leaves <= 1:
            inner = self.simple()
            return nodes.Not(inner) if self.odds(0.15) else inner
        shares = self.shares(leaves)
        parts = tuple(self.formula(share) for share in shares)
        if self.odds(0.1):
            return nodes.Not(nodes.And(parts))
        return nodes.Or(parts) if self.odds(0.45) else nodes.And(parts)

    def shares(self, whole: int) -> list[int]:
        """A number as a sum of smaller ones, and now and then none at all."""
        if self.odds(0.03):
            return []
        found = []
        while whole > 0:
            found.append(self.rng.randint(1, max(1, whole - 1)))
            whole -= found[-1]
        return found


@st.composite
def dice(draw: st.DrawFn) -> Dice:
    """Dice with any seed."""
    return Dice(draw(st.integers(0, 2**40)))


sizes = st.integers(0, 30)
"""How many changes a memory has seen."""
