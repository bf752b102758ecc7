"""Why a task came up, and what it did then: told of the cycle as it was.

The cycle is run again aside, from the moment before it: so each rule of choice is told
with the candidates that it left [T 3.2.4; L 4], and the method with the facts that its
context rested on.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec

from rapc import events
from rapc.base.resources import Value
from rapc.base.values import Fact, format_list, number
from rapc.compiler.rap_plan import MethodPlan
from rapc.debug.acts import live_task
from rapc.debug.clause import Support, supports
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.debug.why_not import MethodAnswer, last_cycle, methods
from rapc.errors import ArgumentError
from rapc.events import Cause, Event
from rapc.runtime.machine import Machine
from rapc.runtime.state.task import Task
from rapc.runtime.tasks.start import read_inputs
from rapc.world import Time


class AppliedRule(msgspec.Struct, frozen=True):
    """A rule of choice that was applied, and the tasks that it left."""

    rule: str
    left: tuple[int, ...]


class Choice(msgspec.Struct, frozen=True):
    """Why a task was the one to come up."""

    task: int
    cycle: int
    time: Time
    #: The tasks that could have come up.
    candidates: tuple[int, ...]
    rules: tuple[AppliedRule, ...]


class Origin(msgspec.Struct, frozen=True):
    """A fact that something rested on, with who had asserted it."""

    fact: Fact
    #: When it was asserted last; None if it was not in the run that is known.
    time: Time | None
    cycle: int | None
    #: By what: a primitive of a task, a datum, a notation, the user.
    by: str


class Doing(msgspec.Struct, frozen=True):
    """What a task did in its cycle, and what that rested on."""

    #: `method`, `succeeded`, `failed`, `blocked`, or `nothing` that events tell of.
    outcome: str
    #: The method chosen, or what it waits for.
    said: str
    bindings: Mapping[str, Value]
    #: The facts that the clause rested on that settled it.
    rests_on: tuple[Origin, ...]
    #: All methods as they stood then, where one was chosen.
    methods: tuple[MethodAnswer, ...]
    because: Cause | None = None


class Why(msgspec.Struct, frozen=True):
    """Why a task came up, and what it did."""

    choice: Choice
    doing: Doing


_SETTLES: Mapping[type[Event], str] = {
    events.MethodChosen: "method",
    events.TaskSucceeded: "succeeded",
    events.TaskFailed: "failed",
    events.TaskBlocked: "blocked",
}
"""The events that tell what a cycle came to."""


def why(history: History, task: int, cycle: int | None = None) -> Why:
    """Return why a task came up, in its last cycle or in the one given.

    Raises:
        ArgumentError: if it did not come up.
        StateError: if the run cannot be taken back in time.
    """
    assert history.run is not None  # of a recording that is only played, it raises
    cycle = last_cycle(history, task) if cycle is None else cycle
    told = history.scan(first=cycle, want=lambda one: one.cycle == cycle)
    if not any(o.kind is events.TaskSelected and o.keys["task"] == task for o in told):
        raise ArgumentError(f"task [{task}] did not come up in cycle {cycle}")
    settled = next(
        (o for o in told if o.kind in _SETTLES and o.keys["task"] == task), None
    )
    with history.at(cycle - 1) as run:
        run.come_to_choice()
        choice = chosen(history, task)
        found = _doing(history, task, settled)
    return Why(
        choice,
        msgspec.structs.replace(found[0], rests_on=origins(history, found[1], cycle)),
    )


def chosen(history: History, task: int) -> Choice:
    """Return why a task is the next to come up; the run is about to choose."""
    machine = history.run.machine
    agenda = machine.agenda
    sole, others = agenda.entries()
    live = {one.number: one for one in machine.state.live_tasks()}
    entries = {n: (live[n].priority, late, failed) for n, late, failed in others}
    if sole is not None:
        entries[sole] = (live[sole].priority, 0.0, False)
    left = sorted(entries)
    rules: list[AppliedRule] = []
    for rule, keep in _rules(entries, agenda.stack, live):
        if len(left) < 2:
            break
        kept = keep(left)
        if len(kept) < len(left):
            rules.append(AppliedRule(rule, tuple(kept)))
            left = kept
    if len(left) > 1:
        rules.append(AppliedRule("chance", (task,)))
    return Choice(
        task, history.cycle + 1, history.now, tuple(sorted(entries)), tuple(rules)
    )


def _rules(
    entries: Mapping[int, tuple[int, float, bool]],
    stack: Sequence[tuple[int, int]],
    live: Mapping[int, Task],
) -> list[tuple[str, Any]]:
    """Return the rules of choice, each with what keeps some of the tasks left."""

    def highest(left: list[int]) -> list[int]:
        most = max(entries[n][0] for n in left)
        return [n for n in left if entries[n][0] == most]

    def soonest(left: list[int]) -> list[int]:
        first = min(entries[n][1] for n in left)
        return [n for n in left if entries[n][1] == first]

    def fresh(left: list[int]) -> list[int]:
        found = [n for n in left if not entries[n][2]]
        return found or left

    def family(left: list[int]) -> list[int]:
        priority = entries[left[0]][0]
        open_to = [family for level, family in stack if level <= priority]
        same = [n for n in left if open_to and live[n].family == open_to[-1]]
        return same or left

    return [
        ("highest priority", highest),
        ("earliest latest start", soonest),
        ("no method has ended badly", fresh),
        ("family at work", family),
    ]


def _doing(
    history: History, number: int, settled: ToldEvent | None
) -> tuple[Doing, list[Support]]:
    """Return what a task did, and what that rested on; the run stands before it."""
    machine = history.run.machine
    task = live_task(history.run, number)
    if not task.bound:
        read_inputs(machine, task)
    outcome = "nothing" if settled is None else _SETTLES[settled.kind]
    if settled is None:
        return Doing(outcome, "", {}, (), ()), []
    keys = settled.keys
    if outcome == "method":
        found = tuple(methods(machine, task))
        plan = next(
            (m for m in machine.state.methods(task.plan) if m.name == keys["method"]),
            None,
        )
        if plan is None:
            found += (MethodAnswer(keys["method"], None, False, 0, 0, solved=True),)
        rest = method_supports(machine, task, plan)
        return Doing(outcome, keys["method"], keys["bindings"], (), found), rest
    if outcome == "succeeded":
        return Doing(outcome, "", keys["outputs"], (), ()), _of_success(machine, task)
    if outcome == "failed":
        return Doing(outcome, keys["reason"], {}, (), (), keys["because"]), []
    return Doing(outcome, keys["on"], {}, (), ()), []


def method_supports(
    machine: Machine, task: Task, method: MethodPlan | None
) -> list[Support]:
    """Return the facts that the context of a method rests on now."""
    if method is None or method.choice is None:
        return []
    found = method.choice.first(_noting(machine, task), task.env) or {}
    return supports(machine, method.choice.formula, {**task.env, **found})


def _of_success(machine: Machine, task: Task) -> list[Support]:
    query = task.plan.succeed
    if query is None:
        return []
    found = query.first(_noting(machine, task), task.env) or {}
    return supports(machine, query.formula, {**task.env, **found})


def _noting(machine: Machine, task: Task) -> Any:
    machine.noting.begin(task)
    return machine.noting


# --- where facts come from ----------------------------------------------------------


def origins(
    history: History, found: Iterable[Support], before: int
) -> tuple[Origin, ...]:
    """Return who asserted some facts last, before a cycle began."""
    wanted = {one.fact: one for one in found}
    if not wanted:
        return ()
    last: dict[Fact, ToldEvent] = {}
    for told in history.log.backwards():
        if len(last) == len(wanted):
            break
        if told.kind is events.FactAsserted and told.cycle < before:
            fact = told.keys["fact"]
            if fact in wanted:
                last.setdefault(fact, told)
    if len(last) < len(wanted) and not history.log.has(0):
        for told in history.scan(
            events.FactAsserted,
            want=lambda one: one.cycle < before and one.keys["fact"] in wanted,
        ):
            last[told.keys["fact"]] = told
    return tuple(_origin(history, one, last.get(one.fact)) for one in wanted.values())


def _origin(history: History, found: Support, told: ToldEvent | None) -> Origin:
    if told is None:
        time = None if found.since is None else number(found.since)
        return Origin(found.fact, time, None, "")
    return Origin(found.fact, told.time, told.cycle, by_whom(history, told))


def by_whom(history: History, told: ToldEvent) -> str:
    """Return in words who has asserted or erased a fact."""
    by: str = told.keys["by"]
    if told.cycle == 0 or by in ("user", "memory"):
        return by
    for one in history.scan(first=told.cycle, want=lambda o: o.cycle == told.cycle):
        if one.serial < told.serial:
            continue
        if by == "notation" and one.kind in (events.MethodEnded, events.TaskRemoved):
            break
        if one.kind is events.PrimitiveEnded:
            task = "" if one.keys["task"] is None else f" [{one.keys['task']}]"
            return f"{format_list(one.keys['request'])}{task}"
        if one.kind is events.DataReceived:
            return f"datum {format_list(one.keys['data'])}"
    chosen_by = _selected(history, told)
    return by if chosen_by is None else f"{by} of [{chosen_by}]"


def _selected(history: History, told: ToldEvent) -> int | None:
    """Return the task whose cycle an event fell into."""
    for one in history.scan(events.TaskSelected, first=told.cycle):
        if one.cycle == told.cycle:
            found: int = one.keys["task"]
            return found
    return None
