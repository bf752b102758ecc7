"""Validate a rebuilt run before it replaces another: what can be derived must agree.

`Rebuilt` checks the shape of each record. This module compares the records with each
other, with the plans of the library and with its declarations: a restored run continues
like a run that was never saved. Memory is validated in
`rapc.runtime.memory.validation`.
"""

from __future__ import annotations

from collections import Counter as Tally
from collections.abc import Container, Mapping, Sequence
from typing import NamedTuple

from rapc.base.resources import Counter, SetResource
from rapc.errors import RefusedError
from rapc.library.signatures import Use
from rapc.runtime.admission import refuse_tasks
from rapc.runtime.machine import Machine
from rapc.runtime.memory.validation import (
    WrongRecordError,
    need,
    once,
    validate_memory,
)
from rapc.runtime.saving.records import AskRecord, MethodRecord, RunRecord, TaskRecord
from rapc.runtime.state.states import BLOCKED, ELIGIBLE, ENDED, RUNNING, WAITING
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.runtime.state.things import CONFLICT


class Remade(NamedTuple):
    """A run made of records, with these."""

    machine: Machine
    record: RunRecord
    #: All tasks in the order of their records.
    tasks: Sequence[Task]
    #: The methods under way, each with its record.
    runs: Sequence[tuple[MethodRun, MethodRecord]]
    #: The live tasks by number.
    live: Mapping[int, Task]
    #: The records of all tasks by number.
    records: Mapping[int, TaskRecord]
    #: The tickets of requests under way, each with the number of its task.
    asked: Container[tuple[int | None, int | None]]


def check(made: Remade) -> None:
    """Validate a rebuilt run.

    Raises:
        WrongRecordError: for records that no run has left.
    """
    _check_counts(made)
    _check_top_level(made)
    for task, record in zip(made.tasks, made.record.tasks, strict=True):
        if task.within is None or task.live:
            _check_task(task)
            _check_history(task)
            _check_things(made, task, record)
    for run, saved in made.runs:
        _check_method(made, run, saved)
    _check_pending(made)
    _check_activations(made)
    _check_listening(made)
    _check_agenda(made)
    _check_monitors(made)
    _check_scheduled(made)
    _check_memory(made)


# --- counts -------------------------------------------------------------------------


_COUNTS = (
    *("cycle", "serial", "numbers", "tickets"),
    *("requests", "succeeded", "idle", "waits"),
)


def _check_counts(made: Remade) -> None:
    counts, live = made.record.counts, made.live
    for name in _COUNTS:
        need(getattr(counts, name) >= 0, f"`{name}` is negative")
    need(counts.over == (counts.reason is not None), "an end without a reason")
    need(not (counts.over and live), "a run that is over has live tasks")
    numbers = [task.number for task in made.tasks]
    need(once(numbers), "two tasks have one number")
    need(all(1 <= n <= counts.numbers for n in numbers), "an unknown number of a task")
    tickets = [entry[0] for entry in made.record.pending]
    tickets += [one.ticket for one in made.record.activations if one.on]
    need(once(tickets), "two requests have one ticket")
    need(all(1 <= n <= counts.tickets for n in tickets), "an unknown ticket")


def _check_top_level(made: Remade) -> None:
    """Tasks of the host come first, each once; all others are steps."""
    given = made.record.top_level
    need([top.task for top in given] == list(range(len(given))), "a task is missing")
    for at, task in enumerate(made.tasks):
        need((task.within is None) == (at < len(given)), f"task {at} is no step")
    for top in given:
        if made.tasks[top.task].live:
            need(top.outcome is None and top.ended is None, "an end of a live task")


# --- tasks --------------------------------------------------------------------------


def _check_task(task: Task) -> None:
    number, above, run = task.number, task.parent, task.run
    need((task.state is RUNNING) == (run is not None), f"task {number} is not at work")
    if task.identity is not None:
        need(task.identity[:1] == task.plan.identity, f"task {number} is another")
        need(task.bound, f"task {number} has no inputs")
    need(task.choice is None or _is_choice(task.choice), "a choice without a method")
    _check_variables(task)
    if above is None or task.step is None or task.within is None:
        need(task.family == number and task.waiting == 0, f"task {number} is a step")
        return
    need(number > above.number, f"task {number} is older than its parent")
    need(task.family == above.family, f"task {number} is of another family")
    need(task.priority == above.priority + task.step.priority, "another priority")
    need(not task.waiting or task.state is WAITING, f"task {number} does not wait")


def _check_variables(task: Task) -> None:
    """Of inputs and resources, each is bound if it can be, and nothing else is."""
    plan, wait = task.plan, task.wait
    given = zip(plan.inputs, task.goal_args, strict=True)
    expected = {name: value for name, value in given if value is not None}
    prepared = wait is not None and wait.prepared and not wait.setup_failed
    for resource, _ in plan.resources:
        name = resource.variable.name
        kind = Counter if resource.kind == "counter" else SetResource
        if name in task.env:
            need(isinstance(task.env[name], kind), f"`{name}` is no {resource.kind}")
            expected[name] = task.env[name]
        need(name in task.env or not prepared, f"`{name}` is missing")
    same = task.env.keys() == expected.keys() and _holds(task.env, expected)
    need(same, f"task {task.number} has other variables")


def _holds(env: Env, expected: Env) -> bool:
    """Whether variables have values that are expected of them; resources are shared."""
    return all(
        env.get(name) is value
        if isinstance(value, Counter | SetResource)
        else env.get(name) == value
        for name, value in expected.items()
    )


def _is_choice(key: tuple[object, ...]) -> bool:
    return bool(key) and type(key[0]) is int


def _check_history(task: Task) -> None:
    """The counts of choices agree, and the last choice can be put back."""
    history = task.history
    if history is None:
        return
    need(all(map(_is_choice, history.choices)), "a choice without a method")
    need(all(count > 0 for count in history.choices.values()), "a choice never made")
    need(bool(history.choices) == bool(history.tries), "choices and tries differ")
    kept: Tally[object] = Tally()
    for key, count in history.choices.items():
        kept[key[0]] += count
    fewer = all(kept[at] <= history.tries.get(at, 0) for at in kept)
    need(fewer, "choices and tries differ")
    if task.run is not None and history.tries:
        last = history.last_choice
        need(last in history.choices, f"task {task.number} has no last choice")
        need(last[:1] == task.run.plan.key, f"task {task.number} chose another method")


# --- methods ------------------------------------------------------------------------


def _check_method(made: Remade, run: MethodRun, saved: MethodRecord) -> None:
    task, plan, steps = run.task, run.plan, run.steps
    number = task.number
    need(task.method is plan, f"task {number} has tried another method")
    need(_holds(run.env, task.env), f"the method of task {number} has other variables")
    ended = [step.state is ENDED for step in steps]
    left = len(steps) - sum(ended)
    need(run.steps_left == left, f"task {number} has {left} steps left")
    need(left or not steps, f"the method of task {number} has ended")
    before: Tally[int] = Tally()
    for step in plan.steps:
        before.update(step.after if steps[step.position].live else ())
    for at, behind in enumerate(steps):
        waits = not behind.live or behind.waiting == before[at]
        need(waits, f"task {behind.number} waits for other steps")
    need((saved.ends is None) == (run.ends is None), "times of steps")
    if run.ends is not None:
        need([t is not None for t in run.ends.times] == ended, "times of steps")
        need(all(0 <= at < len(steps) for at in run.ends.ended_by_until), "a step")
    if plan.request is not None:
        asked = (run.ticket, number) in made.asked
        need(asked, f"task {number} waits for no request")
    skills = () if plan.activation is None else plan.activation.skills
    need(len(run.skills) == len(skills), f"task {number} has other skills")
    for skill, expected in zip(run.skills, skills, strict=True):
        need(skill[:1] == (expected.name,), f"task {number} has other skills")
        _check_use(made, "skill", skill)
    held = [one.thing for one in saved.held]
    need(once(held), f"task {number} holds a thing twice")


def _check_use(made: Remade, use: Use, content: tuple[object, ...]) -> None:
    """The declaration of what a request or skill is allows the arguments."""
    need(content and isinstance(content[0], str), f"a {use} without a name")
    signatures = made.machine.library.signatures
    fault = signatures.fault(use, str(content[0]), len(content) - 1)
    need(fault is None, str(fault))


# --- the world ----------------------------------------------------------------------


def _check_pending(made: Remade) -> None:
    for ticket, number, asked in made.record.pending:
        _check_use(made, "primitive", asked)
        if number is not None:
            run = made.live[number].run
            need(run is not None and run.ticket == ticket, f"request {ticket} is over")
            assert run is not None
            request = run.plan.request
            need(request and request.name == asked[0], f"request {ticket} is another")


def _check_activations(made: Remade) -> None:
    on = {}
    for record in made.record.activations:
        for skill in record.skills:
            _check_use(made, "skill", skill)
        if record.on and record.task is not None:
            run = made.live[record.task].run
            assert run is not None  # `Rebuilt` has looked
            ours = record.task == record.owner and run.ticket == record.ticket
            need(ours, f"activation {record.ticket} is over")
            on[record.task] = len(record.skills)
    for run, _ in made.runs:
        plan, number = run.plan.activation, run.task.number
        if plan is None:
            continue
        off = made.records[number].things
        skills = len(plan.skills) - (0 if off is None else len(off.skills))
        need(on.get(number, 0) == skills, f"task {number} has other skills on")
        need(number in on or run.ticket is None, f"task {number} has no skills on")


def _check_listening(made: Remade) -> None:
    """A step listens to its signals once all that it follows has ended."""
    expected: dict[str, set[int]] = {}
    for task in made.live.values():
        if task.step is not None and task.wait is not None and not task.waiting:
            for wait in task.step.waits:
                expected.setdefault(wait.signal, set()).add(task.number)
    found = {signal: set(numbers) for signal, numbers in made.record.listening}
    need(found == expected, "other steps wait for signals")
    for task in made.live.values():
        if task.wait is not None and task.wait.awaits_signal:
            waits = () if task.step is None else task.step.waits
            proceeds = any(wait.mode == "proceed" for wait in waits)
            need(proceeds and not task.waiting, f"task {task.number} awaits nothing")


# --- things -------------------------------------------------------------------------


def _check_things(made: Remade, task: Task, record: TaskRecord) -> None:
    wait, number = record.things, task.number
    if wait is None:
        monitored = task.plan.monitored and task.wait is not None
        need(task.state is not BLOCKED or monitored, f"task {number} waits for nothing")
    else:
        need(wait.alternatives, f"task {number} waits for nothing")
        if wait.skills:
            _check_skills_off(task, wait.skills)
        else:
            state = ELIGIBLE if wait.woken else BLOCKED
            need(task.state is state, f"task {number} is not blocked")
    asks = [] if wait is None else [ask for asks in wait.alternatives for ask in asks]
    asks += () if record.run is None else record.run.held
    for ask in asks:
        _check_ask(made, ask)


def _check_skills_off(task: Task, skills: tuple[int, ...]) -> None:
    plan = None if task.run is None else task.run.plan.activation
    most = len(plan.skills) if plan is not None and plan.background else 0
    known = once(skills) and all(0 <= at < most for at in skills)
    need(known, f"task {task.number} has no such skills")


def _check_ask(made: Remade, ask: AskRecord) -> None:
    need(ask.thing and isinstance(ask.thing[0], str), "a thing without a name")
    if ask.thing[0] == CONFLICT:
        count = ask.thing[1] if len(ask.thing) == 2 else 0
        known = type(count) is int and 1 <= count <= made.record.monitors.conflicts
        need(known, "an unknown conflict")


# --- agenda and monitors ------------------------------------------------------------


def _check_agenda(made: Remade) -> None:
    """All eligible tasks are on the agenda, and no others."""
    agenda = made.record.agenda
    numbers = [number for number, _, _ in agenda.sorted]
    need(agenda.sole is None or not numbers, "a task that is not alone")
    numbers += [] if agenda.sole is None else [agenda.sole]
    eligible = [n for n, task in made.live.items() if task.state is ELIGIBLE]
    need(sorted(numbers) == sorted(eligible), "other tasks are eligible")


def _check_monitors(made: Remade) -> None:
    monitors, live = made.record.monitors, made.live
    numbers = [*monitors.to_test, *monitors.aging]
    numbers += [number for _, number in monitors.deadlines]
    numbers += [number for number, _ in monitors.missed]
    need(all(live[n].wait is not None for n in numbers), "a task without monitors")
    for n in monitors.ways:
        need(made.records[n].things, f"task {n} waits for no thing")
    for number, task in live.items():
        wait = task.wait
        if wait is None or wait.keys is None:
            continue
        need(task.plan.monitored, f"task {number} has no monitor")
        watches = task.plan.watches
        keys = [watch.resolve(task.env) for watch in watches]
        expected = dict.fromkeys(key for key in keys if key is not None)
        need(wait.keys == tuple(expected), f"task {number} listens to something else")
        ages = any(w.age is not None and w.age not in task.env for w in watches)
        need(ages == (number in monitors.aging), f"the beliefs of task {number}")


def _check_scheduled(made: Remade) -> None:
    scheduled, counts = made.record.scheduled, made.record.counts
    orders = [order for _, order, _ in scheduled]
    need(once(orders), "two tasks for later are one")
    need(all(0 < n <= counts.requests for n in orders), "a task for later")
    need(all(time == request.at for time, _, request in scheduled), "a time")
    goals = [request.goal for _, _, request in scheduled]
    need(all(goals), "a task without a goal")
    try:
        refuse_tasks(made.machine.library, goals)
    except RefusedError as error:
        raise WrongRecordError(str(error)) from error


# --- memory -------------------------------------------------------------------------


def _check_memory(made: Remade) -> None:
    noted = Tally(fact for _, saved in made.runs for fact in saved.notations)
    try:
        validate_memory(made.machine.parts, made.record.memory, noted)
    except ValueError as error:
        raise WrongRecordError(str(error)) from error
