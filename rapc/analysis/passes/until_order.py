"""RAP127 and RAP128: `until` between steps that are in order, or that begin together.

`until` orders nothing [L 4.4]. What it means it means while both steps may be at work.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.analysis.analyzer import Analyzer, Pass
from rapc.analysis.passes.task_nets import TASK_NETS, Net, sure_nets
from rapc.analysis.passes.until_both import may_wait
from rapc.base.diagnostics import Diagnostic, Label, Rule, Severity
from rapc.ir import nodes

_WORK = """\
(define-rap (watch))
(define-rap (carry))
(define-rap (deliver)
  (method (task-net
    {}
    {})))
"""

IDLE = Rule(
    code="RAP127",
    name="idle-until",
    severity=Severity.WARNING,
    summary="a step is to be ended by one that is never under way at the same time",
    why="""`until-start` and `until-end` end a step that is at work beside another (T
4.5.2). Where `for` or a window puts one of the two before the other, the first has
ended when the second begins: the annotation does nothing, or takes away a step that has
not begun. Leave out the order, or the `until`.""",
    ignore="never: the annotation ends nothing that is under way",
    source="T 4.5.2",
    example=_WORK.format("(t1 (watch) (for t2) (until-end t2))", "(t2 (carry))"),
    better=_WORK.format("(t1 (watch) (until-end t2))", "(t2 (carry))"),
)

AT_ONCE = Rule(
    code="RAP128",
    name="ended-by-start",
    severity=Severity.WARNING,
    summary="a step is taken away when another one starts, which can start at once",
    why="""`until-start` takes a step away when the other one is first selected [L
4.28]. Where that waits for nothing, no other step, window, signal or monitor, and is no
less urgent, it may be selected first: the step is never carried out. Mostly `until-end`
was meant; else say what the other one waits for.""",
    ignore="where the other step waits for something that the library does not tell",
    source="T 4.5.2",
    example=_WORK.format("(t1 (watch) (until-start t2))", "(t2 (carry))"),
    better=_WORK.format("(t1 (watch) (until-end t2))", "(t2 (carry))"),
)


def _run(run: Pass) -> None:
    for steps, net in sure_nets(run):
        for found in _unfit(run, steps, net):
            run.report(found)


ANALYZER = Analyzer(
    name="until-order",
    doc="Finds `until` between steps that are in order, or that begin together.",
    run=_run,
    needs=(TASK_NETS,),
    rules=(IDLE, AT_ONCE),
    needs_whole="method",
)


def _unfit(run: Pass, steps: Sequence[nodes.Step], net: Net) -> Iterator[Diagnostic]:
    places = {step.tag: at for at, step in enumerate(steps)}
    marks = {
        (step.tag, note.tag): note
        for step in steps
        for note in step.annotations
        if isinstance(note, nodes.UntilStart | nodes.UntilEnd)
    }
    for (tag, other), note in marks.items():
        one, by = places[tag], places[other]
        if one == by or net.order is None:
            continue
        if net.is_before(one, by):
            why = f"`{other}` begins only when `{tag}` has ended"
        elif net.is_before(by, one):
            why = f"`{other}` has ended when `{tag}` could begin"
        else:
            back = marks.get((other, tag))
            if isinstance(note, nodes.UntilStart) and not isinstance(
                back, nodes.UntilStart
            ):
                yield from _begins_together(run, steps[one], steps[by], note, net, by)
            continue
        yield Diagnostic(
            rule=IDLE.name,
            message=f"this never ends a step at work: {why}",
            span=note.span,
            labels=(Label(steps[by].span, "the other step"),),
            help="leave this out, or what puts the two steps in order",
        )


def _begins_together(
    run: Pass,
    step: nodes.Step,
    other: nodes.Step,
    note: nodes.UntilStart,
    net: Net,
    by: int,
) -> Iterator[Diagnostic]:
    if net.edges[by] or may_wait(run, other) or step.priority > other.priority:
        return
    yield Diagnostic(
        rule=AT_ONCE.name,
        message=f"`{other.tag}` can start at once, and takes `{step.tag}` away then",
        span=note.span,
        labels=(Label(other.span, "nothing keeps this one back"),),
        help=f"write `(until-end {other.tag})`, or let that step wait",
    )
