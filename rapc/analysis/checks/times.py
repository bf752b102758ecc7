"""RAP120 to RAP122: windows that never open, and times without duration."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.analysis.check import Pass, check
from rapc.analysis.facts.index import INDEX
from rapc.analysis.facts.logic import is_never, number_of
from rapc.base.diagnostics import (
    Applicability,
    Diagnostic,
    Edit,
    Fix,
    Label,
    Rule,
    Severity,
)
from rapc.base.source import Span
from rapc.base.values import Number, format_atom
from rapc.ir import nodes

WINDOW = Rule(
    code="RAP120",
    name="empty-window",
    severity=Severity.WARNING,
    summary="a window closes before it opens, or before its step can end",
    fix="unsafe: swaps the two times",
    ignore="never: the step cannot end in time",
    source="T 4.5.2, 4.7.1",
)

RESTLESS = Rule(
    code="RAP121",
    name="restless-monitor",
    severity=Severity.WARNING,
    summary="a standing task never pauses between its methods",
    ignore="where every method takes time, for example to drive",
    source="T 4.7.2",
)

STALE = Rule(
    code="RAP122",
    name="never-fresh",
    severity=Severity.WARNING,
    summary="a belief with an age of zero or less is queried",
    ignore="never: query the default itself if this is meant",
    source="T 4.1.1",
)


@check(WINDOW, RESTLESS, STALE)
def times(run: Pass) -> Iterator[Diagnostic]:
    """Find windows that are never open, and times that allow no waiting."""
    index = run.result(INDEX)
    for one in index.of(nodes.Window):
        step = one.parent
        assert isinstance(step, nodes.Step)
        yield from _window(run, one.node, step)
    for timed in index.of(nodes.MonitorTime):
        rap = timed.parent
        assert isinstance(rap, nodes.DefineRap)
        yield from _monitor(timed.node, rap)
    for believe in index.of(nodes.Believe):
        age = number_of(believe.node.age)
        if age is not None and age <= 0:
            yield STALE.at(
                believe.node.age.span,
                f"no belief is younger than {format_atom(age)}",
                help="write the maximal age in time units",
            )


def _window(run: Pass, window: nodes.Window, step: nodes.Step) -> Iterator[Diagnostic]:
    start, stop = number_of(window.start), number_of(window.stop)
    if start is None or stop is None:
        return
    if start > stop:
        yield _turned_round(window, start, stop)
        return
    rap = run.library.raps.get(step.goal.name)
    takes = number_of(rap.duration) if rap is not None else None
    if rap is not None and takes is not None and start + takes > stop:
        assert rap.duration is not None
        yield WINDOW.at(
            window.span,
            f"the window is open for {format_atom(stop - start)}, but "
            f"`{rap.name}` takes {format_atom(takes)}",
            labels=(Label(rap.duration.span, "declared here"),),
            help="open the window earlier, or close the window later",
        )


def _turned_round(
    timed: nodes.Window | nodes.MonitorTime, start: Number, stop: Number
) -> Diagnostic:
    what = "window" if isinstance(timed, nodes.Window) else "`monitor-time`"
    one, other = timed.start.span, timed.stop.span
    edits = (Edit(one, format_atom(stop)), Edit(other, format_atom(start)))
    return WINDOW.at(
        Span(one.file, one.start, other.end),
        f"this {what} closes at {format_atom(stop)}, before it opens at "
        f"{format_atom(start)}",
        help="write the opening time first",
        fix=Fix(Applicability.UNSAFE, "swap the two times", edits),
    )


def _monitor(timed: nodes.MonitorTime, rap: nodes.DefineRap) -> Iterator[Diagnostic]:
    start, stop = number_of(timed.start), number_of(timed.stop)
    if start is not None and stop is not None and start > stop:
        yield _turned_round(timed, start, stop)
    waits = rap.monitor_state is not None or timed.reference != "now"
    stands = is_never(rap.succeed)
    if start is not None and start <= 0 and stands and not waits:
        yield RESTLESS.at(
            timed.start.span,
            f"`{rap.name}` never pauses between its methods",
            help="write a pause above 0 in `monitor-time`",
        )
