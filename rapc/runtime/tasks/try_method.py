"""A task tries a method: from the choice to the method's start [L 3].

Not here: the choice of the method (`rapc.runtime.tasks.choose`) and the ends of methods
(`rapc.runtime.tasks.finish`).
"""

from __future__ import annotations

from rapc.compiler.rap_plan import ActivationPlan, MethodPlan
from rapc.errors import FactError
from rapc.events import Cause, MethodChosen
from rapc.language.results import FUTILE_LOOP, INTERFERENCE, NO_METHOD
from rapc.runtime.run import Run
from rapc.runtime.state.states import RUNNING
from rapc.runtime.state.task import MethodRun, Task, as_told
from rapc.runtime.tasks import causes
from rapc.runtime.tasks.activations import activate
from rapc.runtime.tasks.choose import Key, choice_key, choose
from rapc.runtime.tasks.finish import end_method, fail
from rapc.runtime.tasks.hold_things import (
    UNFILLED,
    WAITS,
    can_claim,
    hold_or_wait,
    settle_refusal,
)
from rapc.runtime.tasks.primitives import ground, request
from rapc.runtime.tasks.start import (
    create,
    read_inputs,
    read_windows,
    release,
    repeats_ancestor,
)
from rapc.world import OKAY, Refused


def try_method(run: Run, task: Task) -> None:
    """Do steps 5 to 9: choose and start a method, or fail."""
    choice = choose(run, task)
    if choice is None:
        fail(run, task, NO_METHOD, causes.of_no_method(run, task))
        return
    method, found, others = choice
    env = task.env
    key = choice_key(method, env, found) if env or found else method.key
    if task.choice is None:
        task.choice = key
    elif not _note_choice(run, task, key):
        because = causes.of_futile_choice(run, task, method, found)
        fail(run, task, FUTILE_LOOP, because)
        return
    if found:
        env = {**env, **found}
    elif method.binds:
        env = env.copy()
    method_run = MethodRun(task, method, env, run.recorder.time)
    if method.steps:
        repeating = _spawn(run, method_run)
        if repeating is not None:
            fail(run, task, FUTILE_LOOP, causes.of_recursion(run, repeating))
            return
    if not method.things:
        start_method(run, method_run)
        return
    come = hold_or_wait(run, method_run, others)
    if come is not WAITS:
        start_method(run, method_run, come is UNFILLED)


def _note_choice(run: Run, task: Task, key: Key) -> bool:
    """Record a choice after the first; return False for a futile choice."""
    settings = run.settings
    if task.times_chosen(key, settings.max_choices) >= settings.futile_limit:
        return False
    task.note_choice(key)
    return True


def _spawn(run: Run, method_run: MethodRun) -> Task | None:
    """Make the steps' tasks without numbers; return a task that repeats an ancestor."""
    method = method_run.plan
    if not method.goals:
        _look_up(run, method)
    tasks = [Task(rap, method_run, step) for step, rap in method.goals]
    method_run.begin_steps(tasks)
    if method.static_goals and not run.all_may_recur:
        return None
    for task in tasks:
        if task.plan.inputs:
            read_inputs(run, task)
        if (
            (task.goal_key is None or run.all_may_recur)
            and task.bound
            and repeats_ancestor(run, task)
        ):
            return task
    return None


def _look_up(run: Run, method: MethodPlan) -> None:
    """Find the RAPs of a method's steps, once for all runs."""
    raps = [run.library.known_rap(step.node.goal.name) for step in method.steps]
    method.goals = tuple(zip(method.steps, raps, strict=True))
    method.makes = method.computes or any(rap.needs_setup for rap in raps)
    method.static_goals = all(rap.static_goal_key is not None for rap in raps)


def start_method(run: Run, method_run: MethodRun, unfilled: bool = False) -> None:
    """Start a method; its task waits for the end.

    With `unfilled`, a part of the method has no value: the method ends badly at once.
    """
    task, method = method_run.task, method_run.plan
    task.run = method_run
    if task.plan.recursive or run.all_may_recur:
        running_goals = run.state.running_goals
        running_goals[task.goal_key] = running_goals.get(task.goal_key, 0) + 1
    task.state = RUNNING
    if task.wait is not None:
        task.wait.timer = None
    if task.method is None:
        task.method = method
    elif task.method is not method:
        task.begin_method(method)
    elif task.history is not None:
        task.history.before = method
    if run.recorder.on and run.recorder.wants(MethodChosen):
        run.recorder.emit(
            MethodChosen,
            task=task.number,
            rap=task.plan.name,
            method=method.name,
            bindings=as_told(method_run.env),
        )
    if (unfilled or method.notations) and not _begins_well(run, method_run, unfilled):
        return
    if method.request is None:
        if method.activation is not None:
            _switch_on(run, method_run, method.activation, unfilled)
        else:
            _release_steps(run, method_run)
        return
    result, because = request(run, method_run, method.request), None
    if result != OKAY and isinstance(result, Refused):
        reason = result.reason
        result = settle_refusal(run, method_run, result)
        because = _of_refusal(run, method_run, result, reason)
    if result is not None:
        end_method(run, method_run, result, because)


def _of_refusal(
    run: Run, method_run: MethodRun, result: str | Refused | None, reason: str
) -> Cause | None:
    """Return why a refused method ends; None if the method goes on or waits."""
    failed = method_run.task.run is method_run and result == INTERFERENCE
    return causes.of_refusal(run, method_run, reason) if failed else None


def _begins_well(run: Run, method_run: MethodRun, unfilled: bool) -> bool:
    """Make notations; return whether the method goes on: otherwise it has failed."""
    method, because = method_run.plan, None
    claimed = not unfilled or can_claim(run, method_run)
    noted = claimed and (not method.notations or _note(run, method_run, method))
    if noted and (not unfilled or method.request is None):
        return True
    if noted and method.request is not None:
        ground(run, method_run, method.request)  # traces the unbound part
    else:
        method_run.steps = ()
        because = causes.of_bad_start(run, method_run)
    end_method(run, method_run, INTERFERENCE, because)
    return False


def _switch_on(
    run: Run, method_run: MethodRun, plan: ActivationPlan, unfilled: bool
) -> None:
    """Switch the skills of a method on; end a method that awaits nothing."""
    result = activate(run, method_run, plan, unfilled)
    because = None
    if result is not None and not isinstance(result, str):
        reason = result.reason
        result = settle_refusal(run, method_run, result)
        because = _of_refusal(run, method_run, result, reason)
    if method_run.task.run is not method_run:
        return
    if result is not None:
        method_run.steps = ()
        end_method(run, method_run, result, because)
    elif plan.background:
        _release_steps(run, method_run)
    elif not plan.waits:
        end_method(run, method_run, OKAY)


def _release_steps(run: Run, method_run: MethodRun) -> None:
    """Add the tasks of steps to the run; release steps that follow no other step."""
    steps, plan = method_run.steps, method_run.plan
    if not steps:
        end_method(run, method_run, OKAY)
        return
    if plan.makes or run.recorder.on:
        for task in steps:
            create(run, task)
    else:
        for number, task in enumerate(steps, run.state.numbers + 1):
            task.number = number
        run.state.numbers = number
    for position in plan.first_steps:
        task = steps[position]
        if task.waiting == 0:
            release(run, task)
        elif task.wait is not None:
            read_windows(run, task)


def _note(run: Run, method_run: MethodRun, method: MethodPlan) -> bool:
    """Assert a method's notations, all or none; return whether this worked [L 6.27]."""
    facts = []
    for plan in method.notations:
        fact = ground(run, method_run, plan)
        if fact is None:
            return False
        try:
            facts.append(run.beliefs.checked(fact))
        except FactError as error:
            run.context.fault(plan.where, str(error))
            return False
    noted = [run.beliefs.note(fact) for fact in facts]
    method_run.notations = tuple(
        [notation for notation in noted if notation is not None]
    )
    return True
