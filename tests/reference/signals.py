"""Signals and the steps that wait for them (`wait-for`, [L 4.32])."""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.resources import Value
from rapc.base.values import Fact, format_list
from rapc.ir import nodes
from rapc.runtime.events import events
from tests.reference.endings import bindings_repeat, clear, fail, succeed
from tests.reference.run import Run
from tests.reference.tasks import Running, Task
from tests.reference.terms import Fault
from tests.reference.waking import may_run


def hear(run: Run, content: Fact, tickets: Sequence[int] = ()) -> None:
    """A signal has come; what waits for it hears it, by task number.

    With `tickets` it arose under these requests: then what waits beside their tasks or
    above.
    """
    owners = [nearest(run.owners[ticket]) for ticket in sorted(set(tickets))]
    alive = [task for task in owners if task is not None]
    number = alive[0].number if alive else None
    run.tell(events.Signal, task=number, what=format_list(content))
    listening = [t for t in run.live() if t.place is not None and t.place.listens]
    if tickets:
        around = [above for task in alive for above in methods_around(task)]
        listening = [task for task in listening if task.parent in around]
    for task in listening:
        if task.live:
            one_hears(run, task, content)


def nearest(task: Task) -> Task | None:
    """A task or, if it has ended, the nearest ancestor that has not."""
    return next((each for each in task.line() if each.live), None)


def methods_around(task: Task) -> list[Running]:
    """The method of a task, the one that it is a step of, and those above."""
    own = [task.running] if task.running is not None else []
    return own + [each.parent for each in task.line() if each.parent is not None]


def one_hears(run: Run, task: Task, content: Fact) -> None:
    """The first of a step's waits that matches a signal says what it does."""
    assert task.place is not None
    assert task.parent is not None
    for wait in task.place.step.annotations:
        if not isinstance(wait, nodes.WaitFor):
            continue
        if wait.mode == "proceed" and task.place.goes:
            continue
        bound = matches(run, task, wait, content)
        if bound is None:
            continue
        task.parent.env.update(bound)
        if not bindings_repeat(run, task.parent):
            decide(run, task, wait.mode, content)
        return


def decide(run: Run, task: Task, mode: str, content: Fact) -> None:
    """What a signal does to a step."""
    assert task.place is not None
    if mode == "proceed":
        task.place.goes = True
        run.tell(events.TaskWoken, task=task.number, on=format_list(content))
        may_run(run, task)
    else:
        end_by_signal(run, task)
        if mode == "succeed":
            succeed(run, task, None)
        else:
            fail(run, task, "signal")


def matches(
    run: Run, task: Task, wait: nodes.WaitFor, content: Fact
) -> dict[str, Value] | None:
    """The bindings under which a signal is the awaited one, or None."""
    assert task.parent is not None
    if wait.signal != content[0] or len(wait.args) != len(content) - 1:
        return None
    asker = run.asker(task.parent.task)
    pattern = nodes.Proposition(wait.signal, wait.args)
    try:
        slots = asker.slots(pattern, task.parent.env)
    except Fault as fault:
        run.fault(task.parent.task, "wait-for", wait, str(fault))
        return None
    found = asker.unify(slots, content, task.parent.env)
    return None if found is None else dict(found)


def end_by_signal(run: Run, task: Task) -> None:
    """What the step has spawned goes."""
    if task.running is not None:
        clear(run, task.running, "signal")
