"""Commitments: the facts behind the choice of each method under way."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import msgspec

from rapc import events
from rapc.base.resources import Value
from rapc.base.values import Fact, format_list, readable
from rapc.debug.answer import Answer, bound_to, question, say
from rapc.debug.arguments import Arguments
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.debug.questions.why import method_supports
from rapc.debug.questions.why_not import ClauseAsked, ask, methods
from rapc.errors import ArgumentError


class Commitment(msgspec.Struct, frozen=True):
    """A method under way, with the supporting facts of its choice."""

    task: int
    goal: str
    #: The event of the choice.
    chosen: ToldEvent
    rested_on: tuple[Fact, ...]
    #: The supporting facts that memory no longer contains.
    gone: tuple[Fact, ...]
    #: The context, evaluated again with only the inputs of the task bound.
    now: ClauseAsked | None
    #: The methods whose context holds now, each with its bindings.
    would: tuple[tuple[str, Mapping[str, Value]], ...]


@question("chosen [TASK]", ":when chosen 106", ":when chosen")
def when(history: History, args: Arguments) -> Answer:
    """List the facts that a choice of method relied on, and changes since.

    Without a task, list all methods under way that rely on facts that have changed.
    """
    args.takes("chosen")
    found = [commitment(history, args.task(history))] if args else stale(history)
    if not found:
        return say("no method under way relies on facts that have changed")
    return say(*(line for one in found for line in _lines(one)))


def _lines(one: Commitment) -> Iterator[str]:
    keys = one.chosen.keys
    at = f"in cycle {one.chosen.cycle}, at time {readable(one.chosen.time)}"
    chose = f"{keys['method']}{bound_to(keys['bindings'])}"
    yield f"[{one.task}] {one.goal} chose {chose} {at}"
    for fact in one.rested_on:
        mark = "no longer in memory" if fact in one.gone else "still in memory"
        yield f"  because of {format_list(fact)}: {mark}"
    if one.now is not None and not one.now.holds:
        yield f"  now: {one.now.in_a_line()}"
    would = ", or ".join(f"{name}{bound_to(bound)}" for name, bound in one.would)
    yield f"  choice now: {would or 'no method'}"


def commitment(history: History, number: int) -> Commitment:
    """Return the commitment of a task: its method and the supporting facts.

    Raises:
        ArgumentError: if the task has no method under way.
        StateError: if the run cannot go back.
    """
    if history.run.task(number).run is None:
        raise ArgumentError(f"task [{number}] has no method under way")
    told = history.last(events.MethodChosen, want=lambda o: o.keys["task"] == number)
    assert told is not None
    with history.at_choice(told.cycle) as run:
        before = run.task(number)
        run.read_inputs(before)
        plans = run.methods(before.plan)
        plan = next((m for m in plans if m.name == told.keys["method"]), None)
        facts = tuple(method_supports(run, before, plan))
    run, task = history.run, history.run.task(number)
    query = None if task.run is None else task.run.plan.choice
    now = "its context now"
    return Commitment(
        task=number,
        goal=str(task.goal()),
        chosen=told,
        rested_on=facts,
        gone=tuple(fact for fact in facts if fact not in run.memory),
        now=None if query is None else ask(run, now, query, task, task.env),
        would=tuple(
            (one.name, {} if one.context is None else one.context.bindings)
            for one in methods(run, task)
            if one.holds
        ),
    )


def stale(history: History) -> list[Commitment]:
    """Return the commitments whose supporting facts are no longer all in memory."""
    found = [
        commitment(history, task.number)
        for task in history.run.tasks()
        if task.run is not None and task.run.plan.choice is not None
    ]
    return [one for one in found if one.gone]
