"""RAP063: a bare `?` where a value is needed [L 2.7]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.variables import BINDINGS
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


@check(ANONYMOUS)
def anonymous_variable(run: Pass) -> Iterator[Diagnostic]:
    """Find a bare `?` where a value is needed."""
    for variable in run.result(BINDINGS).anonymous:
        yield ANONYMOUS.at(
            variable.span,
            "`?` has no value here",
            help="name the variable and bind it first; "
            "`?` only matches, in queries and patterns",
        )
