"""Operators for planning: what RAPs with `effects` need and bring about.

The planner sees facts, named queries, ages of beliefs, and whether two values are
equal. All other parts of a formula are left out: the planner takes them to hold, and
the model lists them. [T 7.4.1; L 10]
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count
from typing import Literal as Word
from typing import NamedTuple

from rapc.base.limits import MAX_BRANCHES
from rapc.base.resources import Value
from rapc.base.source import Span
from rapc.base.values import Atom, Number, Text
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.ir.walk import given_names, substitute, variable_names
from rapc.library.library import Library
from rapc.library.signatures import Signatures

Name = str | tuple[str, Number]
"""The name of a fact; with an age for a fact that must be younger than the age."""

Term = Atom | nodes.Var
"""A constant or a variable."""

FRESH = "?("
"""The beginning of the names of new variables, which no text can contain."""


class Pattern(NamedTuple):
    """A fact with variables."""

    name: Name
    args: tuple[Term, ...]


class Equality(NamedTuple):
    """Two terms that must be equal, or different."""

    equal: bool
    left: Term
    right: Term


class Conjunction(NamedTuple):
    """A conjunction of facts: all that are present, and none of the absent parts."""

    present: tuple[Pattern, ...] = ()
    absent: tuple[Conjunction, ...] = ()
    equalities: tuple[Equality, ...] = ()

    def and_also(self, other: Conjunction) -> Conjunction:
        """Return the conjunction of both."""
        return Conjunction(
            self.present + other.present,
            self.absent + other.absent,
            self.equalities + other.equalities,
        )


class Effect(NamedTuple):
    """A fact that an operator brings about, erases, or makes uncertain.

    A None in `args` stands for an unknown value: any value.
    """

    sort: Word["add", "erase", "may"]
    name: str
    args: tuple[Term | None, ...]


class LeftOut(NamedTuple):
    """A part of a RAP that the planner does not see."""

    rap: str
    clause: str
    part: nodes.Node
    reason: str

    @property
    def span(self) -> Span:
        """Return the position of the part."""
        return self.part.span

    def __str__(self) -> str:
        if isinstance(self.part, nodes.DefineRap):
            return f"`{self.rap}` is no operator: {self.reason}"
        return f"{self.clause} of `{self.rap}`: {format_node(self.part)}: {self.reason}"


class Operator(NamedTuple):
    """A RAP with `effects`, as an operator; a RAP has one for each branch."""

    rap: nodes.DefineRap
    conditions: Conjunction
    effects: tuple[Effect, ...]
    #: The cost of a step; a term that is computed for each instance, or a number.
    cost: nodes.Term | Number
    #: The kinds of inputs and outputs by variable.
    kinds: Mapping[str, str]
    #: The facts that only give the cost a value, from those that must be present.
    weighed: frozenset[Pattern] = frozenset()


class Model:
    """The operators of a library, and the parts of their RAPs that are left out.

    Args:
        library: the library.
        signatures: its declarations.
        use: the names of the RAPs that may be used; None for each RAP with `effects`.
    """

    def __init__(
        self,
        library: Library,
        signatures: Signatures,
        use: Iterable[str] | None = None,
    ) -> None:
        self.library, self.signatures = library, signatures
        self.left_out: list[LeftOut] = []
        self._fresh = count(1)
        self._rap, self._clause = "", ""
        self._hidden: frozenset[str] = frozenset()
        #: The values by which a property has no asserted value.
        self.defaults: dict[str, Atom] = {
            name: form.default
            for name, form in library.properties.items()
            if form.default not in library.functions
        }
        names = library.raps if use is None else dict.fromkeys(use)
        raps = [library.raps[name] for name in names if name in library.raps]
        self.operators = [
            operator for rap in raps if rap.effects for operator in self._operators(rap)
        ]

    def goal(
        self, rap: nodes.DefineRap, values: Mapping[str, Value] | None = None
    ) -> list[Conjunction]:
        """Return the branches of the `succeed` of a RAP.

        Args:
            rap: the RAP.
            values: the values of its inputs; without them the inputs stay variables.
        """
        constants = constants_of(values or {})
        known = {one.name for one in rap.inputs} if values is None else constants.keys()
        self._hidden = frozenset(given_names(rap)) - known
        if rap.succeed is None:
            return []
        return self._clause_of(rap.name, "succeed", substitute(rap.succeed, constants))

    # --- RAPs ----------------------------------------------------------------------

    def _operators(self, rap: nodes.DefineRap) -> Iterator[Operator]:
        """Yield the operators of a RAP with `effects`."""
        given = {one.name for one in (*rap.inputs, *rap.outputs)}
        self._hidden = frozenset(one.variable.name for one in rap.resources)
        branches = [Conjunction()]
        if rap.preconditions is not None:
            branches = self._clause_of(rap.name, "preconditions", rap.preconditions)
        missing = self._unused_input(rap)
        if missing is not None:
            reason = f"no condition or effect has `{missing}`"
            self.left_out.append(LeftOut(rap.name, "index", rap, reason))
            return
        bound = given.union(*[_names(branch) for branch in branches])
        own = (*self._achieved(rap, given), *self._declared(rap, bound))
        effects = tuple(dict.fromkeys(own))
        if rap.constraints is not None:
            names = set(variable_names(rap.constraints)) - given
            formula = substitute(rap.constraints, {n: self._variable() for n in names})
            required = self._clause_of(rap.name, "constraints", formula)
            branches = self._product([branches, required], rap.constraints)
        cost = self._cost(rap, bound)
        kinds = {one.variable: one.kind for one in rap.kinds}
        brought = {(one.name, one.args) for one in effects if one.sort == "add"}
        useful = [
            branch
            for branch in branches
            if not any((one.name, one.args) in brought for one in branch.present)
        ]
        for branch in useful or branches:
            weighed = _weighed(branch, effects, cost, given)
            yield Operator(rap, branch, effects, cost, kinds, weighed)

    def _cost(self, rap: nodes.DefineRap, bound: set[str]) -> nodes.Term | Number:
        """Return the cost of a RAP: its duration, 1 without one."""
        if rap.duration is None:
            return 1
        constant = _number(rap.duration)
        if constant is not None:
            return max(constant, 0)
        unknown = set(variable_names(rap.duration)) - (bound - self._hidden)
        if not unknown:
            return rap.duration
        names = ", ".join([f"`{name}`" for name in sorted(unknown)])
        reason = f"{names} has no value before the step"
        self.left_out.append(LeftOut(rap.name, "duration", rap.duration, reason))
        return 1

    def _unused_input(self, rap: nodes.DefineRap) -> str | None:
        """Return an input whose value no condition and no effect determines."""
        clauses = [rap.preconditions, rap.constraints, rap.succeed]
        asked = [one for one in clauses if one is not None]
        named = variable_names(*asked, *[one.pattern for one in rap.effects])
        return next((v.name for v in rap.inputs if v.name not in named), None)

    def _achieved(self, rap: nodes.DefineRap, given: set[str]) -> Iterator[Effect]:
        """Yield the effects of the first branch of `succeed` that consists of facts."""
        ways = (
            rap.succeed.parts if isinstance(rap.succeed, nodes.Or) else (rap.succeed,)
        )
        for way in ways:
            parts = way.parts if isinstance(way, nodes.And) else (way,)
            found = [self._fact(part, given) for part in parts]
            if all(found):
                for one in found:
                    if one is not None and None not in one.args:
                        yield one
                return

    def _fact(self, part: nodes.Formula | None, given: set[str]) -> Effect | None:
        """Return a fact or a negated fact as an effect, or None."""
        sort: Word["add", "erase"] = "add"
        if isinstance(part, nodes.Not):
            part, sort = part.part, "erase"
        if not isinstance(part, nodes.Proposition) or not self._is_relation(part.name):
            return None
        return Effect(sort, part.name, self._effect_args(part, given))

    def _declared(self, rap: nodes.DefineRap, bound: set[str]) -> Iterator[Effect]:
        """Yield the effects that a RAP declares."""
        for one in rap.effects:
            sort: Word["add", "erase", "may"] = "erase" if one.negated else "add"
            if one.possible:
                sort = "may"
            if self._is_relation(one.pattern.name):
                args = self._effect_args(one.pattern, bound - self._hidden)
                yield Effect(sort, one.pattern.name, args)

    # --- formulas ------------------------------------------------------------------

    def _clause_of(
        self, rap: str, clause: str, formula: nodes.Formula
    ) -> list[Conjunction]:
        """Return the branches of a clause."""
        self._rap, self._clause = rap, clause
        return self._branches(formula, ())

    def _branches(
        self, formula: nodes.Formula, queries: tuple[str, ...]
    ) -> list[Conjunction]:
        """Return the branches of a formula; `queries` are those that contain it."""
        match formula:
            case nodes.Truth():
                found = [Conjunction()] if formula.value else []
            case nodes.And():
                parts = [self._branches(part, queries) for part in formula.parts]
                found = self._product(parts, formula)
            case nodes.Or():
                every = [self._branches(part, queries) for part in formula.parts]
                found = list(dict.fromkeys([one for part in every for one in part]))
                if len(found) > MAX_BRANCHES:
                    found = self._leave(formula, "too many branches")
            case nodes.Not():
                found = self._negated(formula, queries)
            case nodes.Believe() if _number(formula.age) is not None:
                found = self._pattern(formula.pattern, queries, _number(formula.age))
            case nodes.Proposition():
                found = self._pattern(formula, queries)
            case nodes.Is():
                found = self._equality(True, formula, formula.variable, formula.value)
            case nodes.Compare(op="=" | "n="):
                equal = formula.op == "="
                found = self._equality(equal, formula, formula.left, formula.right)
            case _:
                found = self._leave(formula, _UNSEEN.get(type(formula), "not a fact"))
        return found

    def _pattern(
        self,
        part: nodes.Proposition,
        queries: tuple[str, ...],
        age: Number | None = None,
    ) -> list[Conjunction]:
        query = self.library.queries.get(part.name)
        if query is not None and age is None:
            if part.name in queries:
                return self._leave(part, "a query that contains itself")
            given = [arg.variable.name for arg in query.args]
            terms = dict(zip(given, map(self._named, part.args), strict=False))
            for variable in variable_names(query.formula):
                terms.setdefault(variable, self._variable())
            formula = substitute(query.formula, terms)
            return self._branches(formula, (*queries, part.name))
        if not self._is_relation(part.name):
            return self._leave(part, "a function")
        args = []
        for arg in self._full(part):
            term = self._term(arg)
            if term is None:
                return self._leave(part, "a computed value")
            args.append(term)
        name: Name = part.name if age is None else (part.name, age)
        return [Conjunction((Pattern(name, tuple(args)),))]

    def _equality(
        self, equal: bool, part: nodes.Formula, left: nodes.Term, right: nodes.Term
    ) -> list[Conjunction]:
        one, other = self._term(left), self._term(right)
        if one is None or other is None:
            return self._leave(part, "a computed value")
        return [Conjunction((), (), (Equality(equal, one, other),))]

    def _negated(
        self, formula: nodes.Not, queries: tuple[str, ...]
    ) -> list[Conjunction]:
        """Return a negation: no branch of its part may hold."""
        before = len(self.left_out)
        branches = self._branches(formula.part, queries)
        if len(self.left_out) > before:
            reason = self.left_out[before].reason
            del self.left_out[before:]
            return self._leave(formula, reason)
        if any(not any(branch) for branch in branches):
            return []
        return [Conjunction((), tuple(branches))]

    def _product(
        self, parts: list[list[Conjunction]], formula: nodes.Formula
    ) -> list[Conjunction]:
        found = [Conjunction()]
        for branches in parts:
            if len(found) * len(branches) > MAX_BRANCHES:
                return self._leave(formula, "too many branches")
            found = [one.and_also(other) for one in found for other in branches]
        return found

    def _leave(self, part: nodes.Formula, reason: str) -> list[Conjunction]:
        """Leave a part out: it is taken to hold."""
        self.left_out.append(LeftOut(self._rap, self._clause, part, reason))
        return [Conjunction()]

    # --- terms ---------------------------------------------------------------------

    def _term(self, term: nodes.Term) -> Term | None:
        """Return a term, or None for a term that the planner cannot see."""
        if isinstance(term, nodes.Const):
            return term.value
        if isinstance(term, nodes.Var) and term.name not in self._hidden:
            return self._variable() if term.anonymous else nodes.Var(term.name)
        return None

    def _named(self, term: nodes.Term) -> nodes.Term:
        """Return a term with a new variable in place of a bare `?`."""
        bare = isinstance(term, nodes.Var) and term.anonymous
        return self._variable() if bare else term

    def _variable(self) -> nodes.Var:
        """Return a new variable, which no text can contain."""
        return nodes.Var(f"{FRESH}{next(self._fresh)}")

    def _is_relation(self, name: str) -> bool:
        return name in self.signatures.relations

    def _full(self, part: nodes.Proposition) -> Sequence[nodes.Term]:
        """Return all arguments of a fact, with the value of a truth property."""
        return self.signatures.relations[part.name].full(part.args)

    def _effect_args(
        self, part: nodes.Proposition, bound: set[str]
    ) -> tuple[Term | None, ...]:
        """Return the arguments of an effect: None for each unknown value."""
        found: list[Term | None] = []
        for arg in self._full(part):
            if isinstance(arg, nodes.Const):
                found.append(arg.value)
            else:
                known = isinstance(arg, nodes.Var) and arg.name in bound
                found.append(nodes.Var(arg.name) if known else None)  # type: ignore[union-attr]
        return tuple(found)


_UNSEEN: Mapping[type[nodes.Node], str] = {
    nodes.Compare: "a comparison of numbers",
    nodes.Believe: "an age that is not constant",
    nodes.HistoryTest: "the history of the task",
    nodes.SetTest: "a set",
    nodes.SensorName: "a sensor name",
    nodes.Count: "a number of items",
    nodes.Otherwise: "the other methods",
}
"""Why a part of another type is left out."""


def _number(term: nodes.Term) -> Number | None:
    """Return the value of a term, or None for any term but a constant number."""
    value = term.value if isinstance(term, nodes.Const) else None
    return value if isinstance(value, int | float) else None


def constants_of(values: Mapping[str, Value]) -> dict[str, nodes.Const]:
    """Return the values that are no sets or counters as constants."""
    return {
        name: nodes.Const(value)
        for name, value in values.items()
        if isinstance(value, str | int | float | Text)
    }


def _weighed(
    branch: Conjunction,
    effects: Iterable[Effect],
    cost: nodes.Term | Number,
    given: set[str],
) -> frozenset[Pattern]:
    """Return the facts with a variable that only the cost has besides."""
    if isinstance(cost, int | float):
        return frozenset()
    used = [arg.name for e in effects for arg in e.args if isinstance(arg, nodes.Var)]
    counts = Counter([*variables_of(branch), *used, *given])
    own = {name for name in variable_names(cost) if counts[name] == 1}
    return frozenset(
        [one for one in branch.present if own & _names(Conjunction((one,)))]
    )


def variables_of(part: Conjunction) -> Iterator[str]:
    """Yield the names of all variables of a conjunction, each as often as it occurs."""
    for pattern in part.present:
        yield from [arg.name for arg in pattern.args if isinstance(arg, nodes.Var)]
    for inner in part.absent:
        yield from variables_of(inner)
    for _, left, right in part.equalities:
        yield from [one.name for one in (left, right) if isinstance(one, nodes.Var)]


def _names(found: Conjunction) -> set[str]:
    """Return the names of the variables in the present facts of a conjunction."""
    args = [arg for one in found.present for arg in one.args]
    return {arg.name for arg in args if isinstance(arg, nodes.Var)}
