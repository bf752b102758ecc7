"""Variables that formulas need and bind [L 2], and the sites that bind variables.

`BindingWalker` computes the variables that a formula needs and surely binds:

- `and` binds from left to right.
- `or` surely binds the variables that each branch that can succeed binds.
- `not` exports no bindings.
- Comparisons, computed terms, tests of sets and functions used as tests bind no
  variables, and their variables must be bound.
- A named query treats its terms as its formula treats the arguments.

`rapc.analysis.facts.variables` determines the position of each formula and the
variables bound before the formula.

A named query stands for its formula, with terms in place of the arguments. The
arguments that need a value, and the arguments that the formula surely binds, depend on
the arguments that have a value at the use. For this reason a query is walked once for
each set of arguments with values that occurs. The queries that a query uses are walked
first, without recursion in Python, so that a chain of queries may be long. In a cycle,
which another check reports, a query is treated like a fact.

`sites` yields the places where a variable gets, or may get, a value. `sites` is slower
and simpler, and is used only for RAPs that may have a fault.
"""

from __future__ import annotations

from collections.abc import (
    Callable,
    Container,
    Iterable,
    Iterator,
    Mapping,
    Sequence,
    Set,
)

import msgspec

from rapc.base.source import Span
from rapc.ir import clauses, nodes
from rapc.ir.schema import operands
from rapc.ir.walk import FormulaAt, formulas

Key = tuple[str, frozenset[str]]
"""The name of a query, and the arguments that have a value."""


class QueryBindings(msgspec.Struct, frozen=True):
    """The summary of a query for one set of arguments with values."""

    #: The arguments that need a value and do not surely have a value.
    needs: Set[str]
    #: The arguments that have a value wherever the query holds.
    binds: Set[str]
    #: Whether the query can hold.
    possible: bool


class _UnknownError(Exception):
    """A request for a summary that must be computed first."""

    def __init__(self, key: Key) -> None:
        super().__init__(key)
        self.key = key


Summarize = Callable[[nodes.DefineQuery, frozenset[str]], QueryBindings]
"""Walks the formula of a query once; calls `Summaries.known` for inner queries."""


class Summaries:
    """The summaries of the queries of a library, computed on request.

    Args:
        queries: the queries by name.
    """

    def __init__(self, queries: Mapping[str, nodes.DefineQuery]) -> None:
        self.queries = queries
        self._known: dict[Key, QueryBindings] = {}
        #: The pending summaries; each summary is needed by the preceding summary.
        self._asking: dict[Key, None] = {}

    def known(
        self, name: str, given: frozenset[str], summarize: Summarize
    ) -> QueryBindings:
        """Return the summary of a query if the arguments in `given` have a value.

        Args:
            name: the query.
            given: the arguments with a value.
            summarize: walks the formula of one query.
        """
        key = (name, given)
        found = self._known.get(key)
        if found is not None:
            return found
        if self._asking:
            raise _UnknownError(key)
        self._work_out(key, summarize)
        return self._known[key]

    def _work_out(self, key: Key, summarize: Summarize) -> None:
        """Walk a query, after all queries that its formula uses."""
        self._asking[key] = None
        while self._asking:
            name, given = here = next(reversed(self._asking))
            try:
                self._known[here] = summarize(self.queries[name], given)
                del self._asking[here]
            except _UnknownError as wanted:
                if wanted.key in self._asking:
                    query = self.queries[wanted.key[0]]
                    every = frozenset(query_arguments(query))
                    self._known[wanted.key] = QueryBindings(frozenset(), every, True)
                else:
                    self._asking[wanted.key] = None


def query_arguments(query: nodes.DefineQuery) -> Iterator[str]:
    """Yield the names of the arguments of a query."""
    return (arg.variable.name for arg in query.args)


class Bound(Container[str]):
    """The variables bound at a place: the variables of an outer place, and more."""

    __slots__ = ("names", "outer")

    def __init__(
        self, outer: Container[str] | None = None, names: Iterable[str] = ()
    ) -> None:
        self.outer = outer
        self.names = set(names)

    def __contains__(self, name: object) -> bool:
        return name in self.names or (self.outer is not None and name in self.outer)


class Findings:
    """The faults found during a walk of formulas and terms.

    `unbound` are variables that need a value and are not surely bound; `anonymous` are
    bare `?` where a value is needed; `ages` are the `believe` forms that bind an age.
    Each list is in the order of the walk.
    """

    def __init__(self) -> None:
        self.unbound: list[nodes.Var] = []
        self.anonymous: list[nodes.Var] = []
        self.ages: list[nodes.Believe] = []


class BindingWalker:
    """A walk of the formulas and terms of one library.

    Args:
        functions: the declared functions; a pattern with such a name is a test.
        queries: the named queries; a pattern with such a name stands for a formula.
        findings: receives the faults.
    """

    def __init__(
        self,
        functions: Mapping[str, object],
        queries: Mapping[str, nodes.DefineQuery],
        findings: Findings,
    ) -> None:
        self.functions = functions
        self.findings = findings
        self.summaries = Summaries(queries)

    def apart(self) -> BindingWalker:
        """Return a walker of the same library with separate findings."""
        return BindingWalker(self.functions, self.summaries.queries, Findings())

    def value(self, term: nodes.Term, bound: Bound) -> None:
        """Record the unbound variables of a term that needs a value."""
        if type(term) is nodes.Var:
            if term.name == "?":
                self.findings.anonymous.append(term)
            elif term.name not in bound:
                self.findings.unbound.append(term)
        elif type(term) is nodes.Call:
            for arg in term.args:
                self.value(arg, bound)

    def values(self, terms: Iterable[nodes.Term], bound: Bound) -> None:
        """Record the unbound variables of terms that need values."""
        for term in terms:
            self.value(term, bound)

    def match(self, terms: Iterable[nodes.Term], bound: Bound) -> None:
        """Match terms with values: a computed term needs a value, a variable binds."""
        fresh = []
        for term in terms:
            if type(term) is nodes.Var:
                if term.name != "?":
                    fresh.append(term.name)
            elif type(term) is nodes.Call:
                self.value(term, bound)
        bound.names.update(fresh)

    def formula(self, formula: nodes.Formula, bound: Bound) -> bool:
        """Walk a formula, and add the variables that are surely bound to `bound`.

        Returns False if the formula cannot have a solution.
        """
        return _VISITS.get(type(formula), _as_declared)(self, formula, bound)

    def query(self, use: nodes.Proposition, bound: Bound) -> bool:
        """Walk the formula of a named query, with terms in place of the arguments."""
        query = self.summaries.queries[use.name]
        terms = dict(zip(query_arguments(query), use.args, strict=False))
        unbound = [
            term.name
            for term in use.args
            if isinstance(term, nodes.Var) and term.name not in bound
        ]
        given = frozenset(
            name
            for name, term in terms.items()
            if not isinstance(term, nodes.Var) or unbound.count(term.name) != 1
        )
        summary = self.summaries.known(use.name, given, self._summarize)
        fresh = []
        for name, term in terms.items():
            if isinstance(term, nodes.Call) or name in summary.needs:
                self.value(term, bound)
            binds = name in summary.binds or name in given
            if isinstance(term, nodes.Var) and binds and not term.anonymous:
                fresh.append(term.name)
        bound.names.update(fresh)
        return summary.possible

    def _summarize(
        self, query: nodes.DefineQuery, given: frozenset[str]
    ) -> QueryBindings:
        """Walk the formula of a query with values for some of the arguments."""
        kept, self.findings = self.findings, Findings()
        try:
            bound = Bound(None, given)
            possible = self.formula(query.formula, bound)
            lacking = {variable.name for variable in self.findings.unbound}
        finally:
            self.findings = kept
        names = frozenset(query_arguments(query))
        return QueryBindings(names & lacking, names & bound.names, possible)


def _truth(walker: BindingWalker, formula: nodes.Truth, bound: Bound) -> bool:
    return formula.value


def _pattern(walker: BindingWalker, formula: nodes.Proposition, bound: Bound) -> bool:
    if formula.name in walker.summaries.queries:
        return walker.query(formula, bound)
    if formula.name in walker.functions:
        walker.values(formula.args, bound)
    else:
        walker.match(formula.args, bound)
    return True


def _as_declared(walker: BindingWalker, formula: nodes.Formula, bound: Bound) -> bool:
    """Walk a formula whose operands alone determine the bindings."""
    inner = operands(formula)
    if inner.used:
        walker.values(inner.used, bound)
    if inner.matched:
        walker.match(inner.matched, bound)
    scope = Bound(bound)
    for part in inner.closed:
        walker.formula(part, scope)
    possible = True
    for part in inner.parts:
        possible = walker.formula(part, bound) and possible
    return possible


def _or(walker: BindingWalker, formula: nodes.Or, bound: Bound) -> bool:
    common: set[str] | None = None
    for part in formula.parts:
        branch = Bound(bound)
        if walker.formula(part, branch):
            common = branch.names if common is None else common & branch.names
    bound.names.update(common or ())
    return common is not None


def _not(walker: BindingWalker, formula: nodes.Not, bound: Bound) -> bool:
    walker.formula(formula.part, Bound(bound))
    return not (type(formula.part) is nodes.Truth and formula.part.value)


def _believe(walker: BindingWalker, formula: nodes.Believe, bound: Bound) -> bool:
    walker.match(formula.pattern.args, bound)
    age = formula.age
    if type(age) is nodes.Var and not age.anonymous and age.name not in bound:
        walker.findings.ages.append(formula)
    walker.match((age,), bound)
    return True


_VISITS: Mapping[type, Callable[..., bool]] = {
    nodes.Truth: _truth,
    nodes.Proposition: _pattern,
    nodes.Or: _or,
    nodes.Not: _not,
    nodes.Believe: _believe,
}
"""The types of formulas with a rule of their own for bindings."""


class Site(msgspec.Struct, frozen=True):
    """A place that binds a variable.

    `clause` is the name of the clause, or `input`, `resource` or `step`, or a value of
    `SIGNALS` for a signal that ends a step. `method` and `step` (its position) locate
    the place in a method. A `negated` place lies inside a `not`, a `branch` place in an
    `or`.
    """

    name: str
    span: Span
    clause: str
    method: nodes.Method | None = None
    step: int | None = None
    negated: bool = False
    branch: bool = False

    @property
    def what(self) -> str:
        """Return the place in words."""
        if self.step is not None and self.method is not None:
            assert isinstance(self.method.body, nodes.TaskNet)
            return f"step `{self.method.body.steps[self.step].tag}`"
        return _WORDS.get(self.clause) or f"`{self.clause}`"


_WORDS = {"input": "an input", "resource": "a resource"}

SIGNALS = {"succeed": "a signal that ends", "fail": "a signal that fails"}
"""The name of a signal that ends a step, by the mode of its `wait-for`."""


def sites(rap: nodes.DefineRap, functions: Container[str]) -> Iterator[Site]:
    """Yield all places of a RAP that bind a variable, in the order of evaluation."""
    for variable in rap.inputs:
        yield Site(variable.name, variable.span, "input")
    for resource in rap.resources:
        yield Site(resource.variable.name, resource.variable.span, "resource")
    for clause, formula in clauses.held(clauses.RAP, rap):
        yield from _formula(Site("", rap.span, clause.word), formula, functions)
    for method in rap.methods:
        yield from _method(method, functions)


def _method(method: nodes.Method, functions: Container[str]) -> Iterator[Site]:
    for clause, formula in clauses.held(clauses.METHOD, method):
        place = Site("", method.span, clause.word, method)
        yield from _formula(place, formula, functions)
    if isinstance(method.body, nodes.TaskNet):
        for at, step in enumerate(method.body.steps):
            place = Site("", step.span, "step", method, at)
            yield from _step(place, step, functions)
    elif isinstance(method.body, nodes.Skills):
        for wait in method.body.waits:
            place = Site("", wait.span, "wait-for", method)
            yield from _terms(place, wait.args)


def _step(place: Site, step: nodes.Step, functions: Container[str]) -> Iterator[Site]:
    yield from _terms(place, step.goal.outputs)
    for annotation in step.annotations:
        if isinstance(annotation, nodes.WaitFor):
            clause = SIGNALS.get(annotation.mode, place.clause)
            there = msgspec.structs.replace(place, clause=clause)
            yield from _terms(there, annotation.args)
        elif isinstance(annotation, nodes.For) and annotation.formula is not None:
            yield from _formula(place, annotation.formula, functions)


def _formula(
    place: Site, formula: nodes.Formula, functions: Container[str]
) -> Iterator[Site]:
    if isinstance(formula, nodes.Proposition) and formula.name in functions:
        return
    inner = operands(formula)
    within = msgspec.structs.replace(place, branch=True)
    for part in inner.parts:
        branch = isinstance(formula, nodes.Or)
        yield from _formula(within if branch else place, part, functions)
    denied = msgspec.structs.replace(place, negated=True)
    for part in inner.closed:
        yield from _formula(denied, part, functions)
    yield from _terms(place, inner.matched)


def _terms(place: Site, terms: tuple[nodes.Term, ...]) -> Iterator[Site]:
    for term in terms:
        if isinstance(term, nodes.Var) and not term.anonymous:
            yield msgspec.structs.replace(place, name=term.name, span=term.span)


def sites_by_name(
    rap: nodes.DefineRap, functions: Container[str]
) -> Mapping[str, Sequence[Site]]:
    """Return the places of a RAP that bind variables, by variable name."""
    found: dict[str, list[Site]] = {}
    for site in sites(rap, functions):
        found.setdefault(site.name, []).append(site)
    return found


class MayBeBound:
    """The variables of a RAP that may have values before a formula is evaluated.

    Args:
        rap: the RAP.
        functions: the declared functions.
    """

    def __init__(self, rap: nodes.DefineRap, functions: Container[str]) -> None:
        self._rap = rap
        self._functions = functions
        self._sites: Mapping[str, Sequence[Site]] | None = None

    def at(self, place: FormulaAt) -> Container[str]:
        """Return the variables that may have values before a formula is evaluated."""
        return _BoundBefore(self, place)

    def sites(self, name: str) -> Sequence[Site]:
        """Return the places that bind a variable."""
        if self._sites is None:
            self._sites = sites_by_name(self._rap, self._functions)
        return self._sites.get(name, ())


class _BoundBefore(Container[str]):
    """The variables that may have values before a formula is evaluated [L 3.64, 3.67].

    Steps share the variables of their method. A binding by one step may be available to
    the conditions of the other steps, and to the constraints of the method.
    """

    def __init__(self, bound: MayBeBound, place: FormulaAt) -> None:
        self._bound = bound
        self._place = place

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and any(
            self._comes_before(site) for site in self._bound.sites(name)
        )

    def _comes_before(self, site: Site) -> bool:
        method, own = self._place.method, self._place.formula.span
        if site.clause in _WORDS:
            return True
        if site.negated or method is None or site.clause in _KEPT_BACK:
            return False
        if site.method is None:
            return True
        within = own.start <= site.span.start < own.end
        return self._place.clause.when == "run" and site.method is method and not within


_KEPT_BACK = {
    clause.word for clause in (*clauses.RAP, *clauses.METHOD) if not clause.hands_on
}
"""The clauses whose bindings are local to the clause."""


def whole_formulas(
    form: nodes.TopForm, functions: Container[str]
) -> Iterator[tuple[nodes.Formula, Container[str]]]:
    """Yield the formulas of a form, with the variables that may have values before."""
    if isinstance(form, nodes.DefineRap):
        bound = MayBeBound(form, functions)
        for one in formulas(form):
            yield one.formula, bound.at(one)
    elif isinstance(form, nodes.DefineQuery):
        yield form.formula, set(query_arguments(form))
    elif isinstance(form, nodes.MemoryRule | nodes.EventRule):
        for rules, given in rules_over_memory(form):
            for rule in rules:
                for alternative in rule.alternatives:
                    yield alternative.query, given


def rules_over_memory(
    form: nodes.MemoryRule | nodes.EventRule,
) -> Iterator[tuple[Sequence[nodes.Rule], set[str]]]:
    """Yield rules that run together, with the variables that have values before."""
    if isinstance(form, nodes.EventRule):
        yield form.rules, names_of(form.args)
        return
    index = names_of((*form.index.args, *form.index.outputs))
    for case in form.cases:
        result = case.result
        args = result.args if isinstance(result, nodes.Signal) else (result,)
        yield case.rules, index | names_of(args)


def names_of(terms: Iterable[nodes.Term]) -> set[str]:
    """Return the names of the variables in some terms, except bare `?`."""
    return {t.name for t in terms if isinstance(t, nodes.Var) and not t.anonymous}
