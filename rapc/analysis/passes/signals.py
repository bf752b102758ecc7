"""RAP023 and RAP024: skills and events that no declaration knows, or that miss it.

Skills are enabled and disabled, events awaited and matched by rules (semantics 8, S 3
and 4). Their names are written with a colon.
"""

from __future__ import annotations

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.named import MISUSES, report_arguments, report_unknown
from rapc.base.diagnostics import Rule, Severity

UNDECLARED = Rule(
    code="RAP023",
    name="undeclared-signal",
    severity=Severity.ERROR,
    summary="a skill or an event is not declared",
    why="""Skills and events are what a world offers besides primitives. A skill that it
does not have cannot be enabled, and an event that it never sends is awaited for
ever.""",
    example="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall ?side))
    (wait-for (:wall-end) :succeed))))
""",
    better="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall ?side))
    (wait-for (:wall-ends) :succeed))))
""",
)

ARITY = Rule(
    code="RAP024",
    name="wrong-signal-arity",
    severity=Severity.ERROR,
    summary="a skill or an event has another number of arguments than was declared",
    why="""A skill is enabled with the arguments it was declared with, and an event is
sent with those it was declared with: another number of them never matches.""",
    example="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall))
    (wait-for (:wall-ends) :succeed))))
""",
    better="""\
(declare-skill :follow-wall (?side))
(declare-event :wall-ends ())
(define-rap (follow ?side)
  (method (primitive
    (enable (:follow-wall ?side))
    (wait-for (:wall-ends) :succeed))))
""",
)


def _run(run: Pass) -> None:
    report_unknown(run, UNDECLARED, ("skill", "event"))
    report_arguments(run, ARITY, ("skill", "event"))


ANALYZER = Analyzer(
    name="signals",
    doc="Finds skills and events that are not declared, or declared otherwise.",
    run=_run,
    needs=(MISUSES,),
    rules=(UNDECLARED, ARITY),
)
