"""Variables that formulas need and bind [L 2], and the sites that bind them.

`BindingWalker` says what a formula needs and surely binds: `and` binds from left to
right; of `or`, only what every branch that can succeed binds is surely bound; `not`
exports nothing; comparisons, computed terms, tests of sets and functions used as tests
bind nothing and need theirs bound; a named query does to the terms it is given what its
formula does. Where these formulas stand and what is bound beforehand is for
`rapc.analysis.facts.variables` to say.

A named query stands for its formula with terms put in for its arguments. Which
arguments need a value, and which the formula surely binds, depends on those that have
one where the name stands: so queries are walked once for each such set that comes up.
What a query asks through others is worked out first, without recursion, however long
the chain is. In a circle, which is reported elsewhere, a query is taken for a fact.

`sites` are the places where a variable gets a value, or may get one: slower and
simpler, and asked only about RAPs in which something may be wrong.
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
"""A query by its name, with those of its arguments that have a value."""


class QueryBindings(msgspec.Struct, frozen=True):
    """What a query comes to where some of its arguments have a value."""

    #: The arguments that need a value and do not surely have one.
    needs: Set[str]
    #: The arguments that have a value wherever the query holds.
    binds: Set[str]
    #: Whether it can hold at all.
    possible: bool


class _UnknownError(Exception):
    """A summary is asked for that has to be worked out first."""

    def __init__(self, key: Key) -> None:
        super().__init__(key)
        self.key = key


Summarize = Callable[[nodes.DefineQuery, frozenset[str]], QueryBindings]
"""Walks the formula of a query once, asking `Summaries.known` for others in it."""


class Summaries:
    """The summaries of the queries of a library, worked out when asked for.

    Args:
        queries: the queries by name.
        summarize: what walks one of them.
    """

    def __init__(
        self, queries: Mapping[str, nodes.DefineQuery], summarize: Summarize
    ) -> None:
        self.queries = queries
        self._summarize = summarize
        self._known: dict[Key, QueryBindings] = {}
        #: What is being worked out, each for the sake of the one before it.
        self._asking: dict[Key, None] = {}

    def known(self, name: str, given: frozenset[str]) -> QueryBindings:
        """Return what a query comes to where the arguments in `given` have a value."""
        key = (name, given)
        found = self._known.get(key)
        if found is not None:
            return found
        if self._asking:
            raise _UnknownError(key)
        self._work_out(key)
        return self._known[key]

    def _work_out(self, key: Key) -> None:
        """Walk a query, after all others that its formula asks."""
        self._asking[key] = None
        while self._asking:
            name, given = here = next(reversed(self._asking))
            try:
                self._known[here] = self._summarize(self.queries[name], given)
                del self._asking[here]
            except _UnknownError as wanted:
                if wanted.key in self._asking:
                    query = self.queries[wanted.key[0]]
                    every = frozenset(query_arguments(query))
                    self._known[wanted.key] = QueryBindings(frozenset(), every, True)
                else:
                    self._asking[wanted.key] = None


def query_arguments(query: nodes.DefineQuery) -> Iterator[str]:
    """The names of the arguments of a query."""
    return (arg.variable.name for arg in query.args)


class Bound(Container[str]):
    """The names bound at some place: those of an outer place and some more."""

    __slots__ = ("names", "outer")

    def __init__(
        self, outer: Container[str] | None = None, names: Iterable[str] = ()
    ) -> None:
        self.outer = outer
        self.names = set(names)

    def __contains__(self, name: object) -> bool:
        return name in self.names or (self.outer is not None and name in self.outer)


class Findings:
    """What was noticed while formulas and terms were walked through.

    `unbound` are variables that need a value and are not surely bound, `anonymous`
    those that are a bare `?` where a value is needed, `ages` the `believe` forms
    that bind an age; all in the order in which they are met.
    """

    def __init__(self) -> None:
        self.unbound: list[nodes.Var] = []
        self.anonymous: list[nodes.Var] = []
        self.ages: list[nodes.Believe] = []


class BindingWalker:
    """Walks formulas and terms of one library.

    Args:
        functions: the declared functions; a pattern of that name is a test.
        queries: the named queries; a pattern of that name stands for a formula.
        findings: where what is noticed goes.
    """

    def __init__(
        self,
        functions: Mapping[str, object],
        queries: Mapping[str, nodes.DefineQuery],
        findings: Findings,
    ) -> None:
        self.functions = functions
        self.findings = findings
        self.summaries = Summaries(queries, self._summarize)

    def apart(self) -> BindingWalker:
        """Return a walker of the same library with findings of its own."""
        return BindingWalker(self.functions, self.summaries.queries, Findings())

    def value(self, term: nodes.Term, bound: Bound) -> None:
        """A place that needs a value: note what is not bound in it."""
        if type(term) is nodes.Var:
            if term.name == "?":
                self.findings.anonymous.append(term)
            elif term.name not in bound:
                self.findings.unbound.append(term)
        elif type(term) is nodes.Call:
            for arg in term.args:
                self.value(arg, bound)

    def values(self, terms: Iterable[nodes.Term], bound: Bound) -> None:
        """Several places that need values."""
        for term in terms:
            self.value(term, bound)

    def match(self, terms: Iterable[nodes.Term], bound: Bound) -> None:
        """Terms matched with values: computed ones need, variables bind."""
        fresh = []
        for term in terms:
            if type(term) is nodes.Var:
                if term.name != "?":
                    fresh.append(term.name)
            elif type(term) is nodes.Call:
                self.value(term, bound)
        bound.names.update(fresh)

    def formula(self, formula: nodes.Formula, bound: Bound) -> bool:
        """Walk a formula, adding to `bound` what it surely binds.

        Returns False if it can have no solution.
        """
        return _VISITS.get(type(formula), _as_declared)(self, formula, bound)

    def query(self, use: nodes.Proposition, bound: Bound) -> bool:
        """Walk the formula that a name stands for, with its terms put in."""
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
        summary = self.summaries.known(use.name, given)
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
        """Walk the formula of a query where some of its arguments have a value."""
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
    """A formula of which its operands say all there is to know."""
    inner = operands(formula)
    if inner.used:
        walker.values(inner.used, bound)
    if inner.matched:
        walker.match(inner.matched, bound)
    for part in inner.closed:
        walker.formula(part, Bound(bound))
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
"""Kinds of formulas of which there is more to know than their operands say."""


class Site(msgspec.Struct, frozen=True):
    """One place that binds a variable.

    `clause` is the clause's name, or `input`, `resource` or `step`, or one of `SIGNALS`
    for a signal that ends a step; `method` and `step` (its position) say where it is in
    a method; `negated` places lie inside a `not`, `branch` places in an `or`.
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
        """The place in words."""
        if self.step is not None and self.method is not None:
            assert isinstance(self.method.body, nodes.TaskNet)
            return f"step `{self.method.body.steps[self.step].tag}`"
        return _WORDS.get(self.clause) or f"`{self.clause}`"


_WORDS = {"input": "an input", "resource": "a resource"}

SIGNALS = {"succeed": "a signal that ends", "fail": "a signal that fails"}
"""What a signal that ends a step is called, by the mode of its `wait-for`."""


def sites(rap: nodes.DefineRap, functions: Container[str]) -> Iterator[Site]:
    """All places of a RAP that bind a variable, in the order of evaluation."""
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
    """Return the places of a RAP that bind variables, by the names of these."""
    found: dict[str, list[Site]] = {}
    for site in sites(rap, functions):
        found.setdefault(site.name, []).append(site)
    return found


class MayBeBound:
    """Tells which variables of a RAP may have values where a formula is asked.

    Args:
        rap: the RAP.
        functions: the declared functions.
    """

    def __init__(self, rap: nodes.DefineRap, functions: Container[str]) -> None:
        self._rap = rap
        self._functions = functions
        self._sites: Mapping[str, Sequence[Site]] | None = None

    def at(self, place: FormulaAt) -> Container[str]:
        """Return the variables that may have values before a formula is asked."""
        return _BoundBefore(self, place)

    def sites(self, name: str) -> Sequence[Site]:
        """Return the places that bind a variable."""
        if self._sites is None:
            self._sites = sites_by_name(self._rap, self._functions)
        return self._sites.get(name, ())


class _BoundBefore(Container[str]):
    """The variables that may have values before a formula is asked [L 3.64, 3.67].

    Steps share the variables of their method: what any of them has bound may be there
    when a condition of another one is asked, or a constraint of the method.
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
"""The clauses whose bindings stay theirs."""


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
    """Yield rules that run together, with the variables that have values there."""
    if isinstance(form, nodes.EventRule):
        yield form.rules, names_of(form.args)
        return
    index = names_of((*form.index.args, *form.index.outputs))
    for case in form.cases:
        result = case.result
        args = result.args if isinstance(result, nodes.Signal) else (result,)
        yield case.rules, index | names_of(args)


def names_of(terms: Iterable[nodes.Term]) -> set[str]:
    """Return the names of the variables among some terms, but for bare `?`."""
    return {t.name for t in terms if isinstance(t, nodes.Var) and not t.anonymous}
