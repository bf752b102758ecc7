"""Measures of a run: the numbers of T figure 6.7, computed from its events."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping

import msgspec

from rapc import events
from rapc.debug.costs import Times
from rapc.world import Time

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
"""The printed labels of measures, by the names in files of experiments.

`time-each` is the whole time divided by the number of completed tasks (T 6.3.1);
`task-time` is the average time from the arrival of a task to its success;
`percent-failed` is the share of failed primitives.
"""


class TaskTold(msgspec.Struct, frozen=True):
    """The end of one of the counted tasks."""

    goal: str
    came: Time
    #: The time when the task succeeded or failed; None if it did neither.
    ended: Time | None
    outcome: str
    #: The reason of the failure, in a line; empty without a failure.
    reason: str = ""


class Measures(msgspec.Struct, frozen=True):
    """The measures of one run."""

    #: The reason of the end, and the world's reason if the world ended the run.
    reason: str
    disaster: str | None
    #: The duration in time units.
    time: Time
    #: The ends of the counted tasks.
    completed: int
    given_up: int
    pending: int
    #: Ended effector primitives, ended sensor primitives, and all failed primitives.
    effector: int
    sensor: int
    failed: int
    #: Successes of the RAPs and primitives in `count`.
    counts: Mapping[str, int]
    missed_deadlines: int = 0
    query_faults: int = 0
    #: The requested ground-truth figures of the world.
    figures: Mapping[str, float] = {}
    #: The counted tasks that have come, in the order of arrival.
    tasks: tuple[TaskTold, ...] = ()
    #: The time of the run by kind, family and request, if requested.
    times: Times | None = None


def tasks_told(
    raps: Container[str], results: Iterable[events.TaskResult]
) -> tuple[TaskTold, ...]:
    """Return the ends of the foreground tasks of `raps`.

    Args:
        raps: the names of the RAPs whose tasks are counted.
        results: the results of all tasks, in the order of arrival.
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
    """Return the reason of a task's failure: the clause of the first cause.

    Bindings are left out, so that failures of one kind have equal texts.
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


def numbers_of(measures: Measures) -> dict[str, float]:
    """Return the numbers of a run by their names in `LABELS`, and other counts."""
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
    """Return numbers with the time for each completed task, if it is defined."""
    if "time-each" in numbers or not numbers.get("completed") or "time" not in numbers:
        return dict(numbers)
    return {**numbers, "time-each": numbers["time"] / numbers["completed"]}
