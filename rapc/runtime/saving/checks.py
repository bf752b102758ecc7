"""Validate a restored run before the replacement: its parts must agree.

Codecs validate the form and the references of each field. This module compares
fields with each other, with the plans of the library and with its declarations: a
restored run continues like a run that was never saved. Memory is validated in
`rapc.runtime.saving.memory_checks`.
"""

from __future__ import annotations

from collections import Counter as Tally
from itertools import chain

from rapc.base.resources import Counter, SetResource
from rapc.errors import RefusedError
from rapc.library.signatures import Use
from rapc.runtime.saving.codecs import WrongRecordError, need
from rapc.runtime.saving.memory_checks import check_memory, once
from rapc.runtime.saving.runs import RestoredRun
from rapc.runtime.state.states import BLOCKED, ELIGIBLE, ENDED, RUNNING, WAITING
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.runtime.state.things import CONFLICT, Ask, ThingWait
from rapc.runtime.task_request import refuse_tasks


def check(restored: RestoredRun) -> None:
    """Validate a restored run.

    Raises:
        WrongRecordError: for fields that no run can have left.
    """
    try:
        _check_counts(restored)
        for task in restored.tasks:
            if task.within is None or task.live:
                _check_task(task)
                _check_history(task)
        for method_run in restored.runs.values():
            _check_method(restored, method_run)
        _check_requests(restored)
        _check_activations(restored)
        _check_things(restored)
        _check_waiting(restored)
        _check_scheduled(restored)
        check_memory(restored.access)
    except (LookupError, TypeError, ValueError, RefusedError) as error:
        raise WrongRecordError(str(error)) from error


def _check_counts(restored: RestoredRun) -> None:
    state, on = restored.state, restored.state.activations.on
    over = state.reason is not None
    need(not (over and restored.live), "a run that is over has live tasks")
    moved = state.moved_at <= restored.record.cycle
    need(moved, "the clock moved in a cycle that has not come")
    numbers = [task.number for task in restored.tasks]
    need(once(numbers), "two tasks have one number")
    need(all(1 <= n <= state.numbers for n in numbers), "an unknown number of a task")
    tickets = [*state.pending, *on]
    need(once(tickets), "two requests have one ticket")
    need(all(1 <= n <= state.tickets for n in tickets), "an unknown ticket")
    for given in state.live_top.values():
        ended = given.outcome is not None or given.ended is not None
        need(not ended, "an end of a live task")


# --- tasks --------------------------------------------------------------------------


def _check_task(task: Task) -> None:
    number, above, method_run = task.number, task.parent, task.run
    need(
        (task.state is RUNNING) == (method_run is not None),
        f"task {number} is not at work",
    )
    if task.goal_key is not None:
        need(task.goal_key[:1] == task.plan.goal_key, f"task {number} is another")
        need(task.bound, f"task {number} has no inputs")
    need(task.choice is None or _is_choice(task.choice), "a choice without a method")
    _check_variables(task)
    if above is not None and task.step is not None:
        need(number > above.number, f"task {number} is older than its parent")
        need(task.priority == above.priority + task.step.priority, "another priority")
        waits = not task.waiting or task.state is WAITING
        need(waits, f"task {number} waits for other steps")


def _check_variables(task: Task) -> None:
    """Check that exactly the bindable inputs and resources are bound."""
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
    """Return whether variables have their expected values; resources are shared."""
    return all(
        env.get(name) is value
        if isinstance(value, Counter | SetResource)
        else env.get(name) == value
        for name, value in expected.items()
    )


def _is_choice(key: tuple[object, ...]) -> bool:
    return bool(key) and type(key[0]) is int


def _check_history(task: Task) -> None:
    """Check that the counts of choices agree and the last choice can be undone."""
    history = task.history
    if history is None:
        return
    need(all(map(_is_choice, history.choices)), "a choice without a method")
    need(all(count > 0 for count in history.choices.values()), "a choice never made")
    need(bool(history.choices) == bool(history.tries), "choices and tries differ")
    kept: Tally[object] = Tally()
    for key, count in history.choices.items():
        kept[key[0]] += count
    tries: Tally[object] = Tally(history.tries)
    need(all(kept[at] <= tries[at] for at in kept), "choices and tries differ")
    if task.run is not None and history.tries:
        last = history.last_choice
        need(last in history.choices, f"task {task.number} has no last choice")
        need(last[:1] == task.run.plan.key, f"task {task.number} chose another method")


# --- methods and the world ----------------------------------------------------------


def _check_method(restored: RestoredRun, method_run: MethodRun) -> None:
    task, plan, steps = method_run.task, method_run.plan, method_run.steps
    number = task.number
    need(task.method is plan, f"task {number} has tried another method")
    need(
        _holds(method_run.env, task.env),
        f"the method of task {number} has other variables",
    )
    need(method_run.steps_left or not steps, f"the method of task {number} has ended")
    if method_run.ends is not None:
        ended = [step.state is ENDED for step in steps]
        need([t is not None for t in method_run.ends.times] == ended, "times of steps")
        need(
            all(0 <= at < len(steps) for at in method_run.ends.ended_by_until), "a step"
        )
    if plan.request is not None:
        asker = restored.state.pending[method_run.ticket or 0][0]
        need(asker is task, f"task {number} waits for no request")
    activation = plan.activation
    skills = () if activation is None else activation.skills
    need(len(method_run.skills) == len(skills), f"task {number} has other skills")
    for skill, expected in zip(method_run.skills, skills, strict=True):
        need(skill[:1] == (expected.name,), f"task {number} has other skills")
        _check_use(restored, "skill", skill)
    if activation is not None:
        on = restored.state.activations.on.get(method_run.ticket or 0)
        off = restored.things.waits.get(number)
        left = len(skills) - (0 if off is None else len(off.skills))
        there = 0 if on is None else len(on.skills)
        need(there == left, f"task {number} has other skills on")
        need(on or method_run.ticket is None, f"task {number} has no skills on")


def _check_use(restored: RestoredRun, use: Use, content: tuple[object, ...]) -> None:
    """Validate the arguments of a request or skill by its declaration."""
    need(content and isinstance(content[0], str), f"a {use} without a name")
    signatures = restored.run.library.signatures
    fault = signatures.fault(use, str(content[0]), len(content) - 1)
    need(fault is None, str(fault))


def _check_requests(restored: RestoredRun) -> None:
    for ticket, (task, asked) in restored.state.pending.items():
        _check_use(restored, "primitive", asked)
        if task is not None:
            method_run = restored.runs[task.number]
            need(method_run.ticket == ticket, f"request {ticket} is over")
            request = method_run.plan.request
            need(request and request.name == asked[0], f"request {ticket} is another")


def _check_activations(restored: RestoredRun) -> None:
    tables = restored.state.activations
    for ticket, one in chain(tables.on.items(), tables.off.items()):
        need(one.ticket == ticket, f"activation {ticket} is another")
        for skill in one.skills:
            _check_use(restored, "skill", skill)
    for ticket, one in tables.on.items():
        method_run = one.run
        ours = (
            method_run
            and method_run.task.number == one.owner
            and method_run.ticket == ticket
        )
        need(
            ours and method_run and method_run.plan.activation,
            f"activation {ticket} is over",
        )


# --- things -------------------------------------------------------------------------


def _check_things(restored: RestoredRun) -> None:
    things = restored.things
    for number, holds in things.held.items():
        need(number in restored.runs, f"task {number} holds nothing")
        need(once(h.ask.thing for h in holds), f"task {number} has a duplicate thing")
    for number, wait in things.waits.items():
        need(wait.task.number == number, f"task {number} waits for nothing")
        _check_thing_wait(wait)
    for number in things.to_test:
        need(number in things.waits, f"task {number} waits for no thing")
    for number, task in restored.live.items():
        monitored = task.plan.monitored and task.wait is not None
        waits = monitored or number in things.waits
        need(task.state is not BLOCKED or waits, f"task {number} waits for nothing")
    asks = [hold.ask for holds in things.held.values() for hold in holds]
    asks += chain(*(way for wait in things.waits.values() for way in wait.alternatives))
    for ask in asks:
        _check_ask(ask, things.conflicts)


def _check_thing_wait(wait: ThingWait) -> None:
    task, number = wait.task, wait.task.number
    need(wait.alternatives, f"task {number} waits for nothing")
    if not wait.skills:
        state = ELIGIBLE if wait.woken else BLOCKED
        need(task.state is state, f"task {number} is not blocked")
        return
    plan = None if task.run is None else task.run.plan.activation
    most = len(plan.skills) if plan is not None and plan.background else 0
    known = once(wait.skills) and all(0 <= at < most for at in wait.skills)
    need(known, f"task {number} has unknown skills")


def _check_ask(ask: Ask, conflicts: int) -> None:
    need(ask.thing and isinstance(ask.thing[0], str), "a thing without a name")
    if ask.thing[0] == CONFLICT:
        count = ask.thing[1] if len(ask.thing) == 2 else 0
        known = type(count) is int and 1 <= count <= conflicts
        need(known, "an unknown conflict")


# --- waits ----------------------------------------------------------------------------


def _check_waiting(restored: RestoredRun) -> None:
    """Check that all eligible tasks are on the agenda, and monitors agree."""
    live = restored.live
    sole, others = restored.agenda.entries()
    need(sole is None or not others, "a task that is not alone")
    numbers = [*(number for number, _, _ in others), *([] if sole is None else [sole])]
    eligible = [n for n, task in live.items() if task.state is ELIGIBLE]
    need(sorted(numbers) == sorted(eligible), "other tasks are eligible")
    for number in (*restored.to_test, *restored.missed):
        need(live[number].wait is not None, f"task {number} has no monitors")
    for number, task in live.items():
        wait = task.wait
        if wait is not None and wait.keys is not None:
            need(task.plan.monitored, f"task {number} has no monitor")
        if wait is not None and wait.timer is not None:
            may_wait = task.state is WAITING or task.plan.monitored
            need(may_wait, f"task {number} waits for no time")
        if wait is not None and wait.awaits_signal:
            waits = () if task.step is None else task.step.waits
            proceeds = any(wait.mode == "proceed" for wait in waits)
            need(proceeds and not task.waiting, f"task {number} awaits nothing")


def _check_scheduled(restored: RestoredRun) -> None:
    scheduled, requests = restored.state.scheduled, restored.state.requests
    orders = [order for _, order, _ in scheduled]
    need(once(orders), "two tasks for later are one")
    need(all(0 < n <= requests for n in orders), "a task for later")
    need(all(time == request.at for time, _, request in scheduled), "a time")
    goals = [request.goal for _, _, request in scheduled]
    need(all(goals), "a task without a goal")
    refuse_tasks(restored.run.library, goals)
