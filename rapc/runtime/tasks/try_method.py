"""A task tries a method: from the choice to the method's start [L 3].

Not here: the choice of the method (`rapc.runtime.tasks.choose`) and the ends of methods
(`rapc.runtime.tasks.finish`).
"""

from __future__ import annotations

from rapc.compiler.rap_plan import ActivationPlan, MethodPlan
from rapc.errors import FactError
from rapc.events import Cause, MethodChosen
from rapc.runtime.run import Run
from rapc.runtime.state.states import FUTILE_LOOP, INTERFERENCE, NO_METHOD, RUNNING
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


def try_method(machine: Run, task: Task) -> None:
    """Do steps 5 to 9: choose and start a method, or fail."""
    choice = choose(machine, task)
    if choice is None:
        fail(machine, task, NO_METHOD, causes.of_no_method(machine, task))
        return
    method, found, others = choice
    env = task.env
    key = choice_key(method, env, found) if env or found else method.key
    if task.choice is None:
        task.choice = key
    elif not _note_choice(machine, task, key):
        because = causes.of_futile_choice(machine, task, method, found)
        fail(machine, task, FUTILE_LOOP, because)
        return
    if found:
        env = {**env, **found}
    elif method.binds:
        env = env.copy()
    run = MethodRun(task, method, env, machine.recorder.time)
    if method.steps:
        repeating = _spawn(machine, run)
        if repeating is not None:
            fail(machine, task, FUTILE_LOOP, causes.of_recursion(machine, repeating))
            return
    unfilled = False
    if method.things:
        come = hold_or_wait(machine, run, others)
        if come is WAITS:
            return
        unfilled = come is UNFILLED
    start_method(machine, run, unfilled)


def _note_choice(machine: Run, task: Task, key: Key) -> bool:
    """Record a choice after the first; return False for a futile choice."""
    settings = machine.settings
    if task.times_chosen(key, settings.max_choices) >= settings.futile_limit:
        return False
    task.note_choice(key)
    return True


def _spawn(machine: Run, run: MethodRun) -> Task | None:
    """Make the steps' tasks without numbers; return a task that repeats an ancestor."""
    run.steps = tasks = []
    method = run.plan
    if not method.raps:
        _look_up(machine, method)
    for step, rap in zip(method.steps, method.raps, strict=True):
        task = Task(rap, run, step)
        tasks.append(task)
        if rap.inputs:
            read_inputs(machine, task)
        if (
            (task.identity is None or machine.all_may_recur)
            and task.bound
            and repeats_ancestor(machine, task)
        ):
            return task
    return None


def _look_up(machine: Run, method: MethodPlan) -> None:
    """Find the RAPs of a method's steps, once for all runs."""
    names = [step.node.goal.name for step in method.steps]
    method.raps = raps = tuple([machine.library.known_rap(name) for name in names])
    method.makes = method.computes or any(rap.needs_setup for rap in raps)


def start_method(machine: Run, run: MethodRun, unfilled: bool) -> None:
    """Start the method of `run`; the task of the method waits for the end.

    With `unfilled`, a part of the method has no value: the method ends badly at once.
    """
    task, method = run.task, run.plan
    task.run = run
    if task.plan.recursive or machine.all_may_recur:
        active_identities = machine.state.active_identities
        active_identities[task.identity] = active_identities.get(task.identity, 0) + 1
    task.state = RUNNING
    if task.wait is not None:
        task.wait.timer = None
    if task.method is None:
        task.method = method
    elif task.method is not method:
        task.begin_method(method)
    elif task.history is not None:
        task.history.before = method
    if machine.recorder.on and machine.recorder.wants(MethodChosen):
        machine.recorder.emit(
            MethodChosen,
            task=task.number,
            rap=task.plan.name,
            method=method.name,
            bindings=as_told(run.env),
        )
    if (unfilled or method.notations) and not _begins_well(machine, run, unfilled):
        return
    if method.request is None:
        if method.activation is not None:
            _switch_on(machine, run, method.activation, unfilled)
        else:
            _release_steps(machine, run)
        return
    result, because = request(machine, run, method.request), None
    if result != OKAY and isinstance(result, Refused):
        result = settle_refusal(machine, run, result)
        because = _of_refusal(machine, run, result)
    if result is not None:
        end_method(machine, run, result, because)


def _of_refusal(
    machine: Run, run: MethodRun, result: str | Refused | None
) -> Cause | None:
    """Return why a refused method ends; None if the method goes on or waits."""
    failed = run.task.run is run and result == INTERFERENCE
    return causes.of_refusal(machine, run) if failed else None


def _begins_well(machine: Run, run: MethodRun, unfilled: bool) -> bool:
    """Make notations; return whether the method goes on: otherwise it has failed."""
    method, because = run.plan, None
    claimed = not unfilled or can_claim(machine, run)
    noted = claimed and (not method.notations or _note(machine, run, method))
    if noted and (not unfilled or method.request is None):
        return True
    if noted and method.request is not None:
        ground(machine, run, method.request)  # traces the unbound part
    else:
        run.steps = ()
        because = causes.of_bad_start(machine, run)
    end_method(machine, run, INTERFERENCE, because)
    return False


def _switch_on(
    machine: Run, run: MethodRun, plan: ActivationPlan, unfilled: bool
) -> None:
    """Switch the skills of a method on; end a method that awaits nothing."""
    result = activate(machine, run, plan, unfilled)
    because = None
    if result is not None and not isinstance(result, str):
        result = settle_refusal(machine, run, result)
        because = _of_refusal(machine, run, result)
    if run.task.run is not run:
        return
    if result is not None:
        run.steps = ()
        end_method(machine, run, result, because)
    elif plan.background:
        _release_steps(machine, run)
    elif not plan.waits:
        end_method(machine, run, OKAY)


def _release_steps(machine: Run, run: MethodRun) -> None:
    """Add the tasks of steps to the run; release steps that follow no other step."""
    steps, plan = run.steps, run.plan
    if plan.makes or machine.recorder.on:
        for task in steps:
            create(machine, task)
    else:
        number = machine.state.numbers
        for task in steps:
            number += 1
            task.number = number
        machine.state.numbers = number
    for position in plan.first_steps:
        task = steps[position]
        if task.wait is not None:
            read_windows(machine, task)
        if task.waiting == 0:
            release(machine, task)
    if not steps:
        end_method(machine, run, OKAY)


def _note(machine: Run, run: MethodRun, method: MethodPlan) -> bool:
    """Assert a method's notations, all or none; return whether this worked [L 6.27]."""
    facts = []
    for plan in method.notations:
        fact = ground(machine, run, plan)
        if fact is None:
            return False
        try:
            facts.append(machine.beliefs.checked(fact))
        except FactError as error:
            machine.context.fault(plan.where, str(error))
            return False
    noted = [machine.beliefs.note(fact) for fact in facts]
    run.notations = tuple([notation for notation in noted if notation is not None])
    return True
