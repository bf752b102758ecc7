"""What stands now: tasks with what they wait for, families, chains, things, memory.

Nothing changes by looking.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import msgspec
from msgspec.structs import replace

from rapc import events
from rapc.base.values import Atom, Fact, format_atom, format_list, number
from rapc.debug.acts import live_task
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.errors import ArgumentError
from rapc.events import Cause, Goal, TaskCreated
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.memory.store import NEVER
from rapc.runtime.snapshot import deadlocks_in_words
from rapc.runtime.state.task import Task
from rapc.runtime.state.things import format_thing
from rapc.world import Time


class FamilyMember(msgspec.Struct, frozen=True):
    """A live task in its family."""

    #: How deep it stands below its top-level task.
    depth: int
    task: int
    goal: Goal
    state: str
    #: The method that it is at work on, or tried last; empty before the first.
    method: str
    #: What its last method has come to.
    result: str | None
    waits_for: str
    #: Why its last method ended badly.
    because: Cause | None


def tree(run: Interpreter) -> list[FamilyMember]:
    """Return all live tasks, each behind its parent, by number."""
    entries = {entry.task: entry for entry in run.agenda()}
    tasks = {task.number: task for task in run.machine.state.live_tasks()}
    below: dict[int | None, list[int]] = {}
    for task in tasks.values():
        above = None if task.parent is None else task.parent.number
        below.setdefault(above, []).append(task.number)
    found: list[FamilyMember] = []
    for depth, at in _in_families(below):
        entry, task = entries[at], tasks[at]
        found.append(
            FamilyMember(
                depth=depth,
                task=at,
                goal=entry.goal,
                state=entry.state,
                method="" if task.method is None else task.method.name,
                result=task.last_result,
                waits_for=entry.waits_for,
                because=None if task.history is None else task.history.because,
            )
        )
    return found


def _in_families(
    below: Mapping[int | None, Sequence[int]],
) -> Iterator[tuple[int, int]]:
    """Yield tasks with their depths, each behind its parent; None has those on top."""
    stack = [(0, task) for task in reversed(below.get(None, ()))]
    while stack:
        depth, task = stack.pop()
        yield depth, task
        stack += [(depth + 1, one) for one in reversed(below.get(task, ()))]


_ENDS = (events.TaskSucceeded, events.TaskFailed, events.TaskRemoved)

TOLD_OF_TREES = (
    *(events.TaskCreated, events.TaskSelected, *_ENDS),
    *(events.MethodChosen, events.MethodEnded, events.TaskBlocked, events.TaskWoken),
)
"""The events that `tree_told` needs."""


def tree_told(told: Iterable[ToldEvent]) -> list[FamilyMember]:
    """Return the live tasks that events tell of, each behind its parent, by number.

    What a task waits for is known only where it was told that it is blocked.
    """
    nodes: dict[int, FamilyMember] = {}
    below: dict[int | None, list[int]] = {}
    for one in told:
        number = one.keys.get("task")
        if one.kind is events.TaskCreated:
            nodes[one.keys["task"]] = FamilyMember(
                0, one.keys["task"], one.keys["goal"], "made", "", None, "", None
            )
            below.setdefault(one.keys["parent"], []).append(one.keys["task"])
        elif one.kind in _ENDS:
            nodes.pop(one.keys["task"], None)
        elif number in nodes:
            nodes[number] = replace(nodes[number], **_changed_by(one))
    left = {above: [n for n in under if n in nodes] for above, under in below.items()}
    return [replace(nodes[n], depth=depth) for depth, n in _in_families(left)]


def _changed_by(told: ToldEvent) -> dict[str, Any]:
    """Return what an event makes another of a task in its family."""
    keys = told.keys
    if told.kind is events.TaskSelected:
        return {"goal": keys["goal"], "state": "selected", "waits_for": ""}
    if told.kind is events.MethodChosen:
        return {"method": keys["method"], "state": "running", "because": None}
    if told.kind is events.MethodEnded:
        result, because = keys["result"], keys["because"]
        return {"state": "made", "result": result, "because": because}
    if told.kind in (events.TaskBlocked, events.TaskWoken):
        blocked = told.kind is events.TaskBlocked
        return {
            "state": "blocked" if blocked else "eligible",
            "waits_for": keys["on"] if blocked else "",
        }
    return {}


def chain(run: Interpreter, number: int) -> list[tuple[int, Goal, str]]:
    """Return a live task and all above it: number, goal, and method under way.

    Raises:
        ArgumentError: if there is no such live task.
    """
    found = []
    task: Task | None = live_task(run, number)
    while task is not None:
        method = "" if task.run is None else task.run.plan.name
        found.append((task.number, task.goal(), method))
        task = task.parent
    return found


def task_of(history: History, rap: str) -> int:
    """Return the number of the live task of a RAP.

    Raises:
        ArgumentError: if the RAP has no live task, or several.
    """
    goals = {n: goal for n, goal in history.run.goals().items() if goal.name == rap}
    if len(goals) == 1:
        return next(iter(goals))
    if goals:
        listed = ", ".join(f"[{number}] {goal}" for number, goal in goals.items())
        raise ArgumentError(f"`{rap}` has several live tasks: {listed}; give a number")
    last = history.last(TaskCreated, want=lambda told: told.keys["goal"].name == rap)
    ended = f"; its last task was [{last.keys['task']}]" if last is not None else ""
    raise ArgumentError(f"`{rap}` has no live task{ended}")


class Belief(msgspec.Struct, frozen=True):
    """A fact of memory with its age."""

    fact: Fact
    #: When it was last asserted; None if it never was.
    since: Time | None


def beliefs(run: Interpreter, name: str, *pattern: Atom | None) -> list[Belief]:
    """Return the facts of a name that match a pattern of values and None.

    Raises:
        ArgumentError: if nothing is declared by that name, or a value is not of the
            declared kind.
    """
    machine = run.machine
    signatures = machine.library.signatures
    if name not in signatures.relations:
        raise ArgumentError(str(signatures.unknown("test", name)))
    wrong = signatures.wrong_kind("erased", name, pattern)
    if wrong is not None:
        raise ArgumentError(wrong)
    facts = machine.memory.facts
    size = len(pattern)
    found = []
    for fact in facts.table(name).stamps:
        given = zip(pattern, fact[1 : size + 1], strict=False)
        if all(want is None or want == value for want, value in given):
            stamp = facts.stamp(fact)
            since = None if stamp is None or stamp == NEVER else number(stamp)
            found.append(Belief(fact, since))
    return found


def names_with_facts(run: Interpreter) -> list[tuple[str, int]]:
    """Return each name that facts have, with how many they are."""
    tables = run.machine.memory.facts.tables
    return [
        (str(name), len(t.stamps)) for name, t in sorted(tables.items()) if t.stamps
    ]


class KnownItem(NamedTuple):
    """An item that memory knows."""

    name: str
    kind: str
    place: str
    #: Its sensor name, if it is in reach.
    sensor: str | None


def items(run: Interpreter) -> list[KnownItem]:
    """Return the items that memory knows, in the order of their introduction."""
    memory = run.machine.memory
    found = []
    for item in memory.items.known.values():
        place = memory.facts.asserted(("location", item.name))
        at = "" if place is None else format_atom(place[-1])
        sensor = item.sensor if item.accessible else None
        found.append(KnownItem(item.name, item.kind, at, sensor))
    return found


class Wait(NamedTuple):
    """A task that listens for a change, or waits for a time."""

    task: int
    goal: Goal
    state: str
    #: What its monitor waits for, as it is bound.
    formula: str
    #: The next time at which it is looked at, if there is one.
    at: Time | None
    deadline: Time | None


def monitored_tasks(run: Interpreter) -> list[Wait]:
    """Return the live tasks that have monitors, by number."""
    machine = run.machine
    entries = {entry.task: entry for entry in run.agenda()}
    found = []
    for task in machine.state.live_tasks():
        if task.plan.monitored:
            entry = entries[task.number]
            wait = task.wait
            found.append(
                Wait(
                    task.number,
                    entry.goal,
                    entry.state,
                    machine.monitors.reason(task) if task.bound else "",
                    None if wait is None else wait.timer,
                    entry.deadline,
                )
            )
    return found


class Claim(msgspec.Struct, frozen=True):
    """A thing that a method holds, with those who wait for it."""

    thing: str
    holder: int
    goal: Goal
    #: Whether its request uses the thing; else the method claims it.
    used: bool
    waiters: tuple[int, ...]


def claims(run: Interpreter) -> tuple[list[Claim], tuple[str, ...]]:
    """Return what is held, by holder, and each deadlock in words."""
    things = run.machine.things
    found = []
    for _, holds in sorted(things.held.items()):
        for hold in holds:
            task, thing = hold.run.task, hold.ask.thing
            waiters = tuple(
                sorted(
                    wait.task.number
                    for wait in things.waits.values()
                    if any(
                        ask.thing == thing for way in wait.alternatives for ask in way
                    )
                )
            )
            said = hold.said or format_thing(thing)
            found.append(Claim(said, task.number, task.goal(), hold.ask.used, waiters))
    return found, deadlocks_in_words(run.machine)


class RequestUnderWay(NamedTuple):
    """A request that is under way."""

    ticket: int
    task: int
    request: str


def requests(run: Interpreter) -> list[RequestUnderWay]:
    """Return the requests that have neither ended nor been cancelled.

    A world may answer what was cancelled once more, or never.
    """
    return [
        RequestUnderWay(ticket, task.number, format_list(asked))
        for ticket, (task, asked) in sorted(run.machine.state.pending.items())
        if task is not None
    ]


def stack(run: Interpreter) -> list[tuple[int, int, str]]:
    """Return the families that were chosen, with priority and goal, the top first."""
    goals = run.goals()
    return [
        (priority, family, str(goals.get(family, "has ended")))
        for priority, family in reversed(run.machine.agenda.stack)
    ]


class SkillsOn(msgspec.Struct, frozen=True):
    """Skills that a method has switched on together."""

    ticket: int
    #: Who hears their signals; None if nobody does any more.
    task: int | None
    skills: str
    on: bool


def skills(run: Interpreter) -> list[SkillsOn]:
    """Return the activations of skills that signals may still come from."""
    activations = run.machine.state.activations
    return [
        SkillsOn(
            one.ticket,
            None if one.task is None else one.task.number,
            " ".join(map(format_list, one.skills)),
            one.run is not None,
        )
        for one in (*activations.on.values(), *activations.off.values())
    ]
