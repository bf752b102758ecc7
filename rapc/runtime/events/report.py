"""The short account at the end of a run, gathered from its events."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from rapc.base.values import format_atom
from rapc.runtime.events import events
from rapc.world import OKAY

_LEFT_OVER = 20
"""How many tasks that were left over are named."""


class RunReport:
    """Counts what happens in a run; a listener for `Interpreter.listen`.

    It needs no events but those of its `kinds`.
    """

    kinds = (events.PrimitiveEnded, events.RunEnded)

    def __init__(self) -> None:
        self._primitives: Counter[str] = Counter()
        self._failures: Counter[tuple[str, str]] = Counter()
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

    def lines(self) -> Iterator[str]:
        """The report: tasks and results, primitives by kind, failures, time."""
        if self._end is None:
            return
        end = self._end
        why = end.reason if end.because is None else f"{end.reason}: {end.because}"
        yield (
            f"Run over ({why}) at time {format_atom(end.time)} "
            f"after {end.cycle} cycles."
        )
        for result in end.results:
            told = result.outcome
            if result.outcome == "failed":
                told = f"failed: {result.result}"
            standing = " (background)" if result.background else ""
            yield f"  [{result.task}] {result.goal} {told}{standing}"
        if end.waiting:
            yield "Left over:"
            yield from (f"  {line}" for line in end.waiting[:_LEFT_OVER])
        total, failed = self._primitives.total(), self._failures.total()
        yield f"Primitives: {total}, of which {failed} failed."
        for name in sorted(self._primitives):
            yield f"  {name:<20} {self._primitives[name]:>6}{self._failed(name)}"

    def _failed(self, name: str) -> str:
        found = [
            f"{count} {result}"
            for (primitive, result), count in sorted(self._failures.items())
            if primitive == name
        ]
        return f"   ({', '.join(found)})" if found else ""
