"""The places of a RAP where a variable gets a value, or may get one.

Slower and simpler than `rapc.analysis.checks.bindings`, and asked only about RAPs in
which something may be wrong: it says where a name is bound and what is special about
the place, not whether it is surely bound where somebody needs it.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis.named_bindings import query_arguments
from rapc.base.source import Span
from rapc.ir import clauses, nodes
from rapc.ir.schema import operands
from rapc.ir.walk import FormulaAt, formulas


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
        yield form.rules, _variables(form.args)
        return
    index = _variables((*form.index.args, *form.index.outputs))
    for case in form.cases:
        result = case.result
        args = result.args if isinstance(result, nodes.Signal) else (result,)
        yield case.rules, index | _variables(args)


def _variables(terms: tuple[nodes.Term, ...]) -> set[str]:
    return {t.name for t in terms if isinstance(t, nodes.Var) and not t.anonymous}
