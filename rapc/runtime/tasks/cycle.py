"""One task's cycle: from its selection to success, failure, blocking or trying.

The steps are those of [L 3] [T 3.2, 3.4.1]; the first that settles the task
ends the cycle.
"""

from __future__ import annotations

from rapc.events import FamilySwitched, TaskSelected
from rapc.language.results import INTERFERENCE
from rapc.runtime.run import Run
from rapc.runtime.state.states import ENDED
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.runtime.state.wait_state import WaitState
from rapc.runtime.tasks import causes
from rapc.runtime.tasks.finish import (
    apply_until,
    end_method,
    fail,
    recheck_bound_steps,
    release_followers,
    succeed,
)
from rapc.runtime.tasks.start import (
    read_inputs,
)
from rapc.runtime.tasks.try_method import try_method
from rapc.world import OKAY


def run_cycle(run: Run, task: Task) -> None:
    """Process the selected task."""
    plan, wait = task.plan, task.wait
    if run.thing_waits:
        run.things.stop_waiting(task)
    if task.goal_key is None or (
        wait is not None and (wait.setup_failed or not wait.first_selected)
    ):
        _first_of_all(run, task)
        if task.state is ENDED:
            return
    else:
        if run.recorder.on:
            _tell_selected(run, task)
        run.eligible.last_family = task.family
    if plan.succeed is None:
        found: Env | None = {} if task.last_result == OKAY else None
    else:
        context = run.context
        context.task, never = task, plan.never_succeeds
        found = None if never else context.bound[plan.succeed].first(task.env)
    if found is not None:
        succeed(run, task, found)
        return
    if (
        plan.monitored
        and wait is not None
        and not (wait.first_selected and run.monitors.still_hold(task, wait))
    ):
        run.monitors.block(task)
        return
    above = task.within
    if (
        plan.conditional
        or (above and (above.plan.conditions or above.constrained is not None))
    ) and not _conditions_hold(run, task):
        if task.state is not ENDED:
            because = causes.of_conditions(run, task)
            fail(run, task, INTERFERENCE, because)
        return
    try_method(run, task)


def _first_of_all(run: Run, task: Task) -> None:
    """Do step 1 and the triggers of the first selection; may end the task."""
    wait, unbound = task.wait, False
    if not task.bound:
        read_inputs(run, task)
        unbound = not task.bound
    if run.recorder.on:
        _tell_selected(run, task)
    run.eligible.last_family = task.family
    if wait is not None and not (wait.first_selected or task.plan.monitored):
        _begin(run, task, wait)
    if (unbound or task.goal_key is None) and _misses_inputs(run, task):
        return
    if wait is not None:
        if wait.setup_failed:
            fail(run, task, INTERFERENCE, causes.of_set_up(run, task))
        elif not wait.first_selected:
            _begin(run, task, wait)


def _tell_selected(run: Run, task: Task) -> None:
    recorder, last = run.recorder, run.eligible.last_family
    if last is not None and last != task.family:
        recorder.emit(FamilySwitched, task=task.number, from_=last, to=task.family)
    if recorder.wants(TaskSelected):
        recorder.emit(TaskSelected, task=task.number, goal=task.goal())


def _begin(run: Run, task: Task, wait: WaitState) -> None:
    """Trigger `until-start` at the first selection with monitors holding."""
    step, method_run = task.step, task.within
    if step is None or method_run is None or not step.until:
        wait.first_selected = True
        return
    if task.plan.monitored and not run.monitors.still_hold(task, wait):
        return
    wait.first_selected = True
    release_followers(run, method_run, apply_until(run, method_run, step, at_end=False))


def _misses_inputs(run: Run, task: Task) -> bool:
    """Do step 1: bind unbound inputs; return whether this has ended the task."""
    method_run, step = task.within, task.step
    if method_run is not None and step is not None:
        run.context.task = method_run.task
        bound: list[str] = []
        for carrier, query in step.conditions:
            if not method_run.was_ended_by_until(carrier):
                found = query.first(run.context, method_run.env) or {}
                method_run.env.update(found)
                bound.extend(found)
        if recheck_bound_steps(run, method_run, bound, step.position):
            return True
        run.context.task = method_run.task
        for arg, value in zip(step.args, task.goal_args, strict=True):
            if value is None:
                arg.needed(run.context, method_run.env)
    if not task.bound:
        fail(run, task, INTERFERENCE, causes.of_inputs(run, task))
    return not task.live


def _conditions_hold(run: Run, task: Task) -> bool:
    """Do step 4: `for` formulas, preconditions, constraints of the task and above.

    Return whether all hold. Return also False if a new binding, or a constraint of a
    method, has ended the method of which the task is a step.
    """
    method_run, step, context = task.within, task.step, run.context
    if method_run is not None and step is not None:
        for carrier, query in step.conditions:
            if method_run.was_ended_by_until(carrier):
                continue
            context.task = method_run.task
            found = context.bound[query].first(method_run.env)
            if found is None:
                return False
            if found:
                method_run.env.update(found)
                if recheck_bound_steps(run, method_run, found):
                    return False
    context.task = task
    own = task.plan.preconditions
    if own is not None and not context.bound[own].holds(task.env):
        return False
    stated = task if task.plan.constraints is not None else task.constrained
    return stated is None or _constraints_hold(run, stated)


def _constraints_hold(run: Run, nearest: Task | MethodRun) -> bool:
    """Return whether the constraints of `nearest` and of all ancestors hold now.

    If a method's constraints do not hold, the method ends, and its descendants are
    removed. If nothing has changed since all constraints held, they still hold,
    provided that they depend only on memory, resources and the clock. Therefore an
    endless descent evaluates each of its tasks only once.
    """
    context, changes = run.context, run.monitors.listeners.changes
    faults, steady = context.faults, True
    stated: Task | MethodRun | None = nearest
    while stated is not None:
        if isinstance(stated, MethodRun):
            if not _method_holds(run, stated):
                return False
            steady, stated = False, stated.constrained_above
            continue
        if stated.held_at == changes:
            break
        plan, context.task = stated.plan, stated
        if plan.constraints is not None:
            if not context.bound[plan.constraints].holds(stated.env):
                return False
            steady = steady and plan.steady
        stated = stated.constrained
    if steady and context.faults == faults:
        assert isinstance(nearest, Task)
        nearest.held_at = changes
    return True


def _method_holds(run: Run, method_run: MethodRun) -> bool:
    """Return whether the constraints of a method hold; otherwise end the method."""
    context, constraints = run.context, method_run.plan.constraints
    context.task = method_run.task
    if constraints is None or context.bound[constraints].holds(method_run.env):
        return True
    because = causes.of_method_constraints(run, method_run)
    end_method(run, method_run, INTERFERENCE, because, "parent-failed")
    return False
