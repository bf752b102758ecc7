"""Which literals cannot hold together.

Two literals contradict each other if one fact is asked and denied, if a property has
two values, or if no value passes both of two tests. Only what is certain is told.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence

import msgspec

from rapc.analysis.following import Relations, follows, has_a_chance, may_be, unbound
from rapc.analysis.literals import Literal, holds_between, literals, number_of
from rapc.base.values import Atom
from rapc.ir import nodes
from rapc.ir.walk import substitute
from rapc.library.signature import Signature


class Clash(msgspec.Struct, frozen=True):
    """Two literals that never hold together, the later one in the text second."""

    first: Literal
    second: Literal


def may_clash(found: Sequence[Literal]) -> bool:
    """Whether some literals may contradict each other, as far as their names tell.

    Two facts of one name may, or two tests of one term, or what has no solution and
    literals that look like all of its parts.
    """
    topics: set[object] = set()
    for literal in found:
        formula = literal.formula
        topic: object = None
        if not literal.holds:
            goals = literals(formula)
            if all(has_a_chance(goal, found) for goal in goals):
                return True
            continue
        if type(formula) is nodes.Believe:
            formula = formula.pattern
        if type(formula) is nodes.Proposition:
            topic = formula.name
        elif type(formula) is nodes.Compare:
            topic = _turned(formula).left
        if topic is not None and topic in topics:
            return True
        topics.add(topic)
    return False


MOST = 24
"""A conjunction with more literals than this is not looked at."""


class _Denial(msgspec.Struct, frozen=True):
    """What has no solution, and the literals that then do not all hold."""

    literal: Literal
    wanted: Sequence[Literal]
    #: The variables of `wanted` that have no value: whatever they stand for will do.
    free: Container[str]


class Conjunction:
    """Literals that hold together, added in the order of evaluation.

    Args:
        relations: the propositions and properties.
        given: the variables that have values before the first literal is asked.
    """

    def __init__(self, relations: Relations, given: Container[str]) -> None:
        self.held: list[Literal] = []
        self._relations = relations
        self._given = given
        self._denials: list[_Denial] = []
        #: By name: the first fact that holds, and what says so.
        self._earliest: dict[str, tuple[nodes.Proposition, Literal]] = {}
        #: By name and arguments of a property: the first literal that says its value.
        self._values: dict[tuple[object, ...], Literal] = {}
        self._numbers: dict[nodes.Term, list[tuple[nodes.Compare, Literal]]] = {}

    def add(self, literal: Literal) -> Clash | None:
        """Put in a literal; return what it contradicts, if it does."""
        if len(self.held) >= MOST:
            return None
        found = self._against(literal)
        self.held.append(literal)
        return Clash(found, literal) if found is not None else None

    def _against(self, literal: Literal) -> Literal | None:
        formula = literal.formula
        if not literal.holds:
            return self._ruled_out(literal)
        if isinstance(formula, nodes.Believe):
            formula = formula.pattern
        if isinstance(formula, nodes.Proposition):
            found = self._other_value(formula, literal)
            if found is not None:
                return found
        if isinstance(formula, nodes.Compare):
            found = self._other_bound(formula, literal)
            if found is not None:
                return found
        return self._denied(literal) if self._denials else None

    def _ruled_out(self, literal: Literal) -> Literal | None:
        """A literal from which a formula that has no solution would follow."""
        own = unbound(literal, self.held, self._given)
        new = {name: nodes.Var(f"{name}@not") for name in own}
        wanted = list(literals(substitute(literal.formula, new)))
        denial = _Denial(literal, wanted, {one.name for one in new.values()})
        self._denials.append(denial)
        if not all(has_a_chance(goal, self.held) for goal in wanted):
            return None
        used = self._follows(denial, self.held)
        return used[-1] if used else None

    def _denied(self, literal: Literal) -> Literal | None:
        """A formula without a solution that a new literal makes follow."""
        for denial in self._denials:
            if not any(may_be(goal, literal) for goal in denial.wanted):
                continue
            used = self._follows(denial, [*self.held, literal])
            if used and literal in used:
                return denial.literal
        return None

    def _follows(self, denial: _Denial, held: Sequence[Literal]) -> list[Literal]:
        """Return the literals from which the denied formula follows, if it does."""
        return (
            follows(denial.wanted, held, denial.free, self._relations, self._given)
            or []
        )

    def _other_value(self, fact: nodes.Proposition, literal: Literal) -> Literal | None:
        declared = self._relations.get(fact.name)
        if declared is None or not declared.is_property or declared.most is None:
            return None
        earliest = self._earliest.setdefault(fact.name, (fact, literal))
        if earliest[1] is literal:
            return None  # nothing to hold it against
        self._first(declared, *earliest)
        first = self._first(declared, fact, literal)
        if first is literal or first is None:
            return None
        return first if _apart(first, declared.full(fact.args)[-1], declared) else None

    def _first(
        self, declared: Signature, fact: nodes.Proposition, literal: Literal
    ) -> Literal | None:
        """Return the first literal that says the value of what a fact is about.

        None if the fact does not say which thing it is about, or which value.
        """
        args = declared.full(fact.args)
        if len(args) != declared.most or any(_is_open(term) for term in args):
            return None
        return self._values.setdefault((fact.name, *args[:-1]), literal)

    def _other_bound(self, test: nodes.Compare, literal: Literal) -> Literal | None:
        turned = _turned(test)
        earlier = self._numbers.setdefault(turned.left, [])
        for other, where in earlier:
            if _exclude(other, turned):
                return where
        earlier.append((turned, literal))
        return None


def _apart(first: Literal, value: nodes.Term, declared: Signature) -> bool:
    """Whether an earlier fact of the same property has another constant."""
    fact = first.formula
    if isinstance(fact, nodes.Believe):
        fact = fact.pattern
    assert isinstance(fact, nodes.Proposition)
    other = declared.full(fact.args)[-1]
    if not isinstance(other, nodes.Const) or not isinstance(value, nodes.Const):
        return False
    return other != value and not _stands_for_another(fact, (other, value))


def _stands_for_another(fact: nodes.Proposition, values: Iterable[nodes.Const]) -> bool:
    """Whether an item can have two values: `external` is where the robot is [L 7]."""
    return fact.name == "location" and any(v.value == "external" for v in values)


def _is_open(term: nodes.Term) -> bool:
    return isinstance(term, nodes.Var) and term.anonymous


_TURNED: Mapping[str, str] = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}


def _turned(test: nodes.Compare) -> nodes.Compare:
    """Return a test with its constant, if it has one, to the right."""
    if isinstance(test.left, nodes.Const) and not isinstance(test.right, nodes.Const):
        op = _TURNED.get(test.op, test.op)
        return nodes.Compare(op, test.right, test.left, span=test.span)  # type: ignore[arg-type]  # a turned test has one of the six words
    return test


def _exclude(one: nodes.Compare, other: nodes.Compare) -> bool:
    """Whether no value passes two tests of one term."""
    if one.right == other.right:
        return (one.op, other.op) in _OPPOSITE or (other.op, one.op) in _OPPOSITE
    if not isinstance(one.right, nodes.Const) or not isinstance(
        other.right, nodes.Const
    ):
        return False
    if one.op == "=":
        return _misses(one.right.value, other)
    if other.op == "=":
        return _misses(other.right.value, one)
    low, high = (one, other) if one.op in (">", ">=") else (other, one)
    if low.op not in (">", ">=") or high.op not in ("<", "<="):
        return False
    floor, ceiling = number_of(low.right), number_of(high.right)
    return floor is not None and ceiling is not None and floor > ceiling


_OPPOSITE = {
    ("=", "n="),
    ("=", "<"),
    ("=", ">"),
    ("<", ">"),
    ("<", ">="),
    ("<=", ">"),
}
"""Tests of the same two terms of which at most one holds."""


def _misses(value: Atom, test: nodes.Compare) -> bool:
    """Whether a constant does not pass a test against another constant."""
    assert isinstance(test.right, nodes.Const)
    bound = test.right.value
    if test.op in ("=", "n="):
        return (value == bound) is (test.op == "n=")
    left, right = number_of(nodes.Const(value)), number_of(test.right)
    return left is None or right is None or not holds_between(test.op, left, right)
