"""Consequences of the end of a step, a method or a task [L 3, 4, 6].

A step that ends by itself triggers its outputs, effects and `until`s, then releases the
steps that follow it, or ends its method. A failed step ends its method. Not here: the
removal of tasks that have not ended by themselves (`rapc.runtime.tasks.remove`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rapc.base.resources import Value
from rapc.compiler.net_plan import OutputTarget, StepPlan
from rapc.events import (
    Cause,
    MethodEnded,
    TaskFailed,
    TaskSucceeded,
)
from rapc.runtime.run import Run
from rapc.runtime.state.states import (
    ELIGIBLE,
    ENDED,
    FUTILE_LOOP,
    INTERFERENCE,
    SIGNAL,
)
from rapc.runtime.state.task import Env, MethodRun, Task, as_told
from rapc.runtime.tasks import causes
from rapc.runtime.tasks.activations import deactivate
from rapc.runtime.tasks.effects import Change, carry_out, changes_of
from rapc.runtime.tasks.remove import discount, drop, free, remove, stop, unregister
from rapc.runtime.tasks.rules import run_finish_rules
from rapc.runtime.tasks.start import (
    read_inputs,
    read_windows,
    release,
    repeats_ancestor,
)
from rapc.world import OKAY

_Received = tuple[Env, Sequence[Change]]
"""The bindings and the changes that a step's success makes in its method."""

# --- success ----------------------------------------------------------------------


def succeed(machine: Run, task: Task, found: Env) -> None:
    """Succeed a task outside the agenda, or fail the task for unfit outputs.

    The method receives all outputs and effects of a step, or none. The end of the step
    carries out `until`s, then releases the steps that follow, or ends the method.
    """
    plan, step, run = task.plan, task.step, task.within
    outputs = _outputs(task, found) if plan.outputs else {}
    received: _Received | None = None
    if step is None or run is None:
        given = machine.state.live_top[task.number]
        given.outcome, given.outputs = OKAY, outputs
    elif step.has_results:
        received = _received(machine, run, step, outputs)
        if received is None:
            because = causes.of_step_end(machine, task, outputs)
            fail(machine, task, INTERFERENCE, because)
            return
    task.state = ENDED
    if step is None or task.wait is not None or machine.waits:
        unregister(machine, task)
    machine.state.succeeded += 1
    if machine.recorder.on:
        machine.recorder.emit(
            TaskSucceeded,
            task=task.number,
            goal=task.goal(outputs),
            outputs=as_told(outputs),
        )
    if plan.finish_rules:
        run_finish_rules(machine, task, OKAY, outputs)
    if run is not None and step is not None:
        _finish_step(machine, run, step, received)


def _finish_step(
    machine: Run, run: MethodRun, step: StepPlan, received: _Received | None
) -> None:
    """Pass `received` to a step's method; release followers or end the method."""
    bound: Env = {}
    if received is not None:
        bound, changes = received
        run.env.update(bound)
        for change in changes:
            carry_out(machine, run.steps[step.position], change)
    run.steps_left -= 1
    following = step.after
    if run.ends is not None:
        run.ends.times[step.position] = machine.recorder.time
        following = following + apply_until(machine, run, step, at_end=True)
    if bound and recheck_bound_steps(machine, run, bound):
        return
    if run.steps_left:
        release_followers(machine, run, following)
    else:
        end_method(machine, run, OKAY)


def _received(
    machine: Run, run: MethodRun, step: StepPlan, outputs: Env
) -> _Received | None:
    """Return the bindings and changes of a success; None if one is impossible."""
    names = run.steps[step.position].plan.outputs
    arriving = [
        (to, outputs[name])
        for name, to in zip(names, step.outputs, strict=False)
        if name in outputs
    ]
    bound = receive(machine, run, arriving)
    changes = None if bound is None else changes_of(machine, run, step, bound)
    return None if bound is None or changes is None else (bound, changes)


def _outputs(task: Task, found: Env) -> Env:
    outputs: Env = {}
    for name in task.plan.outputs:
        value = found.get(name)
        history = task.history
        if value is None and history is not None and history.success is not None:
            value = history.success.get(name)
        if value is not None:
            outputs[name] = value
    return outputs


def receive(
    machine: Run, run: MethodRun, arriving: Iterable[tuple[OutputTarget, Value]]
) -> Env | None:
    """Return the bindings for a method's environment; None if a value does not fit."""
    bound: Env = {}
    machine.context.task = run.task
    for receiver, value in arriving:
        if receiver.anonymous:
            continue
        env = {**run.env, **bound}
        if receiver.variable is not None and receiver.variable not in env:
            bound[receiver.variable] = value
        elif receiver.term.needed(machine.context, env) != value:
            return None
    return bound


def release_followers(machine: Run, run: MethodRun, following: Sequence[int]) -> None:
    """Release, in the order of the text, steps whose predecessors have all ended.

    `following` are the positions of the steps that follow each ended step.
    """
    steps = run.steps
    if run.plan.windows:
        for at in following:
            if steps[at].live:
                read_windows(machine, steps[at])
    for at in sorted(following):
        task = steps[at]
        if task.state is not ENDED:
            task.waiting -= 1
            if task.waiting == 0:
                release(machine, task)


def apply_until(
    machine: Run, run: MethodRun, step: StepPlan, *, at_end: bool
) -> list[int]:
    """Remove the live steps whose `until` names `step`.

    Each removed step counts as ended. Return the positions of the steps that follow
    each removed step; the caller releases them.

    Args:
        machine: the machine of the run.
        run: the method under way.
        step: the step that has started or ended.
        at_end: whether `step` has ended: `until-end`, else `until-start`.
    """
    following: list[int] = []
    for target, when in step.until:
        task = run.steps[target]
        if when != at_end or not task.live:
            continue
        remove(machine, task, "until")
        if run.ends is not None:
            run.ends.ended_by_until.add(target)
            run.ends.times[target] = machine.recorder.time
        run.steps_left -= 1
        following += run.plan.steps[target].after
    return following


def recheck_bound_steps(
    machine: Run, run: MethodRun, bound: Iterable[str], *positions: int
) -> bool:
    """Read the inputs of steps again that use variables in `bound`.

    Return whether a step now repeats an ancestor: then the method has ended badly, and
    its task has failed with `futile-loop`. The steps at `positions` are read again in
    any case.
    """
    users = run.plan.steps_by_variable
    for at in sorted(
        {*positions, *(at for name in bound for at in users.get(name, ()))}
    ):
        task = run.steps[at]
        if not task.live:
            continue
        read_windows(machine, task)
        if task.bound and task.identity is not None:
            continue
        if not task.bound:
            read_inputs(machine, task)
        if task.bound and task.identity is None and repeats_ancestor(machine, task):
            because = causes.of_recursion(machine, task)
            end_method(machine, run, FUTILE_LOOP, because, "parent-failed")
            machine.eligible.discard(run.task)
            fail(machine, run.task, FUTILE_LOOP, because)
            return True
        if task.bound and task in machine.eligible:
            machine.eligible.discard(task)
            release(machine, task, again=True)
    return False


# --- failure ----------------------------------------------------------------------


def fail(machine: Run, task: Task, reason: str, because: Cause | None = None) -> None:
    """Fail a task: end its method, and make its parent eligible again."""
    world_failure = task.world_failure
    result = world_failure or reason
    if task.step is None:
        given = machine.state.live_top[task.number]
        given.outcome, given.because = result, because
    task.state = ENDED
    unregister(machine, task)
    if machine.recorder.on:
        machine.recorder.emit(
            TaskFailed,
            task=task.number,
            goal=task.goal(),
            reason=reason,
            result=result,
            because=because,
        )
    if task.plan.finish_rules:
        run_finish_rules(machine, task, result, {})
    run = task.within
    if run is None:
        return
    if world_failure is not None:
        run.task.remember().failure = world_failure
    end_method(machine, run, result, causes.of_child(machine, task, result, because))


def end_method(
    machine: Run,
    run: MethodRun,
    result: str,
    because: Cause | None = None,
    cause: str = "sibling-failed",
) -> None:
    """End a method: remove its live steps, and make its task eligible again.

    `because` is the cause of a failure, `cause` the reason for the removal of its
    steps.
    """
    task, recorder, failed = run.task, machine.recorder, result != OKAY
    if failed and because is None:
        because = causes.of_result(machine, run, result)
    task.run = None
    if run.steps_left:
        for step in run.steps:
            if step.state is not ENDED:
                remove(machine, step, cause)
    run.steps = ()
    if run.plan.gives_back or machine.held or machine.all_may_recur:
        _give_back(machine, run)
    if recorder.on:
        recorder.emit(
            MethodEnded,
            task=task.number,
            method=run.plan.name,
            result=result,
            because=because,
        )
    task.last_result = result
    if failed or task.history is not None:
        task.note_result(run.plan, result)
        task.remember().because = because
    if task.plan.outputs and not failed:
        task.remember().success = run.env
    task.state = ELIGIBLE
    if task.wait is not None:
        task.wait.after_method = True
        if task.plan.monitor_time is not None:
            machine.monitors.arm(task, recorder.time)
    machine.eligible.add(task)


def _give_back(machine: Run, run: MethodRun) -> None:
    """Release a method's identity, skills, things and notations."""
    task = run.task
    if task.plan.recursive or machine.all_may_recur:
        discount(machine, task)
    if run.plan.activation is not None:
        _switch_off(machine, run)
    free(machine, run)


def _switch_off(machine: Run, run: MethodRun) -> None:
    """Switch off the skills of an ended method; unregister waiting skills."""
    if run.ticket is not None:
        deactivate(machine, run.ticket)
    if machine.waits:
        machine.things.stop_waiting(run.task)


def finish_by_signal(machine: Run, task: Task, mode: str) -> None:
    """End a step, waiting or running, because of a signal; remove its descendants."""
    run = stop(machine, task)
    if run is not None:
        for step in run.steps:
            if step.live:
                remove(machine, step, SIGNAL)
        drop(machine, run)
    machine.eligible.discard(task)
    if mode == "succeed":
        succeed(machine, task, {})
    else:
        fail(machine, task, SIGNAL, causes.of_signal(machine, task))
