"""Signals and the steps that wait for them (`wait-for`, [L 4.32])."""

from __future__ import annotations

from rapc.base.resources import Value
from rapc.base.values import Fact, format_list
from rapc.ir import nodes
from rapc.runtime.events import events
from tests.reference.endings import bindings_repeat, clear, fail, succeed
from tests.reference.run import Run
from tests.reference.tasks import Task
from tests.reference.terms import Fault
from tests.reference.waking import may_run


def hear(run: Run, content: Fact) -> None:
    """A signal has come; what waits for it hears it, by task number."""
    run.tell(events.Signal, task=None, what=format_list(content))
    listening = [t for t in run.live() if t.place is not None and t.place.listens]
    for task in listening:
        if task.live:
            one_hears(run, task, content)


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
