"""What is measured of a run: the numbers of T figure 6.7, gathered from its events."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import msgspec

from rapc.runtime.events import events
from rapc.world import OKAY, Offer, Time

LABELS: Mapping[str, str] = {
    "completed": "completed",
    "given-up": "given up",
    "pending": "pending",
    "time": "time",
    "time-each": "time each",
    "effector": "effector",
    "sensor": "sensor",
    "failed": "failed",
    "percent-sensor": "% sensor",
    "percent-failed": "% failed",
}
"""The measures by the names that files of experiments have for them, as printed.

`time-each` is the whole time divided by the tasks completed, as T 6.3.1 has it;
`percent-failed` are the primitives that failed, of all.
"""


class Measures(msgspec.Struct, frozen=True):
    """What came of a run.

    `reason` is why it was over, `disaster` what the world says if it ended the run;
    `time` the time units it took; `completed`, `given_up` and `pending` count the
    tasks that are counted; `effector`, `sensor` and `failed` the primitives that
    ended, those that only look apart; `counts` successes of the RAPs and
    primitives named for it.
    """

    reason: str
    disaster: str | None
    time: Time
    completed: int
    given_up: int
    pending: int
    effector: int
    sensor: int
    failed: int
    counts: Mapping[str, int]


class Tally:
    """Counts what happens in a run; a listener for `Interpreter.listen`.

    It needs no events but those of its `kinds`.

    Args:
        offer: what the world offers, with its sensors.
        count: RAPs and primitives whose successes are counted, by what they are called.
    """

    kinds = (events.PrimitiveEnded, events.TaskSucceeded)

    def __init__(self, offer: Offer, count: Mapping[str, str]) -> None:
        self._sensors = frozenset(offer.sensors)
        self._count = count
        self._successes = Counter(dict.fromkeys(count.values(), 0))
        self.sensor = self.effector = self.failed = 0

    def __call__(self, event: events.Event) -> None:
        """Take one event into account."""
        if isinstance(event, events.PrimitiveEnded):
            name = str(event.request[0])
            if name in self._sensors:
                self.sensor += 1
            else:
                self.effector += 1
            if event.result != OKAY:
                self.failed += 1
            elif name in self._successes:
                self._successes[name] += 1
        elif isinstance(event, events.TaskSucceeded):
            name = event.goal.name
            if name in self._successes:
                self._successes[name] += 1

    def counts(self) -> dict[str, int]:
        """How often each RAP or primitive that is counted has succeeded."""
        return {name: self._successes[what] for name, what in self._count.items()}


def outcomes(
    given: Sequence[str], results: Iterable[events.TaskResult]
) -> tuple[int, int, int]:
    """How many of the tasks given were completed, given up, and are pending.

    Args:
        given: the RAP of each task that is counted, whether it has begun or not.
        results: what became of all tasks that have begun.
    """
    counted = [
        result.outcome
        for result in results
        if result.goal.name in given and not result.background
    ]
    completed, given_up = counted.count("succeeded"), counted.count("failed")
    return completed, given_up, len(given) - completed - given_up


def numbers_of(measures: Measures) -> dict[str, float]:
    """The numbers of a run by their names in `LABELS`, and what was counted besides."""
    primitives = measures.effector + measures.sensor
    numbers: dict[str, float] = {
        "completed": measures.completed,
        "given-up": measures.given_up,
        "pending": measures.pending,
        "time": measures.time,
        "effector": measures.effector,
        "sensor": measures.sensor,
        "failed": measures.failed,
        **measures.counts,
    }
    if primitives:
        numbers["percent-sensor"] = 100 * measures.sensor / primitives
        numbers["percent-failed"] = 100 * measures.failed / primitives
    return with_time_each(numbers)


def with_time_each(numbers: Mapping[str, float]) -> dict[str, float]:
    """Numbers with the time for each task completed, where it can be told."""
    if "time-each" in numbers or not numbers.get("completed") or "time" not in numbers:
        return dict(numbers)
    return {**numbers, "time-each": numbers["time"] / numbers["completed"]}
