"""Activations: skills that the world switches on and off for methods [S 3; L 9].

Not here: the effects of an activation's signals (`rapc.runtime.tasks.signals`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rapc.base.values import Fact
from rapc.compiler.rap_plan import ActivationPlan
from rapc.events import SkillDisabled, SkillEnabled
from rapc.runtime.run import Run
from rapc.runtime.state.activations import Activation
from rapc.runtime.state.states import INTERFERENCE
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.runtime.tasks.primitives import (
    cancel,
    filled_in,
    ground,
    sensed,
    tell_refusal,
)
from rapc.world import Refused, Skilled


def activate(
    machine: Run, run: MethodRun, plan: ActivationPlan, unfilled: bool = False
) -> str | Refused | None:
    """Switch on all skills of the method `run` at once; none if `unfilled`.

    Return `interference` if a skill cannot be filled in, the refusal of the world if it
    refuses, else None.
    """
    skills, sent, items = [], [], machine.beliefs.items
    for one in plan.skills:
        skill = ground(machine, run, one)
        named = None if skill is None else sensed(items, skill)
        if skill is None or named is None:
            return INTERFERENCE
        skills.append(skill)
        sent.append(named)
    if unfilled:
        return INTERFERENCE
    world = machine.port
    assert isinstance(world, Skilled)  # validated by `rapc.runtime.admission`
    machine.state.tickets += 1
    ticket = machine.state.tickets
    answer = world.activate(ticket, tuple(sent), plan.events)
    machine.sync_clock()
    if answer is not None:
        return tell_refusal(machine, run.task, zip(skills, sent, strict=True), answer)
    run.ticket = ticket
    run.skills = tuple(skills)
    activation = Activation(ticket, run.task.number, run.task, run, tuple(skills))
    machine.state.activations.begin(activation)
    _tell(machine, run.task, SkillEnabled, skills)
    return None


def reactivate(machine: Run, run: MethodRun, wanted: Sequence[int]) -> bool | Refused:
    """Switch the `wanted` skills of a method on, by position, and the others off.

    Skills that stay on are not interrupted. All skills have the arguments of their
    first start. Return True on success; False if an item among the arguments has no
    sensor name now; the refusal if the world refuses. Without success, nothing has
    changed.
    """
    plan, before = run.plan.activation, run.ticket
    assert plan is not None
    skills = [machine.beliefs.canonical(run.skills[at]) for at in wanted]
    named = [sensed(machine.beliefs.items, skill) for skill in skills]
    sent = [one for one in named if one is not None]
    world, tables = machine.port, machine.state.activations
    assert isinstance(world, Skilled)
    if len(sent) < len(skills):
        return False
    run.ticket = None
    if skills:
        machine.state.tickets += 1
        ticket = machine.state.tickets
        answer = world.activate(ticket, tuple(sent), plan.events)
        if answer is not None:
            run.ticket = before
            asked = zip(skills, sent, strict=True)
            return tell_refusal(machine, run.task, asked, answer)
        run.ticket = ticket
    were = tables.on[before].skills if before is not None else ()
    if skills and run.ticket is not None:
        number = run.task.number
        tables.begin(Activation(run.ticket, number, run.task, run, tuple(skills)))
    if before is not None:
        tables.end(before)
        world.deactivate(before)
    were = tuple(map(machine.beliefs.canonical, were))
    _tell(machine, run.task, SkillDisabled, [s for s in were if s not in skills])
    _tell(machine, run.task, SkillEnabled, [s for s in skills if s not in were])
    return True


def _tell(
    machine: Run,
    task: Task,
    kind: type[SkillEnabled | SkillDisabled],
    skills: Iterable[Fact],
) -> None:
    if machine.recorder.on:
        for skill in skills:
            machine.recorder.emit(kind, task=task.number, what=skill)


def activatable(machine: Run, task: Task, plan: ActivationPlan, env: Env) -> bool:
    """Return whether all skills could be switched on now; trace nothing."""
    for one in plan.skills:
        skill = filled_in(machine, task, one, env)
        if skill is None or sensed(machine.beliefs.items, skill) is None:
            return False
    return True


def deactivate(machine: Run, ticket: int) -> None:
    """Switch off the skills that only the active activation `ticket` uses, if any."""
    if ticket not in machine.state.activations.on:
        return
    activation = machine.state.activations.end(ticket)
    if activation.task is not None:
        skills = map(machine.beliefs.canonical, activation.skills)
        _tell(machine, activation.task, SkillDisabled, skills)
    assert isinstance(machine.port, Skilled)
    machine.port.deactivate(ticket)


def call_off(machine: Run, run: MethodRun) -> None:
    """Cancel the request or the skills of a method in the world."""
    if run.ticket is None:
        return
    if run.plan.activation is not None:
        deactivate(machine, run.ticket)
    else:
        cancel(machine, run)
