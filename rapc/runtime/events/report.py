"""The short report at the end of a run, compiled from its events."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping

from rapc import events
from rapc.base.values import readable
from rapc.world import OKAY

_LEFT_OVER = 20
"""The highest number of remaining tasks in the report."""


_COUNTED: Mapping[type[events.Event], str] = {
    events.TaskFailed: "Tasks failed, at any level",
    events.DeadlineMissed: "Deadlines missed",
    events.QueryFaulted: "Faults in queries",
}
"""Other counted kinds of events, with their names in the report."""


class RunReport:
    """A counter of the events of a run; a listener for `Interpreter.listen`.

    A report needs only the events of its `kinds`; it also counts the successes of
    tasks, if it receives them.

    Args:
        sensors: the names of the world's sensor primitives, if the world tells them
            apart; then the report also has the numbers of T figure 6.7.
    """

    kinds = (
        events.PrimitiveEnded,
        events.TaskFailed,
        events.DeadlineMissed,
        events.QueryFaulted,
        events.RunEnded,
    )

    def __init__(self, sensors: Collection[str] = ()) -> None:
        self._sensors = sensors
        #: Primitives that ended, by name; those that failed by name and result.
        self.primitives: Counter[str] = Counter()
        self.failures: Counter[tuple[str, str]] = Counter()
        #: Tasks that succeeded, by RAP.
        self.successes: Counter[str] = Counter()
        #: Other events, by kind.
        self.others: Counter[type[events.Event]] = Counter()
        self._end: events.RunEnded | None = None

    def __call__(self, event: events.Event) -> None:
        """Count one event."""
        if isinstance(event, events.PrimitiveEnded):
            name = str(event.request[0])
            self.primitives[name] += 1
            if event.result != OKAY:
                self.failures[name, event.result] += 1
        elif isinstance(event, events.TaskSucceeded):
            self.successes[event.goal.name] += 1
        elif isinstance(event, events.RunEnded):
            self._end = event
        else:
            self.others[type(event)] += 1

    def well(self, name: str) -> int:
        """Return how often a primitive, or tasks of a RAP, have succeeded."""
        failed = [n for (what, _), n in self.failures.items() if what == name]
        return self.primitives[name] - sum(failed) + self.successes[name]

    def lines(self) -> Iterator[str]:
        """Yield the lines: tasks and results, primitives by kind, failures, time."""
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
        total, failed = self.primitives.total(), self.failures.total()
        apart = ""
        if self._sensors:
            counted = [one.outcome for one in end.results if not one.background]
            done, given_up = counted.count("succeeded"), counted.count("failed")
            pending = len(counted) - done - given_up
            yield f"Tasks: {done} completed, {given_up} given up, {pending} pending."
            looked = sum(self.primitives[name] for name in set(self._sensors))
            apart = f" ({total - looked} effector, {looked} sensor)"
        yield f"Primitives: {total}{apart}, of which {failed} failed."
        for name in sorted(self.primitives):
            yield f"  {name:<20} {self.primitives[name]:>6}{self._failed(name)}"
        for kind, word in _COUNTED.items():
            if self.others[kind]:
                yield f"{word}: {self.others[kind]}."

    def _failed(self, name: str) -> str:
        found = [
            f"{count} {result}"
            for (primitive, result), count in sorted(self.failures.items())
            if primitive == name
        ]
        return f"   ({', '.join(found)})" if found else ""


def cause_lines(cause: events.Cause | None) -> Iterator[str]:
    """Yield the lines of a cause, one for each link down to the first cause."""
    while cause is not None:
        yield f"because of {cause.line()}"
        for method in cause.methods:
            yield f"  {method.line()}"
        if cause.skipped:
            yield f"... and so on, {cause.skipped} further down"
        cause = cause.because
