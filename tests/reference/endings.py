"""How tasks and methods end, and what happens then, in which order [L 3, 6]."""

from __future__ import annotations

from typing import Any

from rapc import events
from rapc.base.resources import Counter, SetResource, Value, frozen
from rapc.base.values import format_atom, format_list, is_number
from rapc.ir import nodes
from rapc.world import OKAY
from tests.reference.rules import at_end
from tests.reference.run import Run
from tests.reference.skills import switch_off
from tests.reference.tasks import Place, Running, Task, method_name
from tests.reference.terms import Bindings
from tests.reference.waking import let_go, read_inputs, read_windows, set_delay

# --- tasks ------------------------------------------------------------------------


def succeed(run: Run, task: Task, found: Bindings | None) -> None:
    """A task has met its `succeed`, under these bindings, or a signal ended it so."""
    for variable in task.rap.outputs:
        value = (found or {}).get(variable.name, task.last_good.get(variable.name))
        if value is not None:
            task.outputs[variable.name] = value
    bound = received(task)
    changes = None if bound is None else effects(run, task, bound)
    if bound is None or changes is None:
        task.outputs = {}
        fail(run, task, "interference")
        return
    run.tell(
        events.TaskSucceeded,
        task=task.number,
        goal=task.goal(),
        outputs={name: format_atom(value) for name, value in task.outputs.items()},
    )
    task.live = False
    task.outcome = "succeeded"
    at_end(run, task, "succeed", task.outputs)
    task.last_result = OKAY
    if task.parent is not None and task.place is not None:
        task.parent.env.update(bound)
        for change in changes:
            perform(run, task, *change)
        step_ended(run, task.parent, task.place)


def received(task: Task) -> dict[str, Value] | None:
    """What the step's outputs bind in the parent's method; None if they do not fit."""
    bound: dict[str, Value] = {}
    if task.parent is None or task.place is None:
        return bound
    terms = task.place.step.goal.outputs
    for variable, term in zip(task.rap.outputs, terms, strict=True):
        value = task.outputs.get(variable.name)
        if value is None:
            continue
        if isinstance(term, nodes.Const):
            fits = term.value == value
        else:
            assert isinstance(term, nodes.Var)
            if term.anonymous:
                continue
            known = task.parent.env.get(term.name, bound.get(term.name))
            fits = known is None or known == value
            bound.setdefault(term.name, value)
        if not fits:
            return None
    return bound


def effects(
    run: Run, task: Task, bound: Bindings
) -> list[tuple[str, Counter | SetResource, Any]] | None:
    """What a step's effects will do; None if one of them cannot be done."""
    if task.parent is None or task.place is None:
        return []
    env = {**task.parent.env, **bound}
    parent = task.parent.task
    changes: list[tuple[str, Counter | SetResource, Any]] = []
    for note in task.place.step.annotations:
        if not isinstance(note, nodes.ResourceChange):
            continue
        resource, why = run.value(parent, note.resource, env)
        amount: Any = None
        if not why:
            amount, why = run.value(parent, note.amount, env)
        wanted = SetResource if note.op.startswith("set") else Counter
        if not why and not isinstance(resource, wanted):
            kind = "set" if wanted is SetResource else "counter"
            why = f"`{format_atom(resource)}` is not a {kind}"
        if not why and wanted is Counter and not is_number(amount):
            why = f"`{format_atom(amount)}` is not a number"
        if not why and isinstance(amount, Counter | SetResource):
            why = f"`{format_atom(amount)}` is not a symbol, number or string"
        if why:
            run.fault(parent, f"effect `{note.op}`", note, why)
            return None
        assert isinstance(resource, Counter | SetResource)
        changes.append((note.op, resource, amount))
    return changes


def perform(
    run: Run, task: Task, op: str, resource: Counter | SetResource, amount: Any
) -> None:
    """One effect on a resource."""
    if isinstance(resource, Counter):
        resource.add(amount if op == "counter-add" else -amount)
    elif op == "set-add":
        resource.add(amount)
    else:
        resource.remove(amount)
    what = f"{op} {format_atom(amount)}: {resource}"
    run.tell(events.ResourceChanged, task=task.number, what=what)


def step_ended(run: Run, running: Running, place: Place) -> None:
    """A step has ended by itself and well: `until`, then what follows, then the end."""
    place.ended = run.time
    for other in running.places:
        tags = [n.tag for n in other.step.annotations if isinstance(n, nodes.UntilEnd)]
        if place.step.tag in tags:
            end_by_until(run, other)
    if bindings_repeat(run, running):
        return
    follow(run, running)
    if all(each.ended is not None for each in running.places):
        method_well(run, running)


def end_by_until(run: Run, place: Place) -> None:
    """`until` takes a step away; for order and for the method it has ended."""
    if place.task is not None and place.task.live:
        remove(run, place.task, "until")
        place.ended = run.time
        place.lapsed = True


def follow(run: Run, running: Running) -> None:
    """What the end of a step lets others do: listen, or read their inputs."""
    for place in running.places:
        let_go(run, place)


def fail(run: Run, task: Task, reason: str) -> None:
    """A task fails; the method of its parent ends badly."""
    result = task.symbol or reason
    run.tell(
        events.TaskFailed,
        task=task.number,
        goal=task.goal(),
        reason=reason,
        result=result,
    )
    task.live = False
    task.outcome = "failed"
    at_end(run, task, result, {})
    task.last_result = result
    if task.parent is not None:
        if task.symbol is not None:
            task.parent.task.symbol = task.symbol
        method_badly(run, task.parent, result, "sibling-failed")


def remove(run: Run, task: Task, cause: str) -> None:
    """A task and all it spawned leave the agenda, descendants first."""
    if task.running is not None:
        clear(run, task.running, "parent-removed")
    task.live = False
    run.tell(events.TaskRemoved, task=task.number, cause=cause)


def clear(run: Run, running: Running, cause: str) -> None:
    """All that a method spawned, noted and has under way goes."""
    for place in running.places:
        if place.task is not None and place.task.live:
            remove(run, place.task, cause)
    cancel(run, running.task)
    switch_off(run, running)
    for fact in running.noted:
        run.memory.unnote(fact, running)
    running.task.running = None


def cancel(run: Run, task: Task) -> None:
    """What a task has under way in the world ends there, and the world hears of it."""
    for ticket, (request, asker) in list(run.tickets.items()):
        if asker is task:
            run.tickets[ticket] = (request, None)
            text = format_list(request)
            run.tell(events.PrimitiveCancelled, task=task.number, request=text)
            run.world.cancel(ticket)


def suspend(run: Run, task: Task, on: str, by: Task) -> None:
    """A method gives what is told to another and is gone as if never chosen."""
    running = task.running
    assert running is not None
    undo(run, running)
    task.wanted = [running.asked]
    task.held_up = True
    task.held_up_by = (on, by.number)
    run.tell(
        events.MethodSuspended,
        task=task.number,
        method=method_name(running.method),
        for_=task.held_up_by[0],
        by=by.number,
    )


def undo(run: Run, running: Running) -> None:
    """A method is gone as if its task had never chosen it."""
    task = running.task
    clear(run, running, "parent-removed")
    task.chosen[running.choice] -= 1
    task.times[running.method.position] -= 1
    if not task.chosen[running.choice]:
        del task.chosen[running.choice]
    if running.first:
        del task.tried[running.method.name]


# --- methods ----------------------------------------------------------------------


def method_well(run: Run, running: Running) -> None:
    """Every step has ended, or the primitive succeeded."""
    running.task.last_good = running.env
    method_ended(run, running, OKAY, "sibling-failed")


def method_badly(run: Run, running: Running, result: str, cause: str) -> None:
    """A step or the primitive has failed: the rest goes, the failure is recorded."""
    task, position = running.task, running.method.position
    task.failures[position] = task.failures.get(position, 0) + 1
    task.has_failed = True
    method_ended(run, running, result, cause)


def method_ended(run: Run, running: Running, result: str, cause: str) -> None:
    """The task comes up again, once whatever its monitors say."""
    task = running.task
    clear(run, running, cause)
    task.last_result = result
    task.results[running.method.name] = result
    task.once = True
    task.delay_from = run.time
    run.tell(
        events.MethodEnded,
        task=task.number,
        method=method_name(running.method),
        result=result,
    )
    if task.rap.monitor_time is not None:
        set_delay(run, task)


# --- recursion --------------------------------------------------------------------


def repeats(run: Run, running: Running, place: Place) -> bool:
    """Whether a step asks for what the task or one of its ancestors was asked for."""
    args = run.inputs(running, place.step.goal.args)
    if any(arg is None for arg in args):
        return False
    values = frozen(args)
    return any(
        ancestor.rap.name == place.step.goal.name and ancestor.bound_as == values
        for ancestor in running.task.line()
    )


def bindings_repeat(run: Run, running: Running) -> bool:
    """Whether new bindings make a step repeat an ancestor: then the spawner fails."""
    for place in running.places:
        task = place.task
        if task is None or not task.live:
            continue
        read_windows(run, task)
        if not task.full:
            read_inputs(run, task)
        if task.bound_as is None or task.compared:
            continue
        task.compared = True
        line = running.task.line()
        if any(a.rap is task.rap and a.bound_as == task.bound_as for a in line):
            method_badly(run, running, "futile-loop", "parent-failed")
            fail(run, running.task, "futile-loop")
            return True
    return False
