"""The short report at the end of a run, compiled from its events."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping

import msgspec

from rapc import events
from rapc.base.values import readable
from rapc.world import OKAY

_LEFT_OVER = 20
"""The highest number of remaining tasks in the report."""


_MOST_RAPS = 10
"""The highest number of RAPs with mended failures in a report."""

_COUNTED: Mapping[type[events.Event], str] = {
    events.TaskFailed: "Tasks failed, at any level",
    events.DeadlineMissed: "Deadlines missed",
    events.QueryFaulted: "Faults in queries",
}
"""Other counted kinds of events, with their names in the report."""


OF_DECISIONS: tuple[type[events.Event], ...] = (
    *(events.TaskCreated, events.MethodChosen, events.TaskBlocked, events.TaskWoken),
    *(events.PrimitiveRequested, events.PrimitiveEnded, events.PrimitiveCancelled),
    *(events.SkillEnabled, events.RunEnded),
)
"""The kinds of events that explain the end of a run (`rapc.debug.questions.ends`)."""

OF_GOALS: tuple[type[events.Event], ...] = (
    *OF_DECISIONS,
    *(events.RunStarted, events.TaskSelected),
    *(events.TaskSucceeded, events.TaskFailed, events.TaskRemoved),
    *(events.MethodEnded, events.MethodSuspended, events.RequestRefused),
    *(events.SkillDisabled, events.SignalReceived),
)
"""The kinds of events that show what kept the goals of a run."""


_Mended = tuple[
    dict[int, str], dict[int, list[str]], dict[int, int], list[tuple[str, str, int]]
]
_Counts = tuple[
    dict[str, int], list[tuple[str, str, int]], dict[str, int], dict[str, int]
]


class MendedFailures:
    """A listener that counts methods that failed in tasks that then went on well.

    A failure is mended if its task succeeds. In a task that has not ended by itself, a
    failure is mended if a later method of the task succeeds.
    """

    kinds = (
        events.TaskCreated,
        events.MethodEnded,
        events.TaskSucceeded,
        events.TaskFailed,
    )

    def __init__(self) -> None:
        self._raps: dict[int, str] = {}
        #: The failures of tasks that have not succeeded or failed, by task.
        self._open: dict[int, list[str]] = {}
        #: How many of these failures precede a method that succeeded.
        self._retried: dict[int, int] = {}
        self._mended: Counter[tuple[str, str]] = Counter()

    def __call__(self, event: events.Event) -> None:
        """Process one event."""
        if isinstance(event, events.TaskCreated):
            self._raps[event.task] = event.goal.name
        elif isinstance(event, events.MethodEnded):
            if event.result != OKAY:
                self._open.setdefault(event.task, []).append(event.result)
            elif event.task in self._open:
                self._retried[event.task] = len(self._open[event.task])
        elif isinstance(event, events.TaskSucceeded | events.TaskFailed):
            rap, failed = self._raps.pop(event.task), self._open.pop(event.task, ())
            self._retried.pop(event.task, None)
            if isinstance(event, events.TaskSucceeded):
                self._mended.update((rap, result) for result in failed)

    def state(self) -> bytes:
        """Return the state, for a report on the rest of the run."""
        mended = [(*key, count) for key, count in self._mended.items()]
        return msgspec.json.encode((self._raps, self._open, self._retried, mended))

    def take_up(self, state: bytes) -> None:
        """Replace the state. Raises ValueError for bytes that `state` did not make."""
        found = msgspec.json.decode(state, type=_Mended)
        self._raps, self._open, self._retried, mended = found
        self._mended = Counter({(rap, said): count for rap, said, count in mended})

    def counts(self) -> Counter[tuple[str, str]]:
        """Return the mended failures so far, by RAP and reason."""
        found = self._mended.copy()
        for task, number in self._retried.items():
            results = self._open[task][:number]
            found.update((self._raps[task], result) for result in results)
        return found

    def lines(self) -> list[str]:
        """Return a line for each RAP, the most frequent failures first."""
        raps: dict[str, list[tuple[int, str]]] = {}
        for (rap, result), count in self.counts().items():
            raps.setdefault(rap, []).append((count, result))

        def frequent(item: tuple[str, list[tuple[int, str]]]) -> tuple[int, str]:
            return -sum(count for count, _ in item[1]), item[0]

        lines = []
        for rap, results in sorted(raps.items(), key=frequent):
            ordered = sorted(results, key=lambda one: (-one[0], one[1]))
            said = ", ".join(f"{count} {result}" for count, result in ordered)
            lines.append(f"{rap:<20} {said}")
        more = len(lines) - _MOST_RAPS
        return lines[:_MOST_RAPS] + ([f"and {more} more RAPs"] if more > 0 else [])


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

    def state(self) -> bytes:
        """Return the state, for a report on the rest of the run."""
        failures = [(*key, count) for key, count in self.failures.items()]
        others = {kind.__name__: count for kind, count in self.others.items()}
        return msgspec.json.encode((self.primitives, failures, self.successes, others))

    def take_up(self, state: bytes) -> None:
        """Replace the state. Raises ValueError for bytes that `state` did not make."""
        found = msgspec.json.decode(state, type=_Counts)
        primitives, failures, successes, others = found
        self.primitives, self.successes = Counter(primitives), Counter(successes)
        self.failures = Counter({(name, said): n for name, said, n in failures})
        kinds = {kind.__name__: kind for kind in self.kinds}
        self.others = Counter({kinds[name]: n for name, n in others.items()})

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
        first, *rest = cause.lines()
        yield f"because of {first}"
        yield from rest
        if cause.skipped:
            yield f"... and so on, {cause.skipped} further down"
        cause = cause.because
