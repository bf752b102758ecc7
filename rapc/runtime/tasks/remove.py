"""Remove a task with its descendants, or mark it ended [L 3, 6].

The removal releases all that the task or its method has: its identity, its request or
skills, things, notations, and its registrations as a listener. Not here: whether a task
has succeeded, and the consequences (`rapc.runtime.tasks.finish`). Removal of whole
subtrees is iterative: the depth of tasks has no limit.
"""

from __future__ import annotations

from rapc.base.values import Fact, match_pattern
from rapc.events import TaskRemoved
from rapc.runtime.run import Run
from rapc.runtime.state.states import ENDED
from rapc.runtime.state.task import MethodRun, Task
from rapc.runtime.tasks.activations import call_off


def remove(machine: Run, task: Task, cause: str) -> None:
    """Remove a task that has not ended by itself, after all its descendants."""
    stack = [task]
    leaving = []
    while stack:
        top = stack.pop()
        leaving.append(top)
        if top.run is not None:
            stack.extend(step for step in top.run.steps if step.live)
    for gone in reversed(leaving):
        run = stop(machine, gone)
        machine.eligible.discard(gone)
        gone.state = ENDED
        unregister(machine, gone)
        if run is not None:
            drop(machine, run)
        if machine.recorder.on:
            why = cause if gone is task else "parent-removed"
            machine.recorder.emit(TaskRemoved, task=gone.number, cause=why)


def cancel_matching(machine: Run, goal: Fact) -> int:
    """Remove every live top-level task that a goal matches; return their number."""
    goal = machine.beliefs.canonical(goal)
    found = [
        task
        for task in (given.task for given in machine.state.top_level)
        if task.live
        and match_pattern(goal, (task.plan.name, *task.goal_args)) is not None
    ]
    for task in found:
        remove(machine, task, "cancelled")
    return len(found)


def stop(machine: Run, task: Task) -> MethodRun | None:
    """Stop the method of a task and return the method."""
    run, task.run = task.run, None
    if run is not None and (task.plan.recursive or machine.all_may_recur):
        discount(machine, task)
    return run


def discount(machine: Run, task: Task) -> None:
    """Subtract a task's identity from the active identities."""
    others = machine.state.active_identities[task.identity] - 1
    if others:
        machine.state.active_identities[task.identity] = others
    else:
        del machine.state.active_identities[task.identity]


def drop(machine: Run, run: MethodRun) -> None:
    """Remove a method that has not ended: its request, things and notations."""
    run.steps = ()
    if run.ticket is not None:
        call_off(machine, run)
    free(machine, run)


def free(machine: Run, run: MethodRun) -> None:
    """Free the things of a method, and release its notations."""
    machine.things.release(run.task)
    for notation in run.notations:
        machine.beliefs.release_notation(notation)


def unregister(machine: Run, task: Task) -> None:
    """Unregister an ended task from things, signals, monitors and top-level tasks.

    Only these tasks are registered: top-level tasks, tasks with a `WaitState`, and
    tasks that wait for a thing.
    """
    if machine.waits:
        machine.things.stop_waiting(task)
    if task.step is None:
        given = machine.state.live_top.pop(task.number)
        machine.state.foreground -= not given.background
        if not machine.state.over:
            given.ended = machine.recorder.time
    if task.wait is not None:
        if task.step is not None:
            for signal in task.step.waits:
                machine.state.listening.get(signal.signal, {}).pop(task.number, None)
        machine.monitors.forget(task)
