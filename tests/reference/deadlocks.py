"""Deadlocks: tasks that wait in a circle for things held above each other [L 8.27].

Everything is found anew whenever it is asked for.
"""

from __future__ import annotations

from tests.reference.run import Run
from tests.reference.tasks import Task
from tests.reference.things import obstacles


def circle_through(run: Run, task: Task) -> list[Task]:
    """The shortest circle of stuck tasks through one, the lowest numbers first."""
    stuck = stuck_tasks(run)
    paths = [[task]] if task in stuck else []
    reached: list[Task] = []
    while paths:
        longer = []
        for path in paths:
            for other in awaited(run, path[-1], stuck):
                if other is task:
                    return path
                if other not in reached:
                    reached.append(other)
                    longer.append([*path, other])
        paths = longer
    return []


def stuck_tasks(run: Run) -> list[Task]:
    """The tasks that wait for things, each for others of them whatever comes free."""
    stuck = [task for task in run.live() if task.held_up]
    while True:
        left = [
            task
            for task in stuck
            if all(below(run, task, n, stuck) for n in range(len(task.wanted)))
        ]
        if left == stuck:
            return stuck
        stuck = left


def awaited(run: Run, task: Task, stuck: list[Task]) -> list[Task]:
    """The stuck tasks below what is in the way of a task, by number."""
    found = [
        other for n in range(len(task.wanted)) for other in below(run, task, n, stuck)
    ]
    return sorted(set(found), key=lambda other: other.number)


def below(run: Run, task: Task, way: int, stuck: list[Task]) -> list[Task]:
    """The stuck tasks below those that are in one way of a task."""
    holders = [one.holder for one in obstacles(run, task, task.wanted[way])]
    return [
        other for other in stuck if any(h in list(other.line())[1:] for h in holders)
    ]
