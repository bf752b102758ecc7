"""Which variables a formula needs, and which it surely binds [L 2].

`and` binds from left to right; of `or`, only what every branch that can succeed binds
is surely bound; `not` exports nothing; comparisons, computed terms, tests of sets and
functions used as tests bind nothing and need theirs bound; a named query does to the
terms it is given what its formula does. Where these formulas stand
and what is bound beforehand is for `rapc.analysis.checks.bindings` to say.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping

from rapc.analysis.named_bindings import QueryBindings, Summaries, query_arguments
from rapc.ir import nodes
from rapc.ir.schema import operands


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
