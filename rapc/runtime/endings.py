"""What follows when a step, a method or a task ends (semantics 3, 4, 6).

A step that ends by itself sets off its outputs, effects and `until`s, then lets the
steps behind it go on, or ends its method; a failed one takes its method with it.
Removal of whole subtrees is iterative: tasks may nest without limit.
"""

from __future__ import annotations

from rapc.compiler.plans import StepPlan, WindowPlan
from rapc.resources import Counter, SetResource, Value, frozen
from rapc.runtime.events import (
    MethodEnded,
    ResourceChanged,
    TaskCreated,
    TaskFailed,
    TaskRemoved,
    TaskSucceeded,
)
from rapc.runtime.machine import Machine
from rapc.runtime.monitors import time_of
from rapc.runtime.task import Env, MethodRun, State, Task
from rapc.runtime.world import OKAY
from rapc.terms import format_atom, is_number

INTERFERENCE = "interference"
NO_METHOD = "no-method"
FUTILE_LOOP = "futile-loop"

_Change = tuple[str, Counter | SetResource, Value]


# --- beginnings ----------------------------------------------------------------


def create(machine: Machine, task: Task) -> None:
    """A task joins the run; one whose inputs are bound gets its resources now."""
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


def settle_inputs(machine: Machine, task: Task) -> None:
    """The inputs of a task are all bound: fix them, make its resources."""
    plan = task.plan
    task.env = dict(zip(plan.inputs, task.goal_args, strict=True))  # type: ignore[arg-type]
    task.bound = True
    task.identity = identity(task)
    machine.context.task = task
    for resource, initial in plan.resources:
        value = None if initial is None else initial.value(machine.context, task.env)
        made = _make(resource.kind, initial is not None, value)
        if made is None:
            where = "resources" if initial is None else initial.where
            machine.context.fault(where, f"`{value}` is no {resource.kind}")
            task.spoilt = True
        else:
            task.env[resource.variable.name] = made
    if plan.duration is not None:
        duration = time_of(plan.duration.value(machine.context, task.env))
        if duration is None:
            machine.context.fault(plan.duration.where, "the duration is not a number")
        task.duration = duration or 0
    machine.monitors.arm(task)


def _make(kind: str, given: bool, value: Value | None) -> Counter | SetResource | None:
    if kind == "counter":
        if isinstance(value, Counter):
            return Counter(value.value)
        if not given:
            return Counter()
        return Counter(value) if isinstance(value, int | float) else None
    if isinstance(value, SetResource):
        return SetResource(value.members)
    return None if given else SetResource()


def identity(task: Task) -> object:
    """A RAP with its input values, resources by what they hold now."""
    return (task.plan.name, *(frozen(v) for v in task.goal_args if v is not None))


def repeats_ancestor(task: Task) -> bool:
    """Whether a task asks for what an ancestor of it asks for (T 3.2.5)."""
    above = task.parent
    while above is not None:
        if above.identity == task.identity:
            return True
        above = above.parent
    return False


def let_go(machine: Machine, task: Task) -> None:
    """All that a task was ordered after has ended: it runs when its time comes."""
    start = _start_time(machine, task)
    if start > machine.recorder.time:
        machine.monitors.at(start, task)
    else:
        make_ready(machine, task)


def make_ready(machine: Machine, task: Task) -> None:
    """Order and start times let a task run: test its monitors or make it eligible."""
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
    start = time_of(window.start.value(machine.context, run.env))
    stop = time_of(window.stop.value(machine.context, run.env))
    if start is None or stop is None:
        machine.context.fault(window.start.where, "a time is not a number")
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


# --- good endings ----------------------------------------------------------------


def succeed(machine: Machine, task: Task, found: Env) -> None:
    """A task's `succeed` holds: hand its outputs up and end it, or fail it."""
    outputs = _outputs(task, found)
    step, run = task.step, task.within
    bound: Env | None = {}
    changes: list[_Change] | None = []
    if step is not None and run is not None:
        bound = match_outputs(machine, task, run, step, outputs)
        changes = None if bound is None else _effects(machine, run, step, bound)
    if bound is None or changes is None:
        fail(machine, task, INTERFERENCE)
        return
    _leave(machine, task)
    if machine.recorder.on:
        machine.recorder.emit(
            TaskSucceeded,
            task=task.number,
            goal=task.goal(outputs),
            outputs={name: format_atom(value) for name, value in outputs.items()},
        )
    if step is None or run is None:
        task.last_result = OKAY
        machine.ended_top.append(task)
        return
    run.env.update(bound)
    for change in changes:
        _apply(machine, task, *change)
    step_ended(machine, run, step.position, bool(bound))


def _outputs(task: Task, found: Env) -> Env:
    outputs: Env = {}
    for name in task.plan.outputs:
        value = found.get(name)
        if value is None and task.success_env is not None:
            value = task.success_env.get(name)
        if value is not None:
            outputs[name] = value
    return outputs


def match_outputs(
    machine: Machine, task: Task, run: MethodRun, step: StepPlan, outputs: Env
) -> Env | None:
    """What a step's outputs bind in its method; None if one does not fit."""
    bound: Env = {}
    machine.context.task = run.task
    for name, output in zip(task.plan.outputs, step.outputs, strict=False):
        value = outputs.get(name)
        if value is None or output.anonymous:
            continue
        known = output.term.value(machine.context, {**run.env, **bound})
        if known is None and output.variable is not None:
            bound[output.variable] = value
        elif known != value:
            return None
    return bound


def _effects(
    machine: Machine, run: MethodRun, step: StepPlan, bound: Env
) -> list[_Change] | None:
    """The changes of a step's effects; None if one of them cannot be made."""
    changes: list[_Change] = []
    env = {**run.env, **bound} if step.effects else run.env
    machine.context.task = run.task
    for effect in step.effects:
        resource = effect.resource.value(machine.context, env)
        amount = effect.amount.value(machine.context, env)
        kind = Counter if effect.node.op.startswith("counter") else SetResource
        fits = isinstance(resource, kind) and amount is not None
        if kind is Counter:
            fits = fits and is_number(amount)
        elif isinstance(amount, Counter | SetResource):
            fits = False
        if not fits or amount is None:
            machine.context.fault(effect.amount.where, "the effect cannot be done")
            return None
        assert isinstance(resource, Counter | SetResource)
        changes.append((effect.node.op, resource, amount))
    return changes


def _apply(
    machine: Machine, task: Task, op: str, resource: Counter | SetResource, by: Value
) -> None:
    if isinstance(resource, Counter):
        assert isinstance(by, int | float)
        resource.add(by if op == "counter-add" else -by)
    elif op == "set-add":
        resource.add(by)  # type: ignore[arg-type]  # resources were refused
    else:
        resource.remove(by)  # type: ignore[arg-type]  # resources were refused
    machine.monitors.resource_changed(resource)
    if machine.recorder.on:
        what = f"{op} {format_atom(by)}: {resource}"
        machine.recorder.emit(ResourceChanged, task=task.number, what=what)


def step_ended(
    machine: Machine, run: MethodRun, position: int, bound: bool = False
) -> None:
    """A step has ended by itself: `until`s, then its followers or the method's end."""
    run.ends[position] = machine.recorder.time
    run.left -= 1
    for target, at_end in run.plan.steps[position].until:
        if at_end:
            until(machine, run, target)
    if bound and late_recursion(machine, run):
        return
    _followers(machine, run, position)
    if run.left == 0:
        end_method(machine, run, OKAY)


def _followers(machine: Machine, run: MethodRun, position: int) -> None:
    for behind in run.plan.steps[position].after:
        task = run.steps[behind]
        if not task.live:
            continue
        state_windows(machine, task, position)
        task.waiting -= 1
        if task.waiting == 0:
            let_go(machine, task)


def until(machine: Machine, run: MethodRun, position: int) -> None:
    """An `until` ends a step: it leaves with all it spawned, and counts as ended."""
    task = run.steps[position]
    if not task.live:
        return
    remove(machine, task, "until")
    run.lapsed.add(position)
    run.ends[position] = machine.recorder.time
    run.left -= 1
    _followers(machine, run, position)


def late_recursion(machine: Machine, run: MethodRun) -> bool:
    """New bindings reach the steps that miss inputs; one may repeat an ancestor.

    Then the method has ended badly and its task has failed, `futile-loop`.
    """
    for task in run.steps:
        if task.live and not task.bound:
            fill_inputs(machine, task)
            if task.bound and repeats_ancestor(task):
                end_method(machine, run, FUTILE_LOOP, "parent-failed")
                fail(machine, run.task, FUTILE_LOOP)
                return True
    return False


def fill_inputs(machine: Machine, task: Task) -> None:
    """Read a step's inputs from its method's environment; fix them if all are there."""
    if task.step is None or task.within is None:
        return
    machine.context.task = task.within.task
    env = task.within.env
    task.goal_args = tuple([arg.value(machine.context, env) for arg in task.step.args])
    if None not in task.goal_args:
        settle_inputs(machine, task)


# --- bad endings -----------------------------------------------------------------


def fail(machine: Machine, task: Task, reason: str) -> None:
    """A task fails: its method goes with it, its parent comes up again."""
    result = task.world_failure or reason
    _leave(machine, task)
    if machine.recorder.on:
        machine.recorder.emit(
            TaskFailed,
            task=task.number,
            goal=task.goal(),
            reason=reason,
            result=result,
        )
    run = task.within
    if run is None:
        task.last_result = result
        machine.ended_top.append(task)
        return
    if task.world_failure is not None:
        run.task.world_failure = task.world_failure
    end_method(machine, run, result)


def end_method(
    machine: Machine, run: MethodRun, result: str, cause: str = "sibling-failed"
) -> None:
    """A method ends; steps still live leave, and its task comes up again."""
    task = run.task
    task.run = None
    for step in run.steps:
        if step.live:
            remove(machine, step, cause)
    for notation in run.notations:
        machine.memory.forget(notation)
    if machine.recorder.on:
        machine.recorder.emit(
            MethodEnded, task=task.number, method=run.plan.name, result=result
        )
    task.last_result = result
    task.results[run.plan.node.name] = result
    if result == OKAY:
        task.success_env = run.env
    else:
        task.failed = True
        at = run.plan.index
        task.failures[at] = task.failures.get(at, 0) + 1
    task.after_method = True
    task.state = State.ELIGIBLE
    machine.monitors.arm(task)
    machine.agenda.add(task)


def remove(machine: Machine, task: Task, cause: str) -> None:
    """A task leaves without ending by itself, after all that it has spawned."""
    stack = [task]
    leaving = []
    while stack:
        top = stack.pop()
        leaving.append(top)
        if top.run is not None:
            stack.extend(step for step in top.run.steps if step.live)
    for gone in reversed(leaving):
        run, gone.run = gone.run, None
        _leave(machine, gone)
        if run is not None:
            if run.ticket is not None:
                machine.pending[run.ticket] = (None, machine.pending[run.ticket][1])
            for notation in run.notations:
                machine.memory.forget(notation)
        if machine.recorder.on:
            why = cause if gone is task else "parent-removed"
            machine.recorder.emit(TaskRemoved, task=gone.number, cause=why)


def _leave(machine: Machine, task: Task) -> None:
    machine.agenda.discard(task)
    task.state = State.ENDED
    machine.monitors.forget(task)
    machine.tasks.pop(task.number, None)
