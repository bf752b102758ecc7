"""Formulas as conjunctions of literals: entailment, contradiction, queried facts.

A literal is a formula that is to hold, or that is to have no solution. `follows`
searches for the literals that entail a conjunction. `Conjunction` adds literals in
order and finds contradictions. Both return a result only where the result is certain.

A conjunction follows if some choice of its own variables turns each of its literals
into a literal that holds. For example, `(at ?any)` follows from `(at home)`. A formula
that has no solution rules out the literals that entail the formula.

Example: a RAP with `(succeed (at ?place))` chooses a method only if this formula has no
solution. A context `(and (at ?place) (open ?door))` entails the formula, and no value
is chosen for `?place`, an input. For this reason the method is never chosen.

Variables with the same name are one variable, unless the variables are listed as free.
A free variable may stand for any value. A variable takes a value only where memory has
a fact with the value: the default of a property holds for a known index, and no query
or function states its subjects [L 2.21].

A denial follows from another denial in the opposite direction: `(not (at ?place))`
follows from `(not (at ?))`, because `(at ?)` follows from `(at ?place)`.

Two literals contradict each other in three cases: one fact is queried and denied; a
property has two values; no value passes both of two tests.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.facts.statistics import LIMITS
from rapc.base.source import Span
from rapc.base.values import Atom, Number, holds_between
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.schema import operands
from rapc.ir.walk import substitute, through_queries, variable_names
from rapc.library.library import Library
from rapc.library.signature import Signature
from rapc.library.signatures import Signatures


class Literal(msgspec.Struct, frozen=True):
    """A formula that is to hold, or to have no solution."""

    formula: nodes.Formula
    holds: bool

    @property
    def span(self) -> Span:
        """Return the span of the formula."""
        return self.formula.span

    @property
    def written(self) -> str:
        """Return the literal as RAP text."""
        written = format_formula(self.formula)
        return written if self.holds else f"(not {written})"


def fact_name(literal: Literal) -> str:
    """Return the name of the fact of a literal; empty for a literal without a fact."""
    fact = literal.formula
    return fact.name if isinstance(fact, nodes.Proposition) else ""


def literals(formula: nodes.Formula | None) -> list[Literal]:
    """Return the literals of a conjunction, from left to right."""
    if type(formula) is nodes.And:
        return [one for part in formula.parts for one in literals(part)]
    if type(formula) is nodes.Not:
        return [Literal(formula.part, False)]
    return [] if formula is None else [Literal(formula, True)]


def expanded(library: Library, found: Iterable[Literal]) -> Iterator[Literal]:
    """Yield literals with the formulas of queries in place of queries that hold.

    A belief counts as its fact: the fact was just asserted.
    """
    left = [(one, LIMITS.query_depth) for one in reversed(list(found))]
    number = 0
    while left:
        one, depth = left.pop()
        fact = one.formula
        if isinstance(fact, nodes.Believe):
            fact = fact.pattern
        name = fact.name if isinstance(fact, nodes.Proposition) else ""
        query = library.queries.get(name) if one.holds and depth else None
        if query is None or not isinstance(fact, nodes.Proposition):
            yield Literal(fact, one.holds)
            continue
        number += 1
        names = [argument.variable.name for argument in query.args]
        inner = apart(query.formula, names, f"@{number}")
        asked = substitute(inner, dict(zip(names, fact.args, strict=False)))
        left += [(part, depth - 1) for part in reversed(literals(asked))]


def conjunction(found: Iterable[Literal]) -> nodes.Formula:
    """Return the formula that requires some literals."""
    return nodes.And(
        tuple([f.formula if f.holds else nodes.Not(f.formula) for f in found])
    )


def is_never(formula: nodes.Formula | None) -> bool:
    """Return whether a formula is never true by its form: `nil`, `(not true)`."""
    if isinstance(formula, nodes.Not):
        return isinstance(formula.part, nodes.Truth) and formula.part.value
    return isinstance(formula, nodes.Truth) and not formula.value


def apart(formula: nodes.Formula, kept: Container[str], mark: str) -> nodes.Formula:
    """Return a formula with new names for the variables that are not kept."""
    new = {n: nodes.Var(f"{n}{mark}") for n in variable_names(formula) if n not in kept}
    return substitute(formula, new) if new else formula


def entails(
    held: Sequence[Literal],
    formula: nodes.Formula,
    given: Container[str],
    relations: Relations,
) -> bool:
    """Return whether a formula surely holds where the literals `held` hold.

    The variables of the formula that are not in `given` may have any value.
    """
    wanted = apart(formula, given, "@wanted")
    free = {name for name in variable_names(wanted) if name not in given}
    return bool(follows(literals(wanted), held, free, relations))


def number_of(term: nodes.Term | None) -> Number | None:
    """Return the number of a term; None for other terms."""
    value = term.value if isinstance(term, nodes.Const) else None
    return value if isinstance(value, int | float) else None


Relations = Mapping[str, Signature]
"""The propositions and properties of a library."""


def follows(
    wanted: Sequence[Literal],
    held: Sequence[Literal],
    free: Container[str],
    relations: Relations,
    given: Container[str] | None = None,
) -> list[Literal] | None:
    """Return the literals that entail a conjunction, or None if none is found.

    Args:
        wanted: the literals of the conjunction.
        held: the literals that hold, in the order of evaluation.
        free: the variables of `wanted` that may have any value.
        relations: the propositions and properties.
        given: the variables of `held` that have values before; None for all.
    """
    if not wanted or len(wanted) > len(held) + LIMITS.true_literals:
        return None
    if not all(has_a_chance(goal, held) for goal in wanted):
        return None
    return _Search(relations, given, LIMITS.entailment_pairs).find(
        _Aim(wanted, held, free)
    )


_Choice = dict[str, nodes.Term]


def has_a_chance(goal: Literal, held: Iterable[Literal]) -> bool:
    """Return whether a literal is always true, or has a similar literal in `held`."""
    return _is_true(goal) or any(may_be(goal, other) for other in held)


def _is_true(goal: Literal) -> bool:
    return isinstance(goal.formula, nodes.Truth) and goal.formula.value is goal.holds


def may_be(goal: Literal, other: Literal) -> bool:
    """Return whether two literals have the same type and name."""
    if goal.holds is not other.holds:
        return False
    one, two = goal.formula, _fact(goal, other)
    if type(one) is nodes.Proposition:
        return type(two) is nodes.Proposition and one.name == two.name
    return type(one) is type(two)


def _fact(goal: Literal, other: Literal) -> nodes.Formula:
    """Return the formula of a literal; the pattern of a belief if a fact is wanted."""
    fact = other.formula
    if type(fact) is nodes.Believe and type(goal.formula) is nodes.Proposition:
        return fact.pattern if other.holds else fact
    return fact


class _Aim(msgspec.Struct, frozen=True):
    """The wanted literals, the literals that hold, and the free variables."""

    wanted: Sequence[Literal]
    held: Sequence[Literal]
    free: Container[str]


class _Match(msgspec.Struct, frozen=True):
    """The state of a comparison of a wanted literal with a literal that holds."""

    #: The variables of the wanted literal that may take a value.
    free: Container[str]
    #: The variables of the other literal without a value at the evaluation.
    late: Container[str]
    #: The values chosen for variables so far.
    choice: _Choice


class _Search:
    """A search for values of free variables, with a limit on its work.

    Args:
        relations: the propositions and properties.
        given: the variables of `held` that have values before; None for all.
        tries: the maximum number of pairs of literals to compare.
    """

    def __init__(
        self, relations: Relations, given: Container[str] | None, tries: int
    ) -> None:
        self._relations = relations
        self._given = given
        self._left = tries

    def find(self, aim: _Aim) -> list[Literal] | None:
        """Return the literals that match the wanted literals, or None."""
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
        """Return whether a denial follows from another denial."""
        denied = literals(substitute(goal.formula, choice))
        inner = _Search(self._relations, self._given, self._left)
        late = self._late(other, aim.held)
        turned = _Aim(literals(other.formula), denied, late)
        found = inner.find(turned) is not None
        self._left = inner._left
        return found

    def _late(self, held: Literal, before: Iterable[Literal]) -> set[str]:
        """Return the variables of a held literal without a value at the evaluation."""
        return set() if self._given is None else unbound(held, before, self._given)

    def _alike(self, one: object, two: object, match: _Match) -> bool:
        """Return whether a wanted formula equals a held formula, by a choice."""
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
        if isinstance(one, nodes.Compare) and isinstance(two, nodes.Compare):
            other, held = turned(one), turned(two)
            if implies(held, other) and _same(
                other.left, held.left, match.free, match.choice
            ):
                return True
        if isinstance(one, nodes.Or | nodes.And) and isinstance(two, type(one)):
            pairs = zip(one.parts, two.parts, strict=False)
            return len(one.parts) == len(two.parts) and all(
                self._alike(a, b, match) for a, b in pairs
            )
        return _same(one, two, None, match.choice)

    def _one_fact(
        self, one: nodes.Proposition, two: nodes.Proposition, match: _Match
    ) -> bool:
        """Return whether a fact equals a held fact; a default needs a known index."""
        choice, declared = match.choice, self._relations.get(one.name)
        if one.name != two.name:
            return False
        if declared is None:
            return self._one_query(one.args, two.args, match)
        terms, others = declared.full(one.args), declared.full(two.args)
        index = match.free if self._is_stored(two) else None
        return _same_row(terms[:-1], others[:-1], index, choice) and _same_row(
            terms[-1:], others[-1:], match.free, choice
        )

    def _one_query(
        self, ones: Sequence[nodes.Term], twos: Sequence[nodes.Term], match: _Match
    ) -> bool:
        """Return whether a query or function equals a held one.

        A variable without a value is only equal to one that had no value, either.
        """
        choice = match.choice
        if len(ones) != len(twos):
            return False
        for one, two in zip(ones, twos, strict=True):
            is_open = isinstance(two, nodes.Var) and (
                two.anonymous or two.name in match.late
            )
            free = match.free if is_open else None
            if not _same(one, two, free, choice):
                return False
        return True

    def _one_age(self, one: nodes.Believe, two: nodes.Believe, match: _Match) -> bool:
        """Return whether a wanted age follows from a held age.

        A variable without a value takes the age of a stored fact. A variable with a
        value is a bound, and no fact is younger than its own age [L 2.51, 2.56].
        """
        choice, age, other = match.choice, one.age, two.age
        is_free = isinstance(age, nodes.Var) and (
            age.anonymous or (age.name in match.free and age.name not in choice)
        )
        if not is_free:
            known = not isinstance(other, nodes.Var)
            limit, held = number_of(age), number_of(other)
            if limit is not None and held is not None:
                return held <= limit
            return known and _same(age, other, None, choice)
        if not isinstance(other, nodes.Var) or other.name not in match.late:
            other = nodes.Var("?")
        return self._is_stored(two.pattern) and _same(age, other, match.free, choice)

    def _is_stored(self, fact: nodes.Proposition) -> bool:
        """Return whether a fact that holds is stored in memory, not a default."""
        declared = self._relations.get(fact.name)
        if declared is None or not declared.is_property:
            return declared is not None
        terms = declared.full(fact.args)
        value = terms[-1] if len(terms) == declared.most else None
        return (
            isinstance(value, nodes.Const)
            and declared.default_function is None
            and value.value != declared.default
        )


def unbound(
    literal: Literal, held: Iterable[Literal], given: Container[str]
) -> set[str]:
    """Return the variables of a literal that have no value at the evaluation.

    Args:
        literal: the literal.
        held: the literals evaluated before, up to `literal` itself if present.
        given: the variables that have values before the first literal.
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
    """Return whether two terms, or formulas, are equal by a choice of variables.

    Args:
        one: the wanted term.
        two: the term that holds.
        free: the variables that may take a value; None: no variable may, not even a
            bare `?`.
        choice: the values of variables; new values are added.
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


class Clash(msgspec.Struct, frozen=True):
    """Two literals that never hold together; the second is later in the text."""

    first: Literal
    second: Literal


def may_clash(
    found: Sequence[Literal], relations: Relations, *, for_any_terms: bool = False
) -> bool:
    """Return whether some literals may contradict each other, by their names.

    Candidates are two facts of one property, two tests of one term, or a denied formula
    and literals that resemble all of its parts.

    Args:
        found: the literals.
        relations: the propositions and properties.
        for_any_terms: whether variables may stand for any terms.
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
            declared = relations.get(formula.name)
            if declared is not None and declared.is_property:
                topic = formula.name
        elif type(formula) is nodes.Compare:
            topic = nodes.Compare if for_any_terms else turned(formula).left
        if topic is not None and topic in topics:
            return True
        topics.add(topic)
    return False


class _Denial(msgspec.Struct, frozen=True):
    """A formula without a solution, and the literals that cannot all hold."""

    literal: Literal
    wanted: Sequence[Literal]
    #: The variables of `wanted` without a value; any value will do.
    free: Container[str]


class Conjunction:
    """Literals that hold together, added in the order of evaluation.

    Args:
        relations: the propositions and properties.
        given: the variables that have values before the first literal is evaluated.
    """

    def __init__(self, relations: Relations, given: Container[str]) -> None:
        self.held: list[Literal] = []
        self._relations = relations
        self._given = given
        self._denials: list[_Denial] = []
        #: By name: the first fact that holds, and its literal.
        self._earliest: dict[str, tuple[nodes.Proposition, Literal]] = {}
        #: By name and arguments of a property: the first literal with its value.
        self._values: dict[tuple[object, ...], Literal] = {}
        self._numbers: dict[nodes.Term, list[tuple[nodes.Compare, Literal]]] = {}

    def add(self, literal: Literal) -> Clash | None:
        """Add a literal; return the literal that contradicts it, if any."""
        if len(self.held) >= LIMITS.conjunction:
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
        """Return a held literal that a new denial contradicts, if any."""
        own = unbound(literal, self.held, self._given)
        new = {name: nodes.Var(f"{name}@not") for name in own}
        wanted = literals(substitute(literal.formula, new))
        denial = _Denial(literal, wanted, {one.name for one in new.values()})
        self._denials.append(denial)
        if not all(has_a_chance(goal, self.held) for goal in wanted):
            return None
        used = self._follows(denial, self.held)
        return used[-1] if used else None

    def _denied(self, literal: Literal) -> Literal | None:
        """Return a denied formula that follows with the new literal."""
        for denial in self._denials:
            if not any(may_be(goal, literal) for goal in denial.wanted):
                continue
            used = self._follows(denial, [*self.held, literal])
            if used and literal in used:
                return denial.literal
        return None

    def _follows(self, denial: _Denial, held: Sequence[Literal]) -> list[Literal]:
        """Return the literals that entail the denied formula, or an empty list."""
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
            return None  # no value to compare with
        self._first(declared, *earliest)
        first = self._first(declared, fact, literal)
        if first is literal or first is None:
            return None
        return first if _apart(first, declared.full(fact.args)[-1], declared) else None

    def _first(
        self, declared: Signature, fact: nodes.Proposition, literal: Literal
    ) -> Literal | None:
        """Return the first literal with a value for the subject of a fact.

        None if the fact does not determine the subject or the value.
        """
        args = declared.full(fact.args)
        if len(args) != declared.most or any(_is_open(term) for term in args):
            return None
        return self._values.setdefault((fact.name, *args[:-1]), literal)

    def _other_bound(self, test: nodes.Compare, literal: Literal) -> Literal | None:
        mine = turned(test)
        earlier = self._numbers.setdefault(mine.left, [])
        for other, where in earlier:
            if _exclude(other, mine):
                return where
        earlier.append((mine, literal))
        return None


def _apart(first: Literal, value: nodes.Term, declared: Signature) -> bool:
    """Return whether an earlier fact of the same property has a different constant."""
    fact = first.formula
    if isinstance(fact, nodes.Believe):
        fact = fact.pattern
    assert isinstance(fact, nodes.Proposition)
    other = declared.full(fact.args)[-1]
    if not isinstance(other, nodes.Const) or not isinstance(value, nodes.Const):
        return False
    return other != value and not _stands_for_another(fact, (other, value))


def _stands_for_another(fact: nodes.Proposition, values: Iterable[nodes.Const]) -> bool:
    """Return whether a location is `external`, that is, the robot's place [L 7]."""
    return fact.name == "location" and any(v.value == "external" for v in values)


def _is_open(term: nodes.Term) -> bool:
    return isinstance(term, nodes.Var) and term.anonymous


_TURNED: Mapping[str, str] = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}


def turned(test: nodes.Compare) -> nodes.Compare:
    """Return a test with its constant, if there is a constant, on the right."""
    if isinstance(test.left, nodes.Const) and not isinstance(test.right, nodes.Const):
        op = _TURNED.get(test.op, test.op)
        return nodes.Compare(op, test.right, test.left, span=test.span)  # type: ignore[arg-type]  # a turned test has one of the six words
    return test


def _exclude(one: nodes.Compare, other: nodes.Compare) -> bool:
    """Return whether no value passes two tests of one term."""
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


def implies(one: nodes.Compare, other: nodes.Compare) -> bool:
    """Return whether a test with a number passes only values that pass another test.

    The tests are of one term, with the number on the right.
    """
    bound, limit = number_of(one.right), number_of(other.right)
    if bound is None or limit is None:
        return False
    if one.op == "=":
        return holds_between(other.op, bound, limit)
    if other.op == "n=":
        return one.op in _TURNED and not holds_between(one.op, limit, bound)
    if one.op not in _TURNED or other.op not in _TURNED or one.op[0] != other.op[0]:
        return False
    inner = holds_between(f"{other.op[0]}", bound, limit)
    return inner or (bound == limit and (one.op == other.op or "=" in other.op))


_OPPOSITE = {
    ("=", "n="),
    ("=", "<"),
    ("=", ">"),
    ("<", ">"),
    ("<", ">="),
    ("<=", ">"),
}
"""Pairs of tests of the same two terms that never hold together."""


def _misses(value: Atom, test: nodes.Compare) -> bool:
    """Return whether a constant fails a test against another constant."""
    assert isinstance(test.right, nodes.Const)
    bound = test.right.value
    if test.op in ("=", "n="):
        return (value == bound) is (test.op == "n=")
    left, right = number_of(nodes.Const(value)), number_of(test.right)
    return left is None or right is None or not holds_between(test.op, left, right)


def contradict(signatures: Signatures, one: Literal, other: Literal) -> bool:
    """Return whether two literals never hold together, for any values of variables."""
    given = variable_names(one.formula, other.formula)
    both = Conjunction(signatures.relations, given)
    both.add(one)
    return both.add(other) is not None


# --- facts that a formula queries -----------------------------------------------------


def is_computed(library: Library, name: str) -> bool:
    """Return whether a name is the name of a function or a query, not of a fact."""
    return name in library.functions or name in library.queries


_PLAIN = (
    nodes.Truth,
    nodes.Proposition,
    nodes.And,
    nodes.Or,
    nodes.Not,
    nodes.Compare,
    nodes.Believe,
)


def is_known(library: Library, formula: nodes.Formula) -> bool:
    """Return whether a formula queries only facts, also through named queries."""
    return all(
        isinstance(one, _PLAIN)
        and not (isinstance(one, nodes.Proposition) and one.name in library.functions)
        for one in through_queries(formula, library.queries)
    )


def asked_through(library: Library, formula: nodes.Formula) -> set[str] | None:
    """Return the names of the queried facts; None if not only facts are queried."""
    return asked_by(library, formula) if is_known(library, formula) else None


def asked_by(library: Library, formula: nodes.Formula) -> set[str]:
    """Return the names of the facts that a formula queries, also through queries."""
    if type(formula) is nodes.Proposition and formula.name not in library.queries:
        return {formula.name}
    return {
        one.name
        for one in through_queries(formula, library.queries)
        if isinstance(one, nodes.Proposition)
    }


class Always:
    """Formulas that hold for any content of memory.

    Args:
        signatures: the declarations.
    """

    def __init__(self, signatures: Signatures) -> None:
        self._relations = signatures.predicates

    def holds(self, formula: nodes.Formula, given: set[str]) -> bool:
        """Return whether a formula always holds if variables `given` have values."""
        bound = set(given)
        return all(
            literal.holds and self._one(literal.formula, bound)
            if not isinstance(literal.formula, nodes.Truth)
            else literal.formula.value is literal.holds
            for literal in literals(formula)
        )

    def _one(self, formula: nodes.Formula, bound: set[str]) -> bool:
        if isinstance(formula, nodes.Or):
            holds = any(self.holds(part, bound) for part in formula.parts)
            bound.update(variable_names(formula))
            return holds
        if not isinstance(formula, nodes.Proposition):
            return False
        declared = self._relations.get(formula.name)
        if declared is None or not _has_default(declared):
            return False
        terms = declared.full(formula.args)
        if len(terms) != declared.most:
            return False
        value = terms[-1]
        fresh = isinstance(value, nodes.Var) and value.name not in bound
        known = all(
            isinstance(term, nodes.Const)
            or (isinstance(term, nodes.Var) and term.name in bound)
            for term in terms[:-1]
        )
        bound.update(v.name for v in operands(formula).matched if type(v) is nodes.Var)
        return fresh and known


def _has_default(declared: Signature) -> bool:
    return declared.is_property and declared.default_function is None
