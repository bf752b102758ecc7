"""The places of a RAP where a variable gets a value, for messages.

Slower and simpler than `rapc.analysis.passes.bindings`, and asked only about RAPs in
which something is wrong: it says where a name is bound and what is special about the
place, not whether it is bound where somebody needs it.
"""

from __future__ import annotations

from collections.abc import Container, Iterator

import msgspec

from rapc.base.source import Span
from rapc.ir import clauses, nodes
from rapc.ir.operands import operands


class Site(msgspec.Struct, frozen=True):
    """One place that binds a variable.

    `clause` is the clause's name, or `input`, `resource` or `step`; `method` and
    `step` (its position) say where it is in a method; `negated` places lie inside a
    `not`, `branch` places in an `or`.
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
            yield from _terms(place, annotation.args)
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
