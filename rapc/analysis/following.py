"""Which conjunctions follow from literals that hold: a search that says yes if certain.

A conjunction follows if some choice of its own variables makes each of its literals one
of those that hold. So `(at ?any)` follows from `(at home)`. And a formula that has no
solution rules out the literals from which it follows.

An example: a RAP with `(succeed (at ?place))` comes to choose a method only where this
has no solution. A context `(and (at ?place) (open ?door))` lets it follow, with nothing
to choose for `?place`, an input: the method is never chosen.

Variables with the same name are one variable, unless they are listed as free: whatever
a free variable stands for will do. A variable takes a value only where memory has a
fact for it: the default of a property holds of an index that is known, and no query
or function says of what it holds [L 2.21].

A denial follows from another one the other way round: `(not (at ?place))` follows from
`(not (at ?))`, for `(at ?)` follows from `(at ?place)`.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping, Sequence

import msgspec

from rapc.analysis.literals import Literal, literals
from rapc.ir import nodes
from rapc.ir.walk import substitute, variable_names
from rapc.library.signature import CONSTANT_DEFAULTS, Signature

_TRIES = 300
"""How many pairs of literals are held against each other for one question."""

Relations = Mapping[str, Signature]
"""The propositions and properties of a library."""


def follows(
    wanted: Sequence[Literal],
    held: Sequence[Literal],
    free: Container[str],
    relations: Relations,
    given: Container[str] | None = None,
) -> list[Literal] | None:
    """Return the literals from which a conjunction follows, or None if it may not.

    Args:
        wanted: the literals of the conjunction.
        held: what holds, in the order in which it is asked.
        free: the variables of `wanted` for which anything will do.
        relations: the propositions and properties.
        given: the variables of `held` that have values before; None: all of them.
    """
    if not wanted or len(wanted) > len(held) + _TRUE_LITERALS:
        return None
    return _Search(relations, given, _TRIES).find(_Aim(wanted, held, free))


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
        return fact.pattern if other.holds else fact
    return fact


class _Aim(msgspec.Struct, frozen=True):
    """What is to follow, from what, and which variables may stand for anything."""

    wanted: Sequence[Literal]
    held: Sequence[Literal]
    free: Container[str]


class _Match(msgspec.Struct, frozen=True):
    """What is known where a wanted literal is held against one that holds."""

    #: The variables of the wanted one that may take a value.
    free: Container[str]
    #: The variables of the other one that have no value where it is asked.
    late: Container[str]
    #: What variables have taken so far.
    choice: _Choice


class _Search:
    """A search for values of free variables, with a bound on its work.

    Args:
        relations: the propositions and properties.
        given: the variables of what holds that have values before; None: all.
        tries: how many pairs of literals may be held against each other.
    """

    def __init__(
        self, relations: Relations, given: Container[str] | None, tries: int
    ) -> None:
        self._relations = relations
        self._given = given
        self._left = tries

    def find(self, aim: _Aim) -> list[Literal] | None:
        """Return the literals that the wanted ones become, or None."""
        used: list[Literal] = []
        return used if self._find(aim, 0, {}, used) else None

    def _find(self, aim: _Aim, at: int, choice: _Choice, used: list[Literal]) -> bool:
        if at == len(aim.wanted):
            return True
        goal = aim.wanted[at]
        if _is_true(goal):
            return self._find(aim, at + 1, choice, used)
        for other in aim.held:
            self._left -= 1
            if self._left < 0:
                return False
            if not may_be(goal, other):
                continue
            extended = dict(choice)
            if goal.holds:
                late = self._late(other, aim.held)
                match = _Match(aim.free, late, extended)
                found = self._alike(goal.formula, _fact(goal, other), match)
            else:
                found = self._denies(goal, other, aim, choice)
            if found:
                used.append(other)
                if self._find(aim, at + 1, extended, used):
                    return True
                used.pop()
        return False

    def _denies(
        self, goal: Literal, other: Literal, aim: _Aim, choice: _Choice
    ) -> bool:
        """Whether a denial follows from another: what it denies leads to the other."""
        denied = list(literals(substitute(goal.formula, choice)))
        inner = _Search(self._relations, None, self._left)
        late = self._late(other, aim.held)
        turned = _Aim(list(literals(other.formula)), denied, late)
        found = inner.find(turned) is not None
        self._left = inner._left
        return found

    def _late(self, held: Literal, before: Iterable[Literal]) -> set[str]:
        """The variables of what holds that have no value where it is asked."""
        return set() if self._given is None else unbound(held, before, self._given)

    def _alike(self, one: object, two: object, match: _Match) -> bool:
        """Whether a wanted formula is one that holds, by a choice of variables."""
        if isinstance(one, nodes.Proposition) and isinstance(two, nodes.Proposition):
            return self._one_fact(one, two, match)
        if isinstance(one, nodes.Believe) and isinstance(two, nodes.Believe):
            return self._one_fact(one.pattern, two.pattern, match) and self._one_age(
                one, two, match
            )
        if isinstance(one, nodes.HistoryTest) and isinstance(two, nodes.HistoryTest):
            return (
                one.query == two.query
                and _same_row(one.args[:-1], two.args[:-1], None, match.choice)
                and _same_row(one.args[-1:], two.args[-1:], match.free, match.choice)
            )
        if isinstance(one, nodes.Or | nodes.And) and isinstance(two, type(one)):
            pairs = zip(one.parts, two.parts, strict=False)
            return len(one.parts) == len(two.parts) and all(
                self._alike(a, b, match) for a, b in pairs
            )
        return _same(one, two, None, match.choice)

    def _one_fact(
        self, one: nodes.Proposition, two: nodes.Proposition, match: _Match
    ) -> bool:
        """Whether a fact is another one; a default holds of a known index alone."""
        choice, declared = match.choice, self._relations.get(one.name)
        if one.name != two.name or declared is None:
            return one.name == two.name and _same_row(one.args, two.args, None, choice)
        terms, others = declared.full(one.args), declared.full(two.args)
        index = match.free if self._is_stored(two) else None
        return _same_row(terms[:-1], others[:-1], index, choice) and _same_row(
            terms[-1:], others[-1:], match.free, choice
        )

    def _one_age(self, one: nodes.Believe, two: nodes.Believe, match: _Match) -> bool:
        """Whether an age is another one.

        A variable without a value takes the age of a fact that is stored; one with a
        value is a bound, and no fact is younger than its own age [L 2.51, 2.56].
        """
        choice, age, other = match.choice, one.age, two.age
        is_free = isinstance(age, nodes.Var) and (
            age.anonymous or (age.name in match.free and age.name not in choice)
        )
        if not is_free:
            known = not isinstance(other, nodes.Var)
            return known and _same(age, other, None, choice)
        if not isinstance(other, nodes.Var) or other.name not in match.late:
            other = nodes.Var("?")
        return self._is_stored(two.pattern) and _same(age, other, match.free, choice)

    def _is_stored(self, fact: nodes.Proposition) -> bool:
        """Whether memory has a fact where one holds: no default can be meant."""
        declared = self._relations.get(fact.name)
        if declared is None or not declared.is_property:
            return declared is not None
        terms = declared.full(fact.args)
        value = terms[-1] if len(terms) == declared.most else None
        return (
            isinstance(value, nodes.Const)
            and declared.default in CONSTANT_DEFAULTS
            and value.value != declared.default
        )


def unbound(
    literal: Literal, held: Iterable[Literal], given: Container[str]
) -> set[str]:
    """Return the variables of a literal that have no value where it is asked.

    Args:
        literal: the literal.
        held: what is asked before it, up to the literal itself if it is among them.
        given: the variables that have values before all of that.
    """
    own = {name for name in variable_names(literal.formula) if name not in given}
    for other in held if own else ():
        if other is literal:
            break
        if other.holds:
            own.difference_update(variable_names(other.formula))
    return own


def _same_row(
    ones: Sequence[nodes.Term],
    twos: Sequence[nodes.Term],
    free: Container[str] | None,
    choice: _Choice,
) -> bool:
    pairs = zip(ones, twos, strict=False)
    return len(ones) == len(twos) and all(_same(a, b, free, choice) for a, b in pairs)


def _same(
    one: object, two: object, free: Container[str] | None, choice: _Choice
) -> bool:
    """Whether two terms, or formulas, are one by a choice of variables.

    Args:
        one: what is wanted.
        two: what holds.
        free: the variables that may take what is there; None: nothing may, not even
            a bare `?`.
        choice: what variables have taken; what they take here is put in.
    """
    if isinstance(one, nodes.Var):
        if one.name in choice or one.name not in (free or ()):
            wanted = choice.get(one.name, one)
            return wanted == two or (one.anonymous and free is not None)
        assert isinstance(two, nodes.Term)
        is_open = isinstance(two, nodes.Var) and two.anonymous
        choice[one.name] = nodes.Var(f"{one.name} ?") if is_open else two
        return True
    if isinstance(one, tuple) and isinstance(two, tuple):
        pairs = zip(one, two, strict=False)
        same = len(one) == len(two)
        return same and all(_same(a, b, free, choice) for a, b in pairs)
    if type(one) is type(two) and isinstance(one, nodes.Node):
        return all(
            _same(getattr(one, field), getattr(two, field), free, choice)
            for field in nodes.compared_fields(type(one))
        )
    return one == two
