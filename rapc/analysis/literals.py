"""What formulas say taken apart: which cannot hold together, and which follow.

A conjunction is a row of literals: formulas that are to hold, or that are to have no
solution. Three questions are asked of such rows, and each is answered with yes only
where that is certain:

- Do two literals contradict each other? One fact that is asked and denied; a property
  with two values; tests that no value passes.
- Does a conjunction follow from literals that hold? It does if some choice of its own
  variables makes each literal one of these. So `(at ?any)` follows from
  `(at home)`.
- Does a formula that has no solution rule out literals? It does if it follows.

An example: a RAP with `(succeed (at ?place))` comes to choose a method only where this
has no solution. A context `(and (at ?place) (open ?door))` lets it follow, with nothing
to choose for `?place`, an input: the method is never chosen.

Variables with the same name are one variable, unless they are listed as free: whatever
a free variable stands for will do.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.base.source import Span
from rapc.base.values import Atom, Number
from rapc.ir import nodes
from rapc.ir.walk import variables
from rapc.library.signature import Signature

Relations = Mapping[str, Signature]
"""The propositions and properties of a library."""


class Literal(msgspec.Struct, frozen=True):
    """A formula that is to hold, or to have no solution."""

    formula: nodes.Formula
    holds: bool

    @property
    def span(self) -> Span:
        """Return where the formula stands."""
        return self.formula.span


class Clash(msgspec.Struct, frozen=True):
    """Two literals that never hold together, the later one in the text second."""

    first: Literal
    second: Literal


def literals(formula: nodes.Formula | None) -> Iterator[Literal]:
    """Yield the literals of a conjunction, from left to right."""
    stack = [] if formula is None else [formula]
    while stack:
        here = stack.pop()
        if isinstance(here, nodes.And):
            stack.extend(reversed(here.parts))
        elif isinstance(here, nodes.Not):
            yield Literal(here.part, False)
        else:
            yield Literal(here, True)


def names(formula: nodes.Formula) -> set[str]:
    """Return the names of the variables of a formula, the bare `?` left out."""
    return {var.name for var in variables(formula) if not var.anonymous}


def apart(formula: nodes.Formula, kept: Container[str], mark: str) -> nodes.Formula:
    """Return a formula whose variables that are not kept have names of their own."""
    found = names(formula)
    new = {name: f"{name}{mark}" for name in found if name not in kept}
    return _renamed(formula, new) if new else formula


def _renamed(formula: nodes.Formula, new: Mapping[str, str]) -> nodes.Formula:
    """Return a formula with other names of variables."""
    changed: dict[str, object] = {}
    for field in formula.__struct_fields__:
        value = getattr(formula, field)
        if isinstance(value, nodes.Node):
            changed[field] = _term_or_formula(value, new)
        elif type(value) is tuple and not field.endswith("span"):
            changed[field] = tuple(
                [
                    _term_or_formula(v, new) if isinstance(v, nodes.Node) else v
                    for v in value
                ]
            )
    return msgspec.structs.replace(formula, **changed) if changed else formula


def _term_or_formula(node: nodes.Node, new: Mapping[str, str]) -> nodes.Node:
    if isinstance(node, nodes.Var):
        name = new.get(node.name)
        return node if name is None else nodes.Var(name, node.span)
    if isinstance(node, nodes.Const):
        return node
    return _renamed(node, new)  # type: ignore[arg-type]  # no term: a formula


# --- what cannot hold together -----------------------------------------------------

MOST = 24
"""A conjunction with more literals than this is not looked at."""


class Conjunction:
    """Literals that hold together, put in one after another.

    Args:
        relations: the propositions and properties.
        given: the variables that have values before the first literal is asked.
    """

    def __init__(self, relations: Relations, given: Container[str]) -> None:
        self.held: list[Literal] = []
        self._relations = relations
        self._given = given
        self._denials = 0
        self._names: dict[int, set[str]] = {}
        self._values: dict[tuple[object, ...], Literal] = {}
        self._numbers: dict[nodes.Term, list[tuple[nodes.Compare, Literal]]] = {}

    def add(self, literal: Literal) -> Clash | None:
        """Put in a literal; return what it contradicts, if it does."""
        if len(self.held) >= MOST:
            return None
        found = self._against(literal)
        self.held.append(literal)
        self._denials += not literal.holds
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
        wanted = list(literals(literal.formula))
        if not all(_has_a_chance(goal, self.held) for goal in wanted):
            return None
        used = follows(wanted, self.held, self._own(literal, self.held))
        return used[-1] if used else None

    def _denied(self, literal: Literal) -> Literal | None:
        """A formula without a solution that a new literal makes follow."""
        everything = [*self.held, literal]
        for other in self.held:
            if not other.holds:
                wanted = list(literals(other.formula))
                if not any(_may_be(goal, literal) for goal in wanted):
                    continue
                own = self._own(other, everything)
                used = follows(wanted, everything, own)
                if used and literal in used:
                    return other
        return None

    def _own(self, literal: Literal, others: Iterable[Literal]) -> set[str]:
        """The variables that occur nowhere else: whatever they stand for will do."""
        own = {name for name in self._known(literal) if name not in self._given}
        for other in others if own else ():
            if other is not literal:
                own -= self._known(other)
        return own

    def _known(self, literal: Literal) -> set[str]:
        """The names of the variables of a literal, gathered once."""
        found = self._names.get(id(literal))
        if found is None:
            found = self._names[id(literal)] = names(literal.formula)
        return found

    def _other_value(self, fact: nodes.Proposition, literal: Literal) -> Literal | None:
        declared = self._relations.get(fact.name)
        if declared is None or not declared.is_property or declared.most is None:
            return None
        args = declared.full(fact.args)
        if len(args) != declared.most or any(_is_open(term) for term in args):
            return None
        index = (fact.name, *args[:-1])
        first = self._values.setdefault(index, literal)
        return (
            first
            if first is not literal and _apart(first, args[-1], declared)
            else None
        )

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
        return nodes.Compare(op, test.right, test.left, test.span)  # type: ignore[arg-type]  # a turned test has one of the six words
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
    floor, ceiling = number(low.right), number(high.right)
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
    left, right = number(nodes.Const(value)), number(test.right)
    return left is None or right is None or not holds_between(test.op, left, right)


def number(term: nodes.Term | None) -> Number | None:
    """Return the number that a term is; None for other terms."""
    value = term.value if isinstance(term, nodes.Const) else None
    return value if isinstance(value, int | float) else None


def holds_between(op: str, left: Number, right: Number) -> bool:
    """Whether a test of two numbers holds."""
    match op:
        case "<":
            return left < right
        case ">":
            return left > right
        case "<=":
            return left <= right
        case ">=":
            return left >= right
        case "=":
            return left == right
    return left != right


# --- what follows --------------------------------------------------------------------

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


def _has_a_chance(goal: Literal, held: Iterable[Literal]) -> bool:
    """Whether a literal holds by itself, or one that holds looks like it."""
    return _is_true(goal) or any(_may_be(goal, other) for other in held)


def _is_true(goal: Literal) -> bool:
    return isinstance(goal.formula, nodes.Truth) and goal.formula.value is goal.holds


def _may_be(goal: Literal, other: Literal) -> bool:
    """Whether a literal is of the kind and name that another has, whatever the rest."""
    if goal.holds is not other.holds:
        return False
    one, two = goal.formula, _fact(goal, other)
    if type(one) is not type(two):
        return False
    return not isinstance(one, nodes.Proposition) or one.name == two.name  # type: ignore[union-attr]  # of one type


def _fact(goal: Literal, other: Literal) -> nodes.Formula:
    """Return what a literal says; what is believed of a fact, where one is wanted."""
    fact = other.formula
    if isinstance(fact, nodes.Believe) and isinstance(goal.formula, nodes.Proposition):
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
            if not _may_be(goal, other):
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
                for field in nodes.compared(type(one))
            )
        return one == two

    def _takes(self, one: nodes.Var, two: nodes.Term, choice: _Choice) -> bool:
        if one.anonymous:
            return True
        if one.name not in self._free:
            return one == two
        return choice.setdefault(one.name, two) == two
