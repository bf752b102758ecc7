"""What the methods under way have been chosen for, and what of that is no longer so."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import msgspec

from rapc import events
from rapc.base.resources import Value
from rapc.base.values import Fact
from rapc.debug.acts import live_task
from rapc.debug.clause import ClauseAsked, ask
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.debug.why import method_supports
from rapc.debug.why_not import methods
from rapc.errors import ArgumentError
from rapc.runtime.machine import Machine
from rapc.runtime.state.task import Task
from rapc.runtime.tasks.start import read_inputs
from rapc.world import Time


class Commitment(msgspec.Struct, frozen=True):
    """A method under way, what its choice rested on, and what of that has gone."""

    task: int
    goal: str
    method: str
    cycle: int
    time: Time
    bindings: Mapping[str, Value]
    rested_on: tuple[Fact, ...]
    #: Those of them that are no longer believed.
    gone: tuple[Fact, ...]
    #: The context asked again with what the task was given alone.
    now: ClauseAsked | None
    #: The methods that hold now, each with what it would bind.
    would: tuple[tuple[str, Mapping[str, Value]], ...]


def commitment(history: History, number: int) -> Commitment:
    """Return what the choice of a task's method rested on, and what has changed.

    Raises:
        ArgumentError: if the task is at work on no method.
        StateError: if the run cannot be taken back in time.
    """
    task = live_task(history.run, number)
    if task.run is None:
        raise ArgumentError(f"task [{number}] is at work on no method")
    told = _chosen_at(history, number)
    with history.at(told.cycle - 1) as run:
        run.come_to_choice()
        before = live_task(run, number)
        if not before.bound:
            read_inputs(run.machine, before)
        names = run.machine.state.methods(before.plan)
        plan = next((m for m in names if m.name == told.keys["method"]), None)
        facts = tuple(one.fact for one in method_supports(run.machine, before, plan))
    machine = history.run.machine
    task = live_task(history.run, number)
    method = task.run.plan if task.run is not None else None
    now = None
    if method is not None and method.choice is not None:
        now = ask(machine, "its context now", method.choice, task, task.env)
    return Commitment(
        task=number,
        goal=str(task.goal()),
        method=told.keys["method"],
        cycle=told.cycle,
        time=told.time,
        bindings=told.keys["bindings"],
        rested_on=facts,
        gone=tuple(fact for fact in facts if fact not in machine.memory.facts),
        now=now,
        would=tuple(_would(machine, task)),
    )


def _would(machine: Machine, task: Task) -> Iterable[tuple[str, Mapping[str, Value]]]:
    for answer in methods(machine, task):
        if answer.holds:
            yield answer.name, {} if answer.context is None else answer.context.bindings


def _chosen_at(history: History, number: int) -> ToldEvent:
    """Return the event in which the method was chosen that a task is at work on."""
    found = history.last(
        events.MethodChosen, want=lambda told: told.keys["task"] == number
    )
    assert found is not None
    return found


def stale(history: History) -> list[Commitment]:
    """Return the methods under way whose choice rested on what is no longer so."""
    found = []
    for task in history.run.machine.state.live_tasks():
        if task.run is not None and task.run.plan.choice is not None:
            one = commitment(history, task.number)
            if one.gone:
                found.append(one)
    return found
