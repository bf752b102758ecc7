"""Rename an item in all live tasks after a merge of two items.

From the moment of the merge, bindings, inputs, sets, the recursion test and the
futile-loop detector contain an item only by its older name [T 2.3.3]. A host may still
use the other name in queries.
"""

from __future__ import annotations

from typing import Any

from rapc.base.resources import SetResource
from rapc.runtime.run import Run
from rapc.runtime.state.deadlocks import Circle, deadlocks
from rapc.runtime.state.task import Env, Task


def rename(run: Run, lost: str, kept: str) -> None:
    """Replace the name `lost` by `kept` in every live task."""
    sets: dict[int, SetResource] = {}
    for task in run.state.live_tasks():
        environments = [task.env]
        if task.history is not None and task.history.success is not None:
            environments.append(task.history.success)
        if task.run is not None:
            environments.append(task.run.env)
        for env in environments:
            for value in env.values():
                if isinstance(value, SetResource):
                    sets[id(value)] = value
        if _in_task(task, environments, lost, kept):
            run.monitors.rebind(task)
    _in_things(run, lost, kept)
    run.recount_running_goals()
    for resource in sets.values():
        if lost in resource.members:
            _in_set(resource, lost, kept)
            run.monitors.listeners.resource_changed(resource)


def _in_things(run: Run, lost: str, kept: str) -> None:
    """Rename an item in held and awaited things; report the deadlocks that close."""
    things = run.things
    before = [_members(circle) for circle in deadlocks(things)]
    things.rename(lost, kept)
    for circle in deadlocks(things):
        if _members(circle) not in before:
            run.monitors.tell_deadlock(circle)


def _members(circle: Circle) -> set[int]:
    return {wait.task.number for wait, _ in circle}


def _in_task(task: Task, environments: list[Env], lost: str, kept: str) -> bool:
    """Rename in one task; return whether bindings of its monitors change."""
    task.told = None
    if task.goal_args:
        if lost in task.goal_args:
            task.goal_args = tuple([kept if a == lost else a for a in task.goal_args])
        task.goal_key = _in_value(task.goal_key, lost, kept)
    task.choice = _in_value(task.choice, lost, kept)
    if task.history is not None:
        counts: dict[tuple[object, ...], int] = {}
        for key, count in task.history.choices.items():
            renamed = _in_value(key, lost, kept)
            counts[renamed] = counts.get(renamed, 0) + count
        task.history.choices = counts
        last = task.history.last_choice
        task.history.last_choice = _in_value(last, lost, kept)
    seen = lost in task.env.values()
    for env in environments:
        if lost in env.values():
            for name in [name for name, value in env.items() if value == lost]:
                env[name] = kept
    return seen


def _in_set(resource: SetResource, lost: str, kept: str) -> None:
    members = [kept if member == lost else member for member in resource.members]
    resource.members = dict.fromkeys(members)


_NESTED = (tuple, frozenset)


def _in_value(value: Any, lost: str, kept: str) -> Any:
    """Return a frozen value with an item renamed; sets and tuples may be nested."""
    if isinstance(value, _NESTED):
        parts = [
            _in_value(part, lost, kept)
            if isinstance(part, _NESTED)
            else kept
            if part == lost
            else part
            for part in value
        ]
        return tuple(parts) if isinstance(value, tuple) else frozenset(parts)
    return kept if value == lost else value
