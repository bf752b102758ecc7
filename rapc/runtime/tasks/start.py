"""The beginning of tasks: inputs, resources, times and release.

Not here: the consequences of a task's end (`rapc.runtime.tasks.finish`) and its cycle
(`rapc.runtime.tasks.cycle`) [L 3, 4].
"""

from __future__ import annotations

from rapc.base.resources import Counter, SetResource, frozen
from rapc.base.values import number
from rapc.compiler.net_plan import StepPlan, WindowPlan
from rapc.compiler.query.term_value import TermValue
from rapc.events import TaskBlocked, TaskCreated
from rapc.ir.printer import format_formula
from rapc.runtime.query_context import QueryContext, time_of
from rapc.runtime.run import Run
from rapc.runtime.state.states import ELIGIBLE
from rapc.runtime.state.task import Env, MethodRun, Task, TopLevelTask
from rapc.runtime.state.wait_state import WaitState
from rapc.runtime.task_request import TaskRequest
from rapc.world import Time


def create_top(run: Run, submission: TaskRequest) -> None:
    """Add a top-level task to the run; its goal was validated on arrival."""
    name, *args = submission.goal
    if run.beliefs.items.aliases:
        args = [run.beliefs.items.canonical(arg) for arg in args]
    plan = run.library.rap(str(name))
    assert plan is not None
    task = Task(plan, None, None)
    task.goal_args = tuple(args)
    bind_inputs(task)
    repeats_ancestor(run, task)
    task.priority = submission.priority
    run.state.foreground += not submission.background
    given = TopLevelTask(task, submission.background, run.recorder.time)
    run.state.top_level.append(given)
    create(run, task)
    run.state.live_top[task.number] = given
    if submission.deadline is not None:
        task.wait = task.wait or WaitState()
        task.wait.given_deadline = submission.deadline
        run.monitors.state_deadline(task)
    release(run, task)


def create(run: Run, task: Task) -> None:
    """Add a task to the run, and report it with its current inputs."""
    if task.step is not None and task.step.computes:
        read_inputs(run, task)
    run.state.numbers += 1
    task.number = run.state.numbers
    task.family = task.family or task.number
    tell_created(run, task)
    if task.plan.needs_setup and task.wait is not None:
        task.wait.made = run.recorder.time
        _prepare(run, task, task.wait)


def _prepare(run: Run, task: Task, wait: WaitState) -> None:
    """Make resources, duration and delay as soon as their inputs are bound."""
    plan = task.plan
    if wait.prepared or any(
        value is None and name in plan.prepared_from
        for name, value in zip(plan.inputs, task.goal_args, strict=True)
    ):
        return
    wait.prepared = True
    run.context.task = task
    held = run.state.resources + len(plan.resources)
    wait.over_limit = bool(plan.resources) and held > run.settings.max_resources
    wait.setup_failed |= wait.over_limit
    for resource, initial in () if wait.over_limit else plan.resources:
        made = _make(run.context, resource.kind, initial, task.env)
        if made is None:
            wait.setup_failed = True
        else:
            task.env[resource.variable.name] = made
            run.state.resources += 1
    if plan.duration is not None:
        wait.duration = _duration(run, task, plan.duration)
    run.monitors.arm(task, wait.made)


def _duration(run: Run, task: Task, term: TermValue) -> Time:
    """Return the duration of a task; 0 if the preconditions that it needs do not hold.

    The first solution of the preconditions gives its variables a value [L 4.49].
    """
    env = task.env
    if task.plan.duration_asks:
        found = run.context.bound[task.plan.preconditions].first(env)
        if found is None:
            return 0
        env = {**env, **found}
    return time_of(run.context, term, env) or 0


def _make(
    context: QueryContext, kind: str, initial: TermValue | None, env: Env
) -> Counter | SetResource | None:
    """Return a new resource; None, with a fault traced, if its first value is unfit."""
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


def bind_inputs(task: Task) -> None:
    """Store the bound inputs of a task and its resources."""
    plan, args = task.plan, task.goal_args
    if None not in args:
        env = dict(zip(plan.inputs, args, strict=True))
    else:
        given = zip(plan.inputs, args, strict=True)
        env = {name: value for name, value in given if value is not None}
    for resource, _ in plan.resources:
        name = resource.variable.name
        if name in task.env:
            env[name] = task.env[name]
    task.told = None
    task.env = env  # type: ignore[assignment]  # None is not in it


def repeats_ancestor(run: Run, task: Task) -> bool:
    """Return whether a task has the goal of an ancestor (T 3.2.5).

    Called once, when the inputs are first all bound: they fix the goal key of the task.
    """
    goal_key: tuple[object, ...] = task.plan.goal_key
    if not (task.plan.recursive or run.all_may_recur):
        task.goal_key = goal_key
        return False
    if task.goal_args:
        goal_key = (*goal_key, *frozen(task.goal_args))  # type: ignore[arg-type]  # bound
    task.goal_key = goal_key
    above = task.parent
    if above is not None and above.goal_key == goal_key:
        return True
    if goal_key not in run.state.running_goals:
        return False
    while above is not None and above.goal_key != goal_key:
        above = above.parent
    return above is not None


def release(run: Run, task: Task, again: bool = False) -> None:
    """Release a task for selection, after the end of its predecessors.

    The release fixes the task's windows, and its `wait-for` starts to listen. A step
    that waits for a signal is held until the signal, and a step with a start time until
    that time. Monitors are tested first. Computed arguments of the step get their
    current value.

    Args:
        run: the run.
        task: the task.
        again: whether the task was released before, and only its signal, its time
            or its monitors have blocked the task since.
    """
    wait, step = task.wait, task.step
    if wait is not None:
        if step is not None and not again:
            read_windows(run, task, last=True)
            _listen(run, task, wait, step)
        if wait.awaits_signal:
            return
        if wait.earliest_start > run.recorder.time:
            run.monitors.at(wait.earliest_start, task)
            return
    if step is not None and step.computes:
        read_inputs(run, task)
    if wait is not None and (
        task.plan.monitored and task.bound and not wait.setup_failed
    ):
        run.monitors.first_test(task)
    else:
        task.state = ELIGIBLE
        run.eligible.add(task)


def _listen(run: Run, task: Task, wait: WaitState, step: StepPlan) -> None:
    env = task.within.env if task.within is not None else {}
    for signal in step.waits:
        run.state.listening.setdefault(signal.signal, {})[task.number] = task
        if signal.mode == "proceed" and not wait.awaits_signal:
            wait.awaits_signal = True
            wait.blocked_on = on = format_formula(signal.pattern, env)
            if run.recorder.on:
                run.recorder.emit(TaskBlocked, task=task.number, on=on)


def tell_created(run: Run, task: Task) -> None:
    """Emit the event of a new task."""
    if run.recorder.on and run.recorder.wants(TaskCreated):
        run.recorder.emit(
            TaskCreated,
            task=task.number,
            goal=task.goal(),
            parent=task.parent.number if task.parent is not None else None,
            family=task.family,
            priority=task.priority,
            step=task.step.node.tag if task.step is not None else None,
        )


def read_windows(run: Run, task: Task, last: bool = False) -> None:
    """Fix the windows of a step with a known reference and bound times.

    `last` is true when the order lets the step run. Then an unbound time is a fault,
    and makes the set-up of the task fail, like a time that is no number.
    """
    method_run, wait = task.within, task.wait
    if method_run is None or wait is None or not wait.windows:
        return
    unread = []
    for window in wait.windows:
        base = _base(method_run, window)
        if base is None or not (last or window.uses <= method_run.env.keys()):
            unread.append(window)
        else:
            _open(run, task, wait, window, base)
    wait.windows = tuple(unread)


def _open(
    run: Run, task: Task, wait: WaitState, window: WindowPlan, base: float
) -> None:
    context = run.context
    context.task = task.parent
    env = task.within.env if task.within is not None else {}
    start = time_of(context, window.start, env)
    stop = None if start is None else time_of(context, window.stop, env)
    if start is None or stop is None:
        wait.setup_failed = True
        return
    wait.earliest_start = max(wait.earliest_start, number(base + start))
    if base + stop < wait.given_deadline:
        wait.given_deadline = base + stop
        run.monitors.state_deadline(task)


def _base(method_run: MethodRun, window: WindowPlan) -> float | None:
    if window.reference == "now":
        return method_run.started
    if window.reference == "absolute":
        return 0
    return (
        None
        if method_run.ends is None
        else method_run.ends.times[int(window.reference)]
    )


def read_inputs(run: Run, task: Task) -> None:
    """Read a step's bound inputs from its method's environment."""
    step, method_run = task.step, task.within
    if step is None or method_run is None:
        return
    context, env = run.context, method_run.env
    context.task = method_run.task
    values = [
        arg.value(context, env) if arg.name is None else env.get(arg.name)
        for arg in step.args
    ]
    task.goal_args = tuple(values)
    bind_inputs(task)
    if task.number and task.plan.needs_setup and task.wait is not None:
        _prepare(run, task, task.wait)
