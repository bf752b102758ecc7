"""Signals, and who hears them: rules, primitives, steps [L 4.32, 9.2]."""

from __future__ import annotations

from collections.abc import Sequence

from rapc import events
from rapc.base.resources import Value
from rapc.base.values import Fact, format_list
from rapc.ir import nodes
from tests.reference.endings import (
    bindings_repeat,
    clear,
    fail,
    method_badly,
    method_well,
    succeed,
)
from tests.reference.rules import at_event, of_none
from tests.reference.run import Run
from tests.reference.skills import waits_of
from tests.reference.tasks import Running, Task
from tests.reference.terms import Fault
from tests.reference.waking import may_run


def hear(run: Run, content: Fact, tickets: Sequence[int] = ()) -> None:
    """A signal has come: rules hear it, then what waits for it, by task number.

    With `tickets` it arose under these activations and requests, and is heard around
    the tasks that have them.
    """
    under = sorted(set(tickets))
    alive = [t for t in (nearest(run.owners[one]) for one in under) if t is not None]
    number = run.owners[under[0]].number if under else None
    run.tell(events.SignalReceived, task=number, what=format_list(content))
    of_none(run, content)
    for task in those_with_rules(run, alive, bool(tickets)):
        at_event(run, task, content)
    for ticket in under:
        running = run.switched.get(ticket)
        if running is not None and running.ticket == ticket:
            primitive_hears(run, running, content)
    for task, of_step in turns(run, under, alive):
        running = task.running
        if of_step and task.live and task.place is not None and task.place.listens:
            one_hears(run, task, content)
        elif not of_step and running is not None:
            primitive_hears(run, running, content)


def those_with_rules(run: Run, owners: Sequence[Task], belongs: bool) -> list[Task]:
    """The tasks whose rules hear a signal, in their order."""
    if not belongs:
        return [task for task in reversed(run.live()) if task.running is not None]
    found: dict[int, Task] = {}
    for owner in owners:
        for task in owner.line():
            found.setdefault(task.number, task)
    return list(found.values())


def turns(
    run: Run, under: Sequence[int], owners: Sequence[Task]
) -> list[tuple[Task, bool]]:
    """What may wait for a signal, by number: primitives, and (True) steps."""
    live = run.live()
    steps = [t for t in live if t.place is not None and t.place.listens]
    primitives = [t for t in live if t.running is not None and t.running.on]
    if under:
        over = [
            run.owners[ticket]
            for ticket in under
            if ticket in run.switched
            and run.switched[ticket].ticket == ticket
            and run.switched[ticket].method.skills
        ]
        around = [above for task in owners for above in methods_around(task)]
        steps = [t for t in steps if t.parent in around or is_below(t, over)]
        primitives = [t for t in primitives if is_below(t, over)]
    found = [(task, False) for task in primitives] + [(task, True) for task in steps]
    return sorted(found, key=lambda turn: (turn[0].number, turn[1]))


def is_below(task: Task, over: Sequence[Task]) -> bool:
    """Whether one of some tasks is above a task."""
    _, *above = task.line()
    return any(each in over for each in above)


def primitive_hears(run: Run, running: Running, content: Fact) -> None:
    """The first event that a primitive of skills awaits ends its method."""
    for wait in waits_of(running) if running.on else ():
        bound = bound_by(run, running, wait, content)
        if bound is None:
            continue
        running.env.update(bound)
        if wait.mode == "succeed":
            method_well(run, running)
        else:
            symbol = wait.signal.removeprefix(":")
            running.task.symbol = symbol
            method_badly(run, running, symbol, "sibling-failed")
        return


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
    return bound_by(run, task.parent, wait, content)


def bound_by(
    run: Run, running: Running, wait: nodes.WaitFor, content: Fact
) -> dict[str, Value] | None:
    """The bindings in a method under which a signal is the awaited one, or None."""
    if wait.signal != content[0] or len(wait.args) != len(content) - 1:
        return None
    asker = run.asker(running.task)
    pattern = nodes.Proposition(wait.signal, wait.args)
    try:
        slots = asker.slots(pattern, running.env)
    except Fault as fault:
        run.fault(running.task, "wait-for", wait, str(fault))
        return None
    found = asker.unify(slots, content, running.env)
    return None if found is None else dict(found)


def end_by_signal(run: Run, task: Task) -> None:
    """What the step has spawned goes."""
    if task.running is not None:
        clear(run, task.running, "signal")
