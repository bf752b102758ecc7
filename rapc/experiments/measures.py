"""What is measured of a run: the numbers of T figure 6.7, gathered from its events."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from typing import Any

import msgspec

from rapc import events
from rapc.base.values import is_number
from rapc.runtime.held_world import HeldWorld
from rapc.world import Time, Truthful, World

LABELS: Mapping[str, str] = {
    "completed": "completed",
    "given-up": "given up",
    "pending": "pending",
    "time": "time",
    "time-each": "time each",
    "task-time": "task time",
    "effector": "effector",
    "sensor": "sensor",
    "failed": "failed",
    "percent-sensor": "% sensor",
    "percent-failed": "% failed",
    "missed-deadlines": "missed deadlines",
    "query-faults": "query faults",
}
"""The measures by the names that files of experiments have for them, as printed.

`time-each` is the whole time divided by the tasks completed, as T 6.3.1 has it;
`task-time` goes from when a task came to when it succeeded, on average;
`percent-failed` are the primitives that failed, of all.
"""


class TaskTold(msgspec.Struct, frozen=True):
    """What became of one of the tasks that are counted."""

    goal: str
    came: Time
    #: When it succeeded or failed; None if it did neither.
    ended: Time | None
    outcome: str
    #: Why it failed, in a line; empty if it has not.
    reason: str = ""


class Measures(msgspec.Struct, frozen=True):
    """What came of a run."""

    #: Why it was over, and what the world says if it ended the run.
    reason: str
    disaster: str | None
    #: The time units it took.
    time: Time
    #: What became of the tasks that are counted.
    completed: int
    given_up: int
    pending: int
    #: Primitives that ended, those that only look apart, and all that failed.
    effector: int
    sensor: int
    failed: int
    #: Successes of the RAPs and primitives named for it.
    counts: Mapping[str, int]
    missed_deadlines: int = 0
    query_faults: int = 0
    #: What the world tells of the truth, of what was asked for.
    figures: Mapping[str, float] = {}
    #: The tasks that are counted and have come, in the order in which they came.
    tasks: tuple[TaskTold, ...] = ()


def tasks_told(
    raps: Container[str], results: Iterable[events.TaskResult]
) -> tuple[TaskTold, ...]:
    """Return what became of the tasks in the foreground that are of `raps`.

    Args:
        raps: the names of the RAPs whose tasks are counted.
        results: what became of all tasks that have come, in that order.
    """
    return tuple(
        [
            TaskTold(
                str(result.goal),
                result.came,
                result.ended,
                result.outcome,
                _reason(result) if result.outcome == "failed" else "",
            )
            for result in results
            if result.goal.name in raps and not result.background
        ]
    )


def _reason(result: events.TaskResult) -> str:
    """Return why a task has failed: the clause that it all came from.

    What was bound is left out, so that failures of one kind read alike.
    """
    first = result.because
    if first is None:
        return str(result.result)
    while first.because is not None:
        first = first.because
    return f"{result.result}: {_clause(first)}"


def _clause(cause: events.Cause) -> str:
    said = cause.clause
    if cause.note and not cause.part:
        return f"{said}, {cause.note}"
    return f"{said}, {cause.part}" if cause.part else said


def figures_of(world: World) -> dict[str, float]:
    """Return the numbers that a world tells of the truth; none if it tells none.

    Raises:
        PortError: if the world breaks, or returns no mapping.
    """
    held = HeldWorld(world)
    told: Any = held.figures() if isinstance(held, Truthful) else {}
    return {n.replace("_", "-"): v for n, v in told.items() if is_number(v)}


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
        "missed-deadlines": measures.missed_deadlines,
        "query-faults": measures.query_faults,
        **measures.counts,
        **measures.figures,
    }
    took = [
        task.ended - task.came
        for task in measures.tasks
        if task.outcome == "succeeded" and task.ended is not None
    ]
    if took:
        numbers["task-time"] = sum(took) / len(took)
    if primitives:
        numbers["percent-sensor"] = 100 * measures.sensor / primitives
        numbers["percent-failed"] = 100 * measures.failed / primitives
    return with_time_each(numbers)


def with_time_each(numbers: Mapping[str, float]) -> dict[str, float]:
    """Numbers with the time for each task completed, where it can be told."""
    if "time-each" in numbers or not numbers.get("completed") or "time" not in numbers:
        return dict(numbers)
    return {**numbers, "time-each": numbers["time"] / numbers["completed"]}
