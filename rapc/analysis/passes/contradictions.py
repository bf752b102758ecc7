"""RAP110: formulas that never hold, whatever happens.

A conjunction is taken apart into literals (`rapc.analysis.literals`), of which two
never hold together; each branch of an `or` is asked with what stands around it.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.conjunction import Clash, Conjunction, may_clash
from rapc.analysis.literals import Literal, literals
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import formulas

CONTRADICTION = Rule(
    code="RAP110",
    name="contradiction",
    severity=Severity.WARNING,
    summary="two parts of a formula never hold together",
    why="""A property has one value at a time; what is asked cannot be denied as well;
no number is below 3 and above 5. A conjunction, or a branch of an `or`, with two such
parts never holds, whatever happens: mostly `or` was meant, or one of the two speaks of
another thing (T 4.1).""",
    ignore="where a method is switched off on purpose: write `nil` as its context",
    source="T 4.1.3",
    example="""\
(declare-memory-property door-state (?door ?state) unknown)
(define-rap (go-through ?door))
(define-rap (pass ?door)
  (method
    (context (and (door-state ?door open) (door-state ?door ajar)))
    (task-net (t1 (go-through ?door)))))
""",
    better="""\
(declare-memory-property door-state (?door ?state) unknown)
(define-rap (go-through ?door))
(define-rap (pass ?door)
  (method
    (context (or (door-state ?door open) (door-state ?door ajar)))
    (task-net (t1 (go-through ?door)))))
""",
)


class Reports:
    """Where the findings of one form go: each place is told of once.

    Args:
        run: the run of the pass.
        given: the variables that have values before a formula is asked.
    """

    def __init__(self, run: Pass, given: Container[str]) -> None:
        self.run = run
        self.given = given
        self._told: set[Span] = set()

    def report(self, rule: Rule, message: str, span: Span, label: Label) -> None:
        """Report a place that no finding was about before."""
        if span in self._told:
            return
        self._told.add(span)
        labels = (label,) if label.span != span else ()
        self.run.report(Diagnostic(rule.name, message, span, labels=labels))

    def conjunction(self, held: Iterable[Literal]) -> Conjunction:
        """Return a conjunction that has literals in it already."""
        made = Conjunction(self.run.signatures.relations, self.given)
        for one in held:
            made.add(one)
        return made


def _run(run: Pass) -> set[int]:
    """Report, and return the ids of the formulas of RAPs that never hold."""
    never: set[int] = set()
    for form in run.library.forms:
        if isinstance(form, nodes.DefineRap):
            given = {v.name for v in form.inputs}
            given |= {r.variable.name for r in form.resources}
            reports = Reports(run, given)
            for one in formulas(form):
                if _contradictions(reports, one.formula):
                    never.add(id(one.formula))
        elif isinstance(form, nodes.DefineQuery):
            given = {arg.variable.name for arg in form.args}
            _contradictions(Reports(run, given), form.formula)
        elif isinstance(form, nodes.MemoryRule | nodes.EventRule):
            for formula in _queries(form):
                _contradictions(Reports(run, ()), formula)
    return never


ANALYZER = Analyzer(
    name="contradictions",
    doc="Finds formulas that never hold, whatever happens.",
    run=_run,
    rules=(CONTRADICTION,),
    needs_whole="form",
)


def _queries(form: nodes.MemoryRule | nodes.EventRule) -> Iterator[nodes.Formula]:
    rules = (
        form.rules
        if isinstance(form, nodes.EventRule)
        else [rule for case in form.cases for rule in case.rules]
    )
    for rule in rules:
        for alternative in rule.alternatives:
            yield alternative.query


def _contradictions(reports: Reports, formula: nodes.Formula) -> bool:
    """Report what never holds in a formula; return whether anything was found."""
    if not isinstance(formula, _JOINED):
        return False
    found = False
    waiting: list[tuple[nodes.Formula, list[Literal]]] = [(formula, [])]
    while waiting:
        here, outer = waiting.pop()
        own = list(literals(here))
        clash = first_clash(reports, outer, own)
        if clash is not None:
            _report_contradiction(reports, clash)
            found = True
            continue
        for literal in own:
            inner = literal.formula
            if not isinstance(inner, _JOINED):
                continue
            if isinstance(inner, nodes.Or):
                others = [*outer, *(one for one in own if one is not literal)]
                kept = others if literal.holds else []
                waiting += [(part, kept) for part in reversed(inner.parts)]
            else:
                waiting.append((inner, []))
    return found


_JOINED = (nodes.And, nodes.Or, nodes.Not)
"""What other formulas are put together by."""


def first_clash(
    reports: Reports, held: Sequence[Literal], own: Sequence[Literal]
) -> Clash | None:
    """Return the first of some literals that contradicts another.

    Args:
        reports: tell which variables have values.
        held: literals that hold, and do not contradict each other.
        own: the literals that are put to them, one after another.
    """
    if not may_clash([*held, *own]):
        return None
    made = reports.conjunction(held)
    for literal in own:
        clash = made.add(literal)
        if clash is not None:
            return clash
    return None


def _report_contradiction(reports: Reports, clash: Clash) -> None:
    reports.report(
        CONTRADICTION,
        f"{said(clash.second)} and {said(clash.first)} never hold together",
        clash.second.span,
        Label(clash.first.span, "asked here" if clash.first.holds else "denied here"),
    )


def said(literal: Literal) -> str:
    """Return what a literal says, shortened, in back-ticks."""
    text = format_formula(literal.formula)
    if len(text) > _LONG:
        text = text[:_LONG] + "..."
    return f"`{text}`" if literal.holds else f"`(not {text})`"


_LONG = 50
"""How many letters of a formula are told."""
