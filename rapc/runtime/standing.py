"""How the tasks of a run stand, as immutable values for who is not the interpreter."""

from __future__ import annotations

from collections.abc import Iterable

from rapc.runtime.events import TaskResult
from rapc.runtime.machine import Machine
from rapc.runtime.task import State, Task


def results(given: Iterable[Task]) -> tuple[TaskResult, ...]:
    """What has become of each top-level task, in the order in which they came."""
    return tuple([_result(task) for task in given])


def _result(task: Task) -> TaskResult:
    outcome = "unfinished"
    if not task.live and task.last_result is not None:
        outcome = "succeeded" if task.succeeded else "failed"
    return TaskResult(
        task=task.number,
        goal=task.goal(),
        outcome=outcome,
        result=task.last_result if outcome != "unfinished" else None,
        background=task.background,
    )


def goals(machine: Machine) -> dict[int, str]:
    """The goals of all live tasks by number, with the inputs that are known."""
    return {number: task.goal() for number, task in machine.tasks.items()}


def waiting(machine: Machine) -> tuple[str, ...]:
    """Each task that is not done, and what it waits for, for a person to read.

    Tasks that wait for their own steps are left out.
    """
    return tuple(
        f"{task.goal()} [{task.number}] {_awaited(machine, task)}"
        for task in machine.tasks.values()
        if task.run is None and (not task.waiting or task.held)
    )


def _awaited(machine: Machine, task: Task) -> str:
    if task.held:
        return f"waits for {task.blocked_on}"
    if task.state is State.BLOCKED:
        return f"waits for {machine.monitors.reason(task)}"
    if task.state is State.ELIGIBLE:
        return "could go on"
    return "waits for its time"
