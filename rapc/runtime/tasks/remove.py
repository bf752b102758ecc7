"""Remove a task with its descendants, or mark it ended [L 3, 6].

The removal releases all that the task or its method has: its goal key, its request or
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


def remove(run: Run, task: Task, cause: str) -> None:
    """Remove a task that has not ended by itself, after all its descendants."""
    stack = [task]
    leaving = []
    while stack:
        top = stack.pop()
        leaving.append(top)
        if top.run is not None:
            stack.extend(step for step in top.run.steps if step.live)
    for gone in reversed(leaving):
        method_run = stop(run, gone)
        run.eligible.discard(gone)
        gone.state = ENDED
        unregister(run, gone)
        if method_run is not None:
            drop(run, method_run)
        if run.recorder.on:
            why = cause if gone is task else "parent-removed"
            run.recorder.emit(TaskRemoved, task=gone.number, cause=why)


def cancel_matching(run: Run, goal: Fact) -> int:
    """Remove every live top-level task that a goal matches; return their number."""
    goal = run.beliefs.canonical(goal)
    found = [
        task
        for task in (given.task for given in run.state.top_level)
        if task.live
        and match_pattern(goal, (task.plan.name, *task.goal_args)) is not None
    ]
    for task in found:
        remove(run, task, "cancelled")
    return len(found)


def stop(run: Run, task: Task) -> MethodRun | None:
    """Stop the method of a task and return the method."""
    method_run, task.run = task.run, None
    if method_run is not None and (task.plan.recursive or run.all_may_recur):
        uncount_goal(run, task)
    return method_run


def uncount_goal(run: Run, task: Task) -> None:
    """Subtract a task from the running goals."""
    others = run.state.running_goals[task.goal_key] - 1
    if others:
        run.state.running_goals[task.goal_key] = others
    else:
        del run.state.running_goals[task.goal_key]


def drop(run: Run, method_run: MethodRun) -> None:
    """Remove a method that has not ended: its request, things and notations."""
    method_run.steps = ()
    if method_run.ticket is not None:
        call_off(run, method_run)
    free(run, method_run)


def free(run: Run, method_run: MethodRun) -> None:
    """Free the things of a method, and release its notations."""
    run.things.release(method_run.task)
    for notation in method_run.notations:
        run.beliefs.release_notation(notation)


def unregister(run: Run, task: Task) -> None:
    """Unregister an ended task from things, signals, monitors and top-level tasks.

    Only these tasks are registered: top-level tasks, tasks with a `WaitState`, and
    tasks that wait for a thing.
    """
    if run.thing_waits:
        run.things.stop_waiting(task)
    if task.step is None:
        given = run.state.live_top.pop(task.number)
        run.state.foreground -= not given.background
        if run.state.reason is None:
            given.ended = run.recorder.time
    if task.wait is not None:
        if task.step is not None:
            for signal in task.step.waits:
                run.state.listening.get(signal.signal, {}).pop(task.number, None)
        run.monitors.forget(task)
        if task.plan.resources:
            run.state.resources -= task.resources
