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
from rapc.language.results import FUTILE_LOOP, INTERFERENCE, SIGNAL
from rapc.runtime.run import Run
from rapc.runtime.state.states import ELIGIBLE, ENDED
from rapc.runtime.state.task import Env, MethodRun, Task, as_told
from rapc.runtime.tasks import causes
from rapc.runtime.tasks.activations import deactivate
from rapc.runtime.tasks.effects import Change, carry_out, changes_of
from rapc.runtime.tasks.remove import (
    drop,
    free,
    remove,
    stop,
    uncount_goal,
    unregister,
)
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


def succeed(run: Run, task: Task, found: Env) -> None:
    """Succeed a task outside the agenda, or fail the task for unfit outputs.

    The method receives all outputs and effects of a step, or none. The end of the step
    carries out `until`s, then releases the steps that follow, or ends the method.
    """
    plan, step, method_run = task.plan, task.step, task.within
    outputs = _outputs(task, found) if plan.outputs else {}
    received: _Received | None = None
    if step is None or method_run is None:
        given = run.state.live_top[task.number]
        given.outcome, given.outputs = OKAY, outputs
    elif step.has_results:
        received = _received(run, method_run, step, outputs)
        if received is None:
            because = causes.of_step_end(run, task, outputs)
            fail(run, task, INTERFERENCE, because)
            return
    task.state = ENDED
    if step is None or task.wait is not None:
        unregister(run, task)
    run.state.succeeded += 1
    if run.recorder.on:
        run.recorder.emit(
            TaskSucceeded,
            task=task.number,
            goal=task.goal(outputs),
            outputs=as_told(outputs),
        )
    if plan.finish_rules:
        run_finish_rules(run, task, OKAY, outputs)
    if step is None or method_run is None:
        return
    bound = {} if received is None else _hand_over(run, task, method_run, received)
    method_run.steps_left -= 1
    following = step.after
    if method_run.ends is not None:
        method_run.ends.times[step.position] = run.recorder.time
        ended = apply_until(run, method_run, step, at_end=True)
        following = sorted(following + ended)
    if bound and recheck_bound_steps(run, method_run, bound):
        return
    if method_run.steps_left:
        release_followers(run, method_run, following)
    else:
        end_method(run, method_run, OKAY)


def _hand_over(run: Run, task: Task, method_run: MethodRun, received: _Received) -> Env:
    """Pass what a step's method receives to the method; return the bindings."""
    bound, changes = received
    method_run.env.update(bound)
    for change in changes:
        carry_out(run, task, change)
    return bound


def _received(
    run: Run, method_run: MethodRun, step: StepPlan, outputs: Env
) -> _Received | None:
    """Return the bindings and changes of a success; None if one is impossible."""
    names = method_run.steps[step.position].plan.outputs
    arriving = [
        (to, outputs[name])
        for name, to in zip(names, step.outputs, strict=False)
        if name in outputs
    ]
    bound = receive(run, method_run, arriving)
    changes = None if bound is None else changes_of(run, method_run, step, bound)
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
    run: Run, method_run: MethodRun, arriving: Iterable[tuple[OutputTarget, Value]]
) -> Env | None:
    """Return the bindings for a method's environment; None if a value does not fit."""
    bound: Env = {}
    run.context.task = method_run.task
    for receiver, value in arriving:
        if receiver.anonymous:
            continue
        env = {**method_run.env, **bound}
        if receiver.variable is not None and receiver.variable not in env:
            bound[receiver.variable] = value
        elif receiver.term.needed(run.context, env) != value:
            return None
    return bound


def release_followers(
    run: Run, method_run: MethodRun, following: Sequence[int]
) -> None:
    """Release, in the order of the text, steps whose predecessors have all ended.

    `following` are the positions of the steps that follow each ended step, sorted.
    """
    steps = method_run.steps
    if method_run.plan.windows:
        for at in following:
            if steps[at].live:
                may_run = following.count(at) == steps[at].waiting
                read_windows(run, steps[at], last=may_run)
    for at in following:
        task = steps[at]
        if task.state is not ENDED:
            task.waiting -= 1
            if task.waiting == 0:
                release(run, task)


def apply_until(
    run: Run, method_run: MethodRun, step: StepPlan, *, at_end: bool
) -> list[int]:
    """Remove the live steps whose `until` names `step`.

    Each removed step counts as ended. Return the sorted positions of the steps that
    follow each removed step; the caller releases them.

    Args:
        run: the run.
        method_run: the method under way.
        step: the step that has started or ended.
        at_end: whether `step` has ended: `until-end`, else `until-start`.
    """
    following: list[int] = []
    for target, when in step.until:
        task = method_run.steps[target]
        if when != at_end or not task.live:
            continue
        remove(run, task, "until")
        if method_run.ends is not None:
            method_run.ends.ended_by_until.add(target)
            method_run.ends.times[target] = run.recorder.time
        method_run.steps_left -= 1
        following += method_run.plan.steps[target].after
    return sorted(following)


def recheck_bound_steps(
    run: Run, method_run: MethodRun, bound: Iterable[str], *positions: int
) -> bool:
    """Read the inputs of steps again that use variables in `bound`.

    Return whether a step now repeats an ancestor: then the method has ended badly, and
    its task has failed with `futile-loop`. The steps at `positions` are read again in
    any case.
    """
    users = method_run.plan.steps_by_variable
    for at in sorted(
        {*positions, *(at for name in bound for at in users.get(name, ()))}
    ):
        task = method_run.steps[at]
        if not task.live:
            continue
        read_windows(run, task)
        if task.bound and task.goal_key is not None:
            continue
        if not task.bound:
            read_inputs(run, task)
        if task.bound and task.goal_key is None and repeats_ancestor(run, task):
            because = causes.of_recursion(run, task)
            end_method(run, method_run, FUTILE_LOOP, because, "parent-failed")
            run.eligible.discard(method_run.task)
            fail(run, method_run.task, FUTILE_LOOP, because)
            return True
        if task.bound and task in run.eligible:
            run.eligible.discard(task)
            release(run, task, again=True)
    return False


# --- failure ----------------------------------------------------------------------


def fail(run: Run, task: Task, reason: str, because: Cause | None = None) -> None:
    """Fail a task: end its method, and make its parent eligible again."""
    world_failure = task.world_failure
    result = world_failure or reason
    if task.step is None:
        given = run.state.live_top[task.number]
        given.outcome, given.because = result, because
    task.state = ENDED
    unregister(run, task)
    if run.recorder.on:
        run.recorder.emit(
            TaskFailed,
            task=task.number,
            goal=task.goal(),
            reason=reason,
            result=result,
            because=because,
        )
    if task.plan.finish_rules:
        run_finish_rules(run, task, result, {})
    method_run = task.within
    if method_run is None:
        return
    if world_failure is not None:
        method_run.task.remember().failure = world_failure
    if method_run.task.plan.node.plan is not None:
        method_run.task.remember().note_failed_step(task.goal_fact())
    end_method(run, method_run, result, causes.of_child(run, task, result, because))


def end_method(
    run: Run,
    method_run: MethodRun,
    result: str,
    because: Cause | None = None,
    cause: str = "sibling-failed",
) -> None:
    """End a method: remove its live steps, and make its task eligible again.

    `because` is the cause of a failure, `cause` the reason for the removal of its
    steps.
    """
    task, failed = method_run.task, result != OKAY
    if failed and because is None:
        because = causes.of_result(run, method_run, result)
    task.run = None
    if method_run.steps_left:
        for step in method_run.steps:
            if step.state is not ENDED:
                remove(run, step, cause)
    if method_run.plan.gives_back or run.held or run.all_may_recur:
        _give_back(run, method_run)
    if run.recorder.on:
        run.recorder.emit(
            MethodEnded,
            task=task.number,
            method=method_run.plan.name,
            result=result,
            because=because,
        )
    task.last_result = result
    if failed or task.history is not None:
        task.note_result(method_run.plan, result)
        task.remember().because = because
    if task.plan.notes_success and not failed:
        _note_success(run, method_run)
    method_run.steps = ()
    task.state = ELIGIBLE
    if task.wait is not None:
        task.wait.after_method = True
        if task.plan.monitor_time is not None:
            run.monitors.arm(task, run.recorder.time)
    run.eligible.add(task)


def _note_success(run: Run, method_run: MethodRun) -> None:
    """Remember the outputs of a successful method, and its steps if they did nothing.

    The steps of a plan that has taken no time count as failed: if the goal does not
    hold then, the next plan would have the same steps, without end. If the goal holds,
    the count has no influence.
    """
    task = method_run.task
    if task.plan.outputs:
        task.remember().success = method_run.env
    if task.plan.node.plan is not None and method_run.started == run.recorder.time:
        for step in method_run.steps:
            task.remember().note_failed_step(step.goal_fact())


def _give_back(run: Run, method_run: MethodRun) -> None:
    """Release a method's goal key, skills, things and notations."""
    task = method_run.task
    if task.plan.recursive or run.all_may_recur:
        uncount_goal(run, task)
    if method_run.plan.activation is not None:
        _switch_off(run, method_run)
    free(run, method_run)


def _switch_off(run: Run, method_run: MethodRun) -> None:
    """Switch off the skills of an ended method; unregister waiting skills."""
    if method_run.ticket is not None:
        deactivate(run, method_run.ticket)
    if run.thing_waits:
        run.things.stop_waiting(method_run.task)


def finish_by_signal(run: Run, task: Task, mode: str) -> None:
    """End a step, waiting or running, because of a signal; remove its descendants."""
    method_run = stop(run, task)
    if method_run is not None:
        for step in method_run.steps:
            if step.live:
                remove(run, step, SIGNAL)
        drop(run, method_run)
    run.eligible.discard(task)
    run.things.stop_waiting(task)
    if mode == "succeed":
        succeed(run, task, {})
    else:
        fail(run, task, SIGNAL, causes.of_signal(run, task))
