"""Read-only snapshots of a run's tasks, for hosts and front ends."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from operator import itemgetter
from typing import Any

import msgspec

from rapc.base.values import Fact, format_list, number
from rapc.events import (
    Event,
    FactAsserted,
    Goal,
    MethodChosen,
    PrimitiveRequested,
    RunStarted,
    TaskBlocked,
    TaskCreated,
    TaskResult,
)
from rapc.ir.printer import format_formula
from rapc.runtime.run import Run
from rapc.runtime.state.deadlocks import deadlocks, held, in_words
from rapc.runtime.state.states import BLOCKED, ELIGIBLE, UNTESTED, WAITING
from rapc.runtime.state.task import MethodRun, Task, TopLevelTask, as_told
from rapc.runtime.state.things import Hold, ThingWait, words
from rapc.world import OKAY, Time


class AgendaEntry(msgspec.Struct, frozen=True):
    """A snapshot of a live task.

    `state` is `waiting` (for order, time or a signal), `eligible`, `blocked` (by its
    monitors or a thing) or `running` (its method is under way). `deadline` is the
    nearest deadline of the task and its ancestors, or None; `slack` the time units left
    until the latest start that could meet the deadline, negative afterwards.
    `waits_for` is the wait of the task as text; empty if the task can go on.
    """

    task: int
    goal: Goal
    state: str
    priority: int
    family: int
    parent: int | None
    deadline: Time | None
    duration: Time
    slack: Time | None
    waits_for: str


class Claim(msgspec.Struct, frozen=True):
    """A thing that a method under way holds."""

    #: The thing; `said` is its text, or that of the request that holds it.
    thing: Fact
    said: str
    #: The task whose method holds the thing.
    task: Task
    #: Whether the request of the method uses the thing; otherwise the method claims it.
    used: bool
    #: The tasks that wait for the thing, by number.
    waiting: tuple[int, ...]


class Candidate(msgspec.Struct, frozen=True):
    """An eligible task as the rules of choice see it [T 3.2.4; L 4]."""

    priority: int
    #: The latest start that could meet the deadline; 0 for a sole candidate.
    latest: float
    #: Whether a method of the task has failed.
    failed: bool
    #: Whether the family of the task is the preferred one among the candidates.
    preferred: bool


def agenda(run: Run) -> tuple[AgendaEntry, ...]:
    """Return all live tasks by number, as values independent of the run."""
    return tuple(_entry(run, task) for task in run.state.live_tasks())


def past(run: Run, start: RunStarted) -> tuple[Event, ...]:
    """Return events that stand for the past of a restored run; see `Interpreter.past`.

    Args:
        run: the run.
        start: the first event.
    """
    now, memory = run.recorder.time, run.context.view
    known = [(memory.since(fact), fact) for fact in memory]
    begun = min((since for since, _ in known if since is not None), default=now)
    found: list[tuple[Time, type[Event], dict[str, Any]]] = [
        (since or begun, FactAsserted, {"fact": fact, "by": "state"})
        for since, fact in known
    ]
    for task in run.state.live_tasks():
        within, method = task.within, task.run
        since = now if method is None else method.started
        since = since if within is None else within.started
        given = {
            "task": task.number,
            "goal": task.goal(),
            "parent": None if task.parent is None else task.parent.number,
            "family": task.family,
            "priority": task.priority,
            "step": None if task.step is None else task.step.node.tag,
        }
        found.append((since, TaskCreated, given))
        if method is not None:
            keys = {"rap": task.plan.name, "method": method.plan.name}
            bound = as_told(method.env)
            given = {"task": task.number, **keys, "bindings": bound}
            found.append((method.started, MethodChosen, given))
        elif task.state is BLOCKED:
            given = {"task": task.number, "on": _obstacle(run, task)}
            found.append((now, TaskBlocked, given))
    for asking, request in run.state.pending.values():
        if asking is not None and asking.run is not None:
            given = {"task": asking.number, "request": request, "sent": request}
            found.append((asking.run.started, PrimitiveRequested, given))
    found.sort(key=itemgetter(0))
    first = run.recorder.serial - len(found)
    replaced = msgspec.structs.replace(start, n=first - 1, time=begun)
    events = [
        k(n=first + at, cycle=0, time=t, **o) for at, (t, k, o) in enumerate(found)
    ]
    return replaced, *events


def _entry(run: Run, task: Task) -> AgendaEntry:
    deadline = None if task.limit == math.inf else number(task.limit)
    duration = 0 if task.wait is None else task.wait.duration
    slack = None
    if deadline is not None:
        slack = number(deadline - duration - run.recorder.time)
    state = WAITING if task.state is UNTESTED else task.state
    return AgendaEntry(
        task=task.number,
        goal=task.goal(),
        state=state,
        priority=task.priority,
        family=task.family,
        parent=task.parent.number if task.parent is not None else None,
        deadline=deadline,
        duration=duration,
        slack=slack,
        waits_for=_obstacle(run, task),
    )


def _obstacle(run: Run, task: Task) -> str:
    if task.run is not None:
        awaited = _under_way(run, task.run)
        return "its method" if awaited is None else awaited
    if task.wait is not None and task.wait.awaits_signal:
        return task.wait.blocked_on
    if task.waiting:
        return "steps before it"
    if task.number in run.things.waits:
        return _things_in_the_way(run, run.things.waits[task.number])
    if task.state in (BLOCKED, UNTESTED):
        return run.monitors.reason(task)
    return "" if task.state is ELIGIBLE else "its time"


def results(given: Iterable[TopLevelTask]) -> tuple[TaskResult, ...]:
    """Return the result of each top-level task, in order of arrival."""
    return tuple([_result(one) for one in given])


def _result(given: TopLevelTask) -> TaskResult:
    outcome = "unfinished" if given.ended is None else "cancelled"
    if given.outcome is not None:
        outcome = "succeeded" if given.outcome == OKAY else "failed"
    return TaskResult(
        task=given.task.number,
        goal=given.task.goal(given.outputs),
        outcome=outcome,
        result=given.outcome,
        background=given.background,
        came=given.came,
        ended=given.ended,
        because=given.because,
    )


def goals(run: Run) -> dict[int, Goal]:
    """Return the goals of all live tasks by number, with the known inputs."""
    return {task.number: task.goal() for task in run.state.live_tasks()}


def waiting(run: Run) -> tuple[str, ...]:
    """Return a line for people on each task under way and its wait.

    The lines leave out tasks that wait for their own steps, or for steps before them.
    """
    return tuple(
        f"{task.goal()} [{task.number}] {_awaited(run, task)}"
        for task in run.state.live_tasks()
        if _is_told(run, task)
    )


def _is_told(run: Run, task: Task) -> bool:
    if task.run is not None:
        return _under_way(run, task.run) is not None
    return not task.waiting or (task.wait is not None and task.wait.awaits_signal)


def _under_way(run: Run, method_run: MethodRun) -> str | None:
    """Return the request, or the signals, that will end a method, if any."""
    ticket = method_run.ticket
    if ticket is None:
        return None
    if ticket in run.state.pending:
        return format_list(run.state.pending[ticket][1])
    plan = method_run.plan.activation
    if plan is None or plan.background:
        return None
    return " or ".join(
        format_formula(wait.pattern, method_run.env) for wait in plan.waits
    )


def _awaited(run: Run, task: Task) -> str:
    obstacle = _obstacle(run, task)
    return f"waits for {obstacle}" if obstacle else "could go on"


def _things_in_the_way(run: Run, wait: ThingWait) -> str:
    hold = run.things.obstacle_of(wait)
    return "" if hold is None else held(hold)


def claims(run: Run) -> tuple[Claim, ...]:
    """Return the held things in their order, each holder apart."""
    held_things = sorted(run.things.held.items())
    return tuple([claim(run, hold) for _, holds in held_things for hold in holds])


def claim(run: Run, hold: Hold) -> Claim:
    """Return a hold as a value, with the waiting tasks."""
    thing = hold.ask.thing
    waiting = [
        wait.task.number
        for wait in run.things.waits.values()
        if any(ask.thing == thing for way in wait.alternatives for ask in way)
    ]
    task, waiters = hold.run.task, tuple(sorted(waiting))
    return Claim(thing, words(hold), task, hold.ask.used, waiters)


def candidates(run: Run) -> dict[int, Candidate]:
    """Return the eligible tasks by number, as the rules of choice see them."""
    sole, others = run.eligible.entries()
    late = {number: (start, failed) for number, start, failed in others}
    if sole is not None:
        late[sole] = 0, False
    tasks = [task for task in run.state.live_tasks() if task.number in late]
    highest = max((task.priority for task in tasks), default=0)
    open_to = [family for level, family in run.eligible.stack if level <= highest]
    return {
        task.number: Candidate(
            task.priority, *late[task.number], task.family in open_to[-1:]
        )
        for task in tasks
    }


def deadlocks_in_words(run: Run) -> tuple[str, ...]:
    """Return a line for each deadlock: a circle of tasks that wait for each other."""
    found = deadlocks(run.things)
    return tuple(f"deadlock: {'; '.join(in_words(one))}" for one in found)


_FEW = 10
"""The lowest count that explains an endless run."""


def looping(run: Run) -> str:
    """Return the reason why a run goes on without the clock moving, if known.

    The reason is a task that chooses again and again, nested tasks of one RAP without
    end, or else the family whose tasks try and fail.
    """
    tasks = run.state.live_tasks()
    chosen = [(task.choices, -task.number, task) for task in tasks]
    most, _, chooser = max(chosen, default=(0, 0, None))
    below = Counter(task.plan.name for task in tasks if task.run is not None)
    name, deep = max(below.items(), key=lambda pair: pair[1], default=("", 0))
    if chooser is not None and most >= max(deep, _FEW):
        return f"{chooser.goal()} [{chooser.number}] has chosen a method {most} times"
    if deep >= _FEW:
        return f"{deep} tasks of `{name}` are under way at once"
    family = run.eligible.last_family
    top = next((task for task in tasks if task.number == family), None)
    return "" if top is None else f"all for {top.goal()} [{top.number}]"
