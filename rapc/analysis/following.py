"""Which conjunctions follow from literals that hold: a search that says yes if certain.

A conjunction follows if some choice of its own variables makes each of its literals one
of those that hold. So `(at ?any)` follows from `(at home)`. And a formula that has no
solution rules out the literals from which it follows.

An example: a RAP with `(succeed (at ?place))` comes to choose a method only where this
has no solution. A context `(and (at ?place) (open ?door))` lets it follow, with nothing
to choose for `?place`, an input: the method is never chosen.

Variables with the same name are one variable, unless they are listed as free: whatever
a free variable stands for will do.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence

from rapc.analysis.literals import Literal
from rapc.ir import nodes

_TRIES = 300
"""How many pairs of literals are held against each other for one question."""


def follows(
    wanted: Sequence[Literal], held: Sequence[Literal], free: Container[str]
) -> list[Literal] | None:
    """Return the literals from which a conjunction follows, or None if it may not.

    Args:
        wanted: the literals of the conjunction.
        held: what holds.
        free: the variables of `wanted` for which anything will do.
    """
    if not wanted or len(wanted) > len(held) + _TRUE_LITERALS:
        return None
    return _Search(held, free).find(wanted)


_TRUE_LITERALS = 8
"""How many literals that hold by themselves a conjunction may have."""

_Choice = dict[str, nodes.Term]


def has_a_chance(goal: Literal, held: Iterable[Literal]) -> bool:
    """Whether a literal holds by itself, or one that holds looks like it."""
    return _is_true(goal) or any(may_be(goal, other) for other in held)


def _is_true(goal: Literal) -> bool:
    return isinstance(goal.formula, nodes.Truth) and goal.formula.value is goal.holds


def may_be(goal: Literal, other: Literal) -> bool:
    """Whether a literal is of the kind and name that another has, whatever the rest."""
    if goal.holds is not other.holds:
        return False
    one, two = goal.formula, _fact(goal, other)
    if type(one) is nodes.Proposition:
        return type(two) is nodes.Proposition and one.name == two.name
    if type(one) is nodes.Compare:
        return type(two) is nodes.Compare and one.op == two.op
    return type(one) is type(two)


def _fact(goal: Literal, other: Literal) -> nodes.Formula:
    """Return what a literal says; what is believed of a fact, where one is wanted."""
    fact = other.formula
    if type(fact) is nodes.Believe and type(goal.formula) is nodes.Proposition:
        return fact.pattern
    return fact


class _Search:
    """A search for values of free variables, with a bound on its work."""

    def __init__(self, held: Sequence[Literal], free: Container[str]) -> None:
        self._held = held
        self._free = free
        self._left = _TRIES

    def find(self, wanted: Sequence[Literal]) -> list[Literal] | None:
        """Return the literals that `wanted` become, or None."""
        used: list[Literal] = []
        return used if self._find(wanted, 0, {}, used) else None

    def _find(
        self, wanted: Sequence[Literal], at: int, choice: _Choice, used: list[Literal]
    ) -> bool:
        if at == len(wanted):
            return True
        goal = wanted[at]
        if _is_true(goal):
            return self._find(wanted, at + 1, choice, used)
        for other in self._held:
            self._left -= 1
            if self._left < 0:
                return False
            if not may_be(goal, other):
                continue
            extended = dict(choice)
            if self._alike(goal.formula, _fact(goal, other), extended):
                used.append(other)
                if self._find(wanted, at + 1, extended, used):
                    return True
                used.pop()
        return False

    def _alike(self, one: object, two: object, choice: _Choice) -> bool:
        if isinstance(one, nodes.Var) and isinstance(two, nodes.Term):
            return self._takes(one, two, choice)
        if isinstance(one, tuple) and isinstance(two, tuple):
            pairs = zip(one, two, strict=False)
            same = len(one) == len(two)
            return same and all(self._alike(a, b, choice) for a, b in pairs)
        if type(one) is type(two) and isinstance(one, nodes.Node):
            return all(
                self._alike(getattr(one, field), getattr(two, field), choice)
                for field in nodes.compared_fields(type(one))
            )
        return one == two

    def _takes(self, one: nodes.Var, two: nodes.Term, choice: _Choice) -> bool:
        if one.anonymous:
            return True
        if one.name not in self._free:
            return one == two
        return choice.setdefault(one.name, two) == two
