"""The short account at the end of a run, gathered from its events."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from rapc import events
from rapc.base.values import readable
from rapc.world import OKAY

_LEFT_OVER = 20
"""How many tasks that were left over are named."""


_COUNTED: Mapping[type[events.Event], str] = {
    events.TaskFailed: "Tasks failed, at any level",
    events.DeadlineMissed: "Deadlines missed",
    events.QueryFaulted: "Faults in queries",
}
"""What is counted besides, and how it is called."""


class RunReport:
    """Counts what happens in a run; a listener for `Interpreter.listen`.

    It needs no events but those of its `kinds`.
    """

    kinds = (
        events.PrimitiveEnded,
        events.TaskFailed,
        events.DeadlineMissed,
        events.QueryFaulted,
        events.RunEnded,
    )

    def __init__(self) -> None:
        self._primitives: Counter[str] = Counter()
        self._failures: Counter[tuple[str, str]] = Counter()
        self._others: Counter[type[events.Event]] = Counter()
        self._end: events.RunEnded | None = None

    def __call__(self, event: events.Event) -> None:
        """Take one event into account."""
        if isinstance(event, events.PrimitiveEnded):
            name = str(event.request[0])
            self._primitives[name] += 1
            if event.result != OKAY:
                self._failures[name, event.result] += 1
        elif isinstance(event, events.RunEnded):
            self._end = event
        else:
            self._others[type(event)] += 1

    def lines(self) -> Iterator[str]:
        """The report: tasks and results, primitives by kind, failures, time."""
        if self._end is None:
            return
        end = self._end
        why = end.reason if end.because is None else f"{end.reason}: {end.because}"
        yield (
            f"Run over ({why}) at time {readable(end.time)} after {end.cycle} cycles."
        )
        for result in end.results:
            told = result.outcome
            if result.outcome == "failed":
                told = f"failed: {result.result}"
            standing = " (background)" if result.background else ""
            times = f"{readable(result.came)} to "
            times += "the end" if result.ended is None else readable(result.ended)
            yield f"  [{result.task}] {result.goal} {told}, {times}{standing}"
            for line in cause_lines(result.because):
                yield f"      {line}"
        if end.waiting:
            yield "Left over:"
            yield from (f"  {line}" for line in end.waiting[:_LEFT_OVER])
        total, failed = self._primitives.total(), self._failures.total()
        yield f"Primitives: {total}, of which {failed} failed."
        for name in sorted(self._primitives):
            yield f"  {name:<20} {self._primitives[name]:>6}{self._failed(name)}"
        for kind, word in _COUNTED.items():
            if self._others[kind]:
                yield f"{word}: {self._others[kind]}."

    def _failed(self, name: str) -> str:
        found = [
            f"{count} {result}"
            for (primitive, result), count in sorted(self._failures.items())
            if primitive == name
        ]
        return f"   ({', '.join(found)})" if found else ""


def cause_lines(cause: events.Cause | None) -> Iterator[str]:
    """Say why something failed, one line for each link down to the first cause."""
    while cause is not None:
        yield f"because of {cause.line()}"
        for method in cause.methods:
            yield f"  {method.line()}"
        if cause.skipped:
            yield f"... and so on, {cause.skipped} further down"
        cause = cause.because
