"""The choice of a task from the agenda, made from scratch each time [L 4]."""

from __future__ import annotations

import math

from rapc import events
from tests.reference.run import Run
from tests.reference.tasks import Task
from tests.reference.waking import deadline, may_run


def eligible(run: Run) -> list[Task]:
    """The tasks that may be chosen now, by number."""
    return [t for t in run.live() if may_run(run, t) and not (t.blocked or t.held_up)]


def latest_start(task: Task) -> float:
    """Deadline minus duration; without a deadline it is last."""
    found = deadline(task)
    return math.inf if found is None else found - task.duration


def choose(run: Run) -> Task | None:
    """The task to process now, or None; the stack of families changes with it."""
    found = eligible(run)
    if not found:
        return None
    highest = max(task.priority for task in found)
    while run.stack and run.stack[-1][0] > highest:
        run.stack.pop()
    found = [task for task in found if task.priority == highest]
    first = min(latest_start(task) for task in found)
    found = [task for task in found if latest_start(task) == first]
    unfailed = [task for task in found if not task.has_failed]
    found = unfailed or found
    if run.stack:
        family = [task for task in found if task.family == run.stack[-1][1]]
        found = family or found
    task = found[0]
    if len(found) > 1:
        task = found[run.random.randrange(len(found))]
    push(run, task)
    return task


def push(run: Run, task: Task) -> None:
    """A higher priority pushes; another family at the top's priority replaces it."""
    if not run.stack or task.priority > run.stack[-1][0]:
        run.stack.append((task.priority, task.family))
    elif task.family != run.stack[-1][1]:
        run.stack[-1] = (task.priority, task.family)


def tell_family(run: Run, task: Task) -> None:
    """Trace that another family than the last one was chosen."""
    if run.last_family is not None and run.last_family != task.family:
        run.tell(
            events.FamilySwitched,
            task=task.number,
            from_=run.last_family,
            to=task.family,
        )
    run.last_family = task.family
