"""RAP125: two steps each of which ends the other by starting [L 4.28]."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.passes.task_nets import TASK_NETS, Net, sure_nets
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes

BOTH = Rule(
    code="RAP125",
    name="end-each-other",
    severity=Severity.WARNING,
    summary="two steps that can begin at once end each other by starting",
    why="""`until-start` takes a step away when the other one starts. Where each of two
steps does so to the other and neither waits for anything, the first to be chosen ends
the other before that has begun: one of the two is never carried out, and priority or
chance decides which. Steps that wait for something by monitors, signals or windows may
be alternatives of that form.""",
    ignore="where one of the two is to be dropped, whichever it is",
    source="T 4.5.2",
    example="""\
(define-rap (watch))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    (t1 (watch) (until-start t2))
    (t2 (carry) (until-start t1)))))
""",
    better="""\
(define-rap (watch))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    (t1 (watch) (until-end t2))
    (t2 (carry)))))
""",
)


def _run(run: Pass) -> None:
    for steps, net in sure_nets(run):
        for found in _pairs(run, steps, net):
            run.report(found)


ANALYZER = Analyzer(
    name="until-both",
    doc="Finds steps that end each other as soon as one of them is chosen.",
    run=_run,
    needs=(TASK_NETS,),
    rules=(BOTH,),
    needs_whole="method",
)


def _pairs(run: Pass, steps: Sequence[nodes.Step], net: Net) -> Iterator[Diagnostic]:
    marks = {
        (step.tag, note.tag): note
        for step in steps
        for note in step.annotations
        if isinstance(note, nodes.UntilStart)
    }
    at_once = {
        step.tag
        for at, step in enumerate(steps)
        if marks and not net.edges[at] and not may_wait(run, step)
    }
    for (one, other), note in marks.items():
        back = marks.get((other, one))
        if back is None or note.span.start <= back.span.start:
            continue
        if one in at_once and other in at_once:
            yield Diagnostic(
                rule=BOTH.name,
                message=f"steps `{other}` and `{one}` end each other by starting, "
                "so only one of them is ever carried out",
                span=note.span,
                labels=(Label(back.span, "and the other way round here"),),
                help="leave one of the two out, or write `until-end`",
            )


def may_wait(run: Pass, step: nodes.Step) -> bool:
    """Whether a step may wait for more than the end of other steps, or nobody knows."""
    rap = run.library.raps.get(step.goal.name)
    if rap is None or rap.monitor_state is not None or rap.monitor_time is not None:
        return True
    return any(
        isinstance(note, nodes.WaitFor | nodes.Window) for note in step.annotations
    )
