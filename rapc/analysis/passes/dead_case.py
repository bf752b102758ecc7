"""RAP152: cases of memory rules that are never taken [S 4.2]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.index import INDEX
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes

DEAD = Rule(
    code="RAP152",
    name="dead-case",
    severity=Severity.WARNING,
    summary="a case of a memory rule can never be taken",
    why="""Of the cases of a `match-result` the first that matches is taken alone, so
what stands behind a case that matches everything, or behind the same case, is never
reached. A task ends with a result, not with a signal; an event is a signal, and has no
result.""",
    example="""\
(declare-memory-proposition at (?place))
(declare-primitive drive (?place) (okay stuck))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-memory-rule (go ?place) :finish
  (match-result
    (?result (rule (true (mem-del (at)))))
    (succeed (rule (true (mem-add (at ?place)))))))
""",
    better="""\
(declare-memory-proposition at (?place))
(declare-primitive drive (?place) (okay stuck))
(define-rap (go ?place) (method (primitive (drive ?place))))
(define-memory-rule (go ?place) :finish
  (match-result
    (succeed (rule (true (mem-add (at ?place)))))
    (?result (rule (true (mem-del (at)))))))
""",
)


def _run(run: Pass) -> None:
    for rule in run.result(INDEX).of(nodes.MemoryRule):
        for found in _dead(rule.node):
            run.report(found)


def _dead(rule: nodes.MemoryRule) -> Iterator[Diagnostic]:
    names = {v.name for v in rule.index.args if isinstance(v, nodes.Var)}
    names |= {v.name for v in rule.index.outputs if isinstance(v, nodes.Var)}
    every: nodes.ResultCase | None = None
    seen: dict[object, nodes.ResultCase] = {}
    for case in rule.cases:
        result = case.result
        first = every
        if isinstance(result, nodes.Const):
            first = first or seen.setdefault(result.value, case)
        if first not in (None, case):
            yield _behind(case, first)
        elif rule.when == "event" and isinstance(result, nodes.Const):
            text = f"`{result.value}` is a result, and this rule hears events"
            yield _wrong(case, text, "name the event: `((:event ?what) (rule ...))`")
        elif rule.when == "finish" and isinstance(result, nodes.Signal):
            text = f"`{result.name}` is an event, and this rule runs when a task ends"
            yield _wrong(case, text, "make it an `:event` rule, or name a result")
        if isinstance(result, nodes.Var) and result.name not in names:
            every = every or case


def _behind(case: nodes.ResultCase, first: nodes.ResultCase | None) -> Diagnostic:
    assert first is not None
    return Diagnostic(
        rule=DEAD.name,
        message="this case is never reached",
        span=case.result.span,
        labels=(Label(first.result.span, "this one matches before it"),),
        help="put it before that one, or remove it",
    )


def _wrong(case: nodes.ResultCase, message: str, help: str) -> Diagnostic:
    return Diagnostic(rule=DEAD.name, message=message, span=case.result.span, help=help)


ANALYZER = Analyzer(
    name="dead-case",
    doc="Finds cases of memory rules that are never taken.",
    run=_run,
    needs=(INDEX,),
    rules=(DEAD,),
    needs_whole="form",
)
