"""Activations: skills that the world switches on and off for methods [S 3; L 9].

Not here: the effects of an activation's signals (`rapc.runtime.tasks.signals`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rapc.base.values import Fact
from rapc.compiler.rap_plan import ActivationPlan
from rapc.events import SkillDisabled, SkillEnabled
from rapc.language.results import INTERFERENCE
from rapc.runtime.run import Run
from rapc.runtime.state.activations import Activation
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.runtime.tasks.primitives import (
    cancel,
    filled_in,
    ground,
    tell_refusal,
)
from rapc.world import Refused, Skilled


def activate(
    run: Run, method_run: MethodRun, plan: ActivationPlan, unfilled: bool = False
) -> str | Refused | None:
    """Switch on all skills of a method at once; none if `unfilled`.

    Return `interference` if a skill cannot be filled in, the refusal of the world if it
    refuses, else None.
    """
    skills, sent, items = [], [], run.beliefs.items
    for one in plan.skills:
        skill = ground(run, method_run, one)
        named = None if skill is None else items.sensed(skill)
        if skill is None or named is None:
            return INTERFERENCE
        skills.append(skill)
        sent.append(named)
    if unfilled:
        return INTERFERENCE
    world = run.port
    assert isinstance(world, Skilled)  # validated by `rapc.runtime.admission`
    run.state.tickets += 1
    ticket = run.state.tickets
    answer = world.activate(ticket, tuple(sent), plan.events)
    run.sync_clock()
    if answer is not None:
        return tell_refusal(
            run, method_run.task, zip(skills, sent, strict=True), answer
        )
    method_run.ticket = ticket
    method_run.skills = tuple(skills)
    activation = Activation(
        ticket, method_run.task.number, method_run.task, method_run, tuple(skills)
    )
    run.state.activations.begin(activation)
    _tell_enabled(run, method_run.task, skills, plan)
    return None


def reactivate(
    run: Run, method_run: MethodRun, wanted: Sequence[int]
) -> bool | Refused:
    """Switch the `wanted` skills of a method on, by position, and the others off.

    Skills that stay on are not interrupted. All skills have the arguments of their
    first start. Return True on success; False if an item among the arguments has no
    sensor name now; the refusal if the world refuses. Without success, nothing has
    changed.
    """
    plan, before = method_run.plan.activation, method_run.ticket
    assert plan is not None
    skills = [run.beliefs.canonical(method_run.skills[at]) for at in wanted]
    named = [run.beliefs.items.sensed(skill) for skill in skills]
    sent = [one for one in named if one is not None]
    world, tables = run.port, run.state.activations
    assert isinstance(world, Skilled)
    if len(sent) < len(skills):
        return False
    method_run.ticket = None
    if skills:
        run.state.tickets += 1
        ticket = run.state.tickets
        answer = world.activate(ticket, tuple(sent), plan.events)
        if answer is not None:
            method_run.ticket = before
            asked = zip(skills, sent, strict=True)
            return tell_refusal(run, method_run.task, asked, answer)
        method_run.ticket = ticket
    were = tables.on[before].skills if before is not None else ()
    if skills and method_run.ticket is not None:
        number = method_run.task.number
        tables.begin(
            Activation(
                method_run.ticket, number, method_run.task, method_run, tuple(skills)
            )
        )
    if before is not None:
        tables.end(before)
        world.deactivate(before)
    were = tuple(map(run.beliefs.canonical, were))
    task = method_run.task
    _tell_disabled(run, task, [skill for skill in were if skill not in skills])
    _tell_enabled(run, task, [skill for skill in skills if skill not in were], plan)
    return True


def _tell_enabled(
    run: Run, task: Task, skills: Iterable[Fact], plan: ActivationPlan
) -> None:
    if run.recorder.on:
        for skill in skills:
            run.recorder.emit(
                SkillEnabled,
                task=task.number,
                what=skill,
                background=plan.background,
            )


def _tell_disabled(run: Run, task: Task, skills: Iterable[Fact]) -> None:
    if run.recorder.on:
        for skill in skills:
            run.recorder.emit(SkillDisabled, task=task.number, what=skill)


def activatable(run: Run, task: Task, plan: ActivationPlan, env: Env) -> bool:
    """Return whether all skills could be switched on now; trace nothing."""
    for one in plan.skills:
        skill = filled_in(run, task, one, env)
        if skill is None or run.beliefs.items.sensed(skill) is None:
            return False
    return True


def deactivate(run: Run, ticket: int) -> None:
    """Switch off the skills that only the active activation `ticket` uses, if any."""
    if ticket not in run.state.activations.on:
        return
    activation = run.state.activations.end(ticket)
    if activation.task is not None:
        skills = map(run.beliefs.canonical, activation.skills)
        _tell_disabled(run, activation.task, skills)
    assert isinstance(run.port, Skilled)
    run.port.deactivate(ticket)


def call_off(run: Run, method_run: MethodRun) -> None:
    """Cancel the request or the skills of a method in the world."""
    if method_run.ticket is None:
        return
    if method_run.plan.activation is not None:
        deactivate(run, method_run.ticket)
    else:
        cancel(run, method_run)
