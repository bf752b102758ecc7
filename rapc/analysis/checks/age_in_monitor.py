"""RAP068: a monitor that binds an age [L 5]."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.variables import BINDINGS
from rapc.base.diagnostics import Diagnostic, Rule, Severity

AGE = Rule(
    code="RAP068",
    name="age-in-monitor",
    severity=Severity.WARNING,
    summary="a monitor binds an age, and so is tested whenever the clock moves",
    why="""A monitor is woken by changes of memory, and `believe` with a number by the
time at which the fact goes stale. An age that is bound changes with every tick and
announces nothing: the formula is tested again each time the clock has moved, and sets
no time of its own, so the task may wake late or not at all.""",
    ignore="where the task has a monitor of time too, which wakes it",
    source="T 4.1.1, 4.7.1",
    example="""\
(declare-memory-proposition seen (?thing))
(define-rap (look))
(define-rap (keep-looking)
  (monitor-state (and (believe (seen box) ?age) (> ?age 30)))
  (method (task-net (t1 (look)))))
""",
    better="""\
(declare-memory-proposition seen (?thing))
(define-rap (look))
(define-rap (keep-looking)
  (monitor-state (not (believe (seen box) 30)))
  (method (task-net (t1 (look)))))
""",
)


@check(AGE, needs_whole="form")
def age_in_monitor(run: Pass) -> Iterator[Diagnostic]:
    """Find monitors that bind an age instead of testing one."""
    for believe in run.result(BINDINGS).ages:
        yield AGE.at(
            believe.age.span,
            "an age is bound in a monitor, which no time wakes",
            help="give `believe` a number: `(not (believe p 30))` wakes the task "
            "when p is 30 old",
        )
