"""RAP063: a bare `?` where a value is needed [L 2.7]."""

from __future__ import annotations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.passes.bindings import BINDINGS
from rapc.analysis.passes.explained import EXPLAINED
from rapc.base.diagnostics import Diagnostic, Rule, Severity

ANONYMOUS = Rule(
    code="RAP063",
    name="anonymous-variable",
    severity=Severity.ERROR,
    summary="a bare `?` stands where a value is needed",
    why="""`?` matches anything and is a new variable at each place, so it never has a
value. In queries and patterns that is what is wanted; as an input of a step, in a
request, a test or a sum there is nothing it could stand for.""",
    source="T 4.1",
    example="""\
(define-rap (go-to ?place))
(define-rap (wander)
  (method (task-net (t1 (go-to ?)))))
""",
    better="""\
(declare-memory-proposition place (?place))
(define-rap (go-to ?place))
(define-rap (wander)
  (method
    (context (place ?place))
    (task-net (t1 (go-to ?place)))))
""",
)


def _run(run: Pass) -> None:
    for variable in run.result(BINDINGS).anonymous:
        if id(variable) in run.result(EXPLAINED).anonymous:
            continue
        run.report(
            Diagnostic(
                rule=ANONYMOUS.name,
                message="`?` has no value here",
                span=variable.span,
                help="name the variable and bind it first; "
                "`?` only matches, in queries and patterns",
            )
        )


ANALYZER = Analyzer(
    name="anonymous-variable",
    doc="Finds a bare `?` where a value is needed.",
    run=_run,
    needs=(BINDINGS, EXPLAINED),
    rules=(ANONYMOUS,),
)
