"""How tasks begin: inputs, resources, times, and when they may be considered.

What a task's end sets off is in `rapc.runtime.endings`; what it does when it is
selected in `rapc.runtime.cycle` (semantics 3 and 4).
"""

from __future__ import annotations

from rapc.compiler.plans import WindowPlan
from rapc.compiler.query import TermValue
from rapc.parser.printer import format_formula
from rapc.resources import Counter, SetResource, frozen
from rapc.runtime.context import QueryContext
from rapc.runtime.events import TaskBlocked, TaskCreated
from rapc.runtime.machine import Machine
from rapc.runtime.monitors import time_of
from rapc.runtime.task import Env, MethodRun, State, Task


def create(machine: Machine, task: Task) -> None:
    """A task joins the run."""
    task.number = machine.next_number()
    task.made = machine.recorder.time
    task.family = task.family or task.number
    machine.tasks[task.number] = task
    if machine.recorder.on:
        machine.recorder.emit(
            TaskCreated,
            task=task.number,
            goal=task.goal(),
            parent=task.parent.number if task.parent is not None else None,
            family=task.family,
            priority=task.priority,
            step=task.step.node.tag if task.step is not None else None,
        )
    _prepare(machine, task)


def _prepare(machine: Machine, task: Task) -> None:
    """Make resources, duration and delay as soon as the inputs they use are bound."""
    plan = task.plan
    if task.prepared or any(
        value is None and name in plan.prepared_from
        for name, value in zip(plan.inputs, task.goal_args, strict=True)
    ):
        return
    task.prepared = True
    machine.context.task = task
    for resource, initial in plan.resources:
        made = _make(machine.context, resource.kind, initial, task.env)
        if made is None:
            task.spoilt = True
        else:
            task.env[resource.variable.name] = made
    if plan.duration is not None:
        task.duration = time_of(machine.context, plan.duration, task.env) or 0
    machine.monitors.arm(task, task.made)


def _make(
    context: QueryContext, kind: str, initial: TermValue | None, env: Env
) -> Counter | SetResource | None:
    """A new resource; None, with a fault traced, if its first value is unfit."""
    if initial is None:
        return Counter() if kind == "counter" else SetResource()
    value = initial.needed(context, env)
    if kind == "counter" and isinstance(value, Counter):
        return Counter(value.value)
    if kind == "counter" and isinstance(value, int | float):
        return Counter(value)
    if kind == "set" and isinstance(value, SetResource):
        return SetResource(value.members)
    if value is not None:
        context.unfit(initial.where, value, f"a {kind}")
    return None


def fix_inputs(task: Task) -> None:
    """Keep the inputs of a task that are bound."""
    given = zip(task.plan.inputs, task.goal_args, strict=True)
    inputs = {name: value for name, value in given if value is not None}
    names = [resource.variable.name for resource, _ in task.plan.resources]
    task.env = {**inputs, **{n: task.env[n] for n in names if n in task.env}}
    task.bound = None not in task.goal_args


def repeats_ancestor(task: Task) -> bool:
    """Whether a task asks for what an ancestor of it asks for (T 3.2.5).

    Asked once, when its inputs are first all bound: this is who it is from now.
    """
    values = [frozen(value) for value in task.goal_args if value is not None]
    task.identity = (task.plan.name, *values)
    above = task.parent
    while above is not None:
        if above.identity == task.identity:
            return True
        above = above.parent
    return False


def let_go(machine: Machine, task: Task) -> None:
    """All that a task was ordered after has ended: it runs when its time comes.

    A step with `wait-for` listens from now; one that is to wait for its signal
    before it goes on is held until then.
    """
    if task.step is not None and task.step.waits:
        _listen(machine, task)
    if not task.held:
        when_time_comes(machine, task)


def _listen(machine: Machine, task: Task) -> None:
    assert task.step is not None
    assert task.within is not None
    for wait in task.step.waits:
        machine.listening.setdefault(wait.signal, {})[task.number] = task
        if wait.mode == "proceed" and not task.held:
            task.held = True
            task.blocked_on = format_formula(wait.pattern, task.within.env)
            if machine.recorder.on:
                machine.recorder.emit(TaskBlocked, task=task.number, on=task.blocked_on)


def when_time_comes(machine: Machine, task: Task) -> None:
    """A task may run as soon as its start times have come."""
    start = _start_time(machine, task)
    if start > machine.recorder.time:
        machine.monitors.at(start, task)
    else:
        make_ready(machine, task)


def make_ready(machine: Machine, task: Task) -> None:
    """Order and start times let a task run: test its monitors or make it eligible.

    What its step computes for it is what it comes to now.
    """
    if task.step is not None and task.step.computes:
        fill_inputs(machine, task)
    if task.plan.monitored and task.bound and not task.spoilt:
        machine.monitors.first_test(task)
    else:
        task.state = State.ELIGIBLE
        machine.agenda.add(task)


def _start_time(machine: Machine, task: Task) -> float:
    if task.step is None or task.within is None:
        return 0
    start: float = 0
    for window in task.step.windows:
        times = window_times(machine, task, task.within, window)
        if times is not None:
            start = max(start, times[0])
    return start


def window_times(
    machine: Machine, task: Task, run: MethodRun, window: WindowPlan
) -> tuple[float, float] | None:
    """When a window opens and closes, or None while its step has not ended.

    A time that is no number is traced as a fault and spoils the task.
    """
    base = _base(run, window)
    if base is None:
        return None
    machine.context.task = run.task
    start = time_of(machine.context, window.start, run.env)
    stop = None if start is None else time_of(machine.context, window.stop, run.env)
    if start is None or stop is None:
        task.spoilt = True
        return None
    return base + start, base + stop


def _base(run: MethodRun, window: WindowPlan) -> float | None:
    if window.reference == "now":
        return run.started
    if window.reference == "absolute":
        return 0
    return run.ends[int(window.reference)]


def state_windows(machine: Machine, task: Task, reference: int | None) -> None:
    """State the deadlines of the windows that can be known.

    `reference` is the step that has just ended; None when the method starts.
    """
    if task.step is None or task.within is None:
        return
    for window in task.step.windows:
        named = isinstance(window.reference, int)
        if named != (reference is not None) or (
            named and window.reference != reference
        ):
            continue
        times = window_times(machine, task, task.within, window)
        if times is not None and times[1] < task.given_deadline:
            task.given_deadline = times[1]
            machine.monitors.state_deadline(task)


def fill_inputs(machine: Machine, task: Task) -> None:
    """Read a step's inputs from its method's environment, as far as they are there."""
    if task.step is None or task.within is None:
        return
    machine.context.task = task.within.task
    env = task.within.env
    task.goal_args = tuple([arg.value(machine.context, env) for arg in task.step.args])
    fix_inputs(task)
    if task.number:
        _prepare(machine, task)
