"""What differs between two moments of a run."""

from __future__ import annotations

import msgspec

from rapc.base.values import Fact, format_list
from rapc.debug.history import History


class Difference(msgspec.Struct, frozen=True):
    """What differs between two moments."""

    #: The facts that came and went.
    came: tuple[str, ...]
    went: tuple[str, ...]
    #: The tasks that joined and left, by number with their goals.
    joined: tuple[tuple[int, str], ...]
    left: tuple[tuple[int, str], ...]
    #: The tasks whose state or method is another: number, goal, before, after.
    changed: tuple[tuple[int, str, str, str], ...]


_Task = tuple[str, str]


class _Snapshot(msgspec.Struct):
    facts: dict[Fact, None]
    tasks: dict[int, _Task]


def between(history: History, first: int, second: int) -> Difference:
    """Return what differs between the ends of two cycles.

    Raises:
        StateError: if the run cannot be taken back in time.
    """
    one, other = _at(history, first), _at(history, second)
    return Difference(
        came=tuple(format_list(f) for f in other.facts if f not in one.facts),
        went=tuple(format_list(f) for f in one.facts if f not in other.facts),
        joined=tuple((n, t[0]) for n, t in other.tasks.items() if n not in one.tasks),
        left=tuple((n, t[0]) for n, t in one.tasks.items() if n not in other.tasks),
        changed=tuple(
            (n, task[0], one.tasks[n][1], task[1])
            for n, task in other.tasks.items()
            if n in one.tasks and one.tasks[n][1] != task[1]
        ),
    )


def _at(history: History, cycle: int) -> _Snapshot:
    with history.at(cycle) as run:
        machine = run.machine
        methods = {
            task.number: "" if task.run is None else f" {task.run.plan.name}"
            for task in machine.state.live_tasks()
        }
        return _Snapshot(
            dict.fromkeys(machine.memory.facts),
            {
                entry.task: (str(entry.goal), entry.state + methods[entry.task])
                for entry in run.agenda()
            },
        )
