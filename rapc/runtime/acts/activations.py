"""Activations: skills that the world switches on and off for methods [S 3; L 9].

What a signal of one does to the run is for `rapc.runtime.tasks.signals`.
"""

from __future__ import annotations

from rapc.base.values import Fact
from rapc.compiler.activation import ActivationPlan
from rapc.runtime.acts.primitives import cancel, filled_in, ground, sensed
from rapc.runtime.authors import is_refusal, wrong
from rapc.runtime.events.events import RequestRefused, SkillDisabled, SkillEnabled
from rapc.runtime.machine import Machine
from rapc.runtime.state.activations import Activation
from rapc.runtime.state.states import INTERFERENCE
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.world import Refused, Skilled


def activate(
    machine: Machine, run: MethodRun, plan: ActivationPlan, spoilt: bool = False
) -> str | Refused | None:
    """Switch on all skills of the method `run` at once; none if they are `spoilt`.

    Returns `interference` where one of them cannot be filled in, what the world has
    said if it refuses, else None.
    """
    skills, sent = [], []
    for one in plan.skills:
        skill = ground(machine, run, one)
        named = None if skill is None else sensed(machine.memory.items, skill)
        if skill is None or named is None:
            return INTERFERENCE
        skills.append(skill)
        sent.append(named)
    if spoilt:
        return INTERFERENCE
    world = machine.world
    assert isinstance(world, Skilled)  # admission has looked
    machine.state.tickets += 1
    ticket = machine.state.tickets
    answer = world.activate(ticket, tuple(sent), plan.events)
    machine.sync_clock()
    if answer is not None:
        return _refused(machine, run.task, skills, sent, answer)
    run.ticket = ticket
    activation = Activation(ticket, run.task, run, tuple(skills))
    machine.state.activations.begin(activation)
    if machine.recorder.on:
        for skill in skills:
            machine.recorder.emit(SkillEnabled, task=run.task.number, what=skill)
    return None


def _refused(
    machine: Machine, task: Task, skills: list[Fact], sent: list[Fact], answer: object
) -> Refused:
    """Tell that the world has refused an activation; return what it said."""
    if not is_refusal(answer):
        what = "the answer to an activation"
        raise wrong(machine.world, "activate", what, answer)
    if machine.recorder.on:
        for skill, named in zip(skills, sent, strict=True):
            machine.recorder.emit(
                RequestRefused, task=task.number, request=skill, sent=named
            )
    return answer


def activatable(machine: Machine, task: Task, plan: ActivationPlan, env: Env) -> bool:
    """Whether all skills could be switched on now; nothing is traced."""
    for one in plan.skills:
        skill = filled_in(machine, task, one, env)
        if skill is None or sensed(machine.memory.items, skill) is None:
            return False
    return True


def deactivate(machine: Machine, ticket: int) -> None:
    """Switch off what only the activation `ticket` has, if it is on."""
    if ticket not in machine.state.activations.on:
        return
    activation = machine.state.activations.end(ticket)
    if machine.recorder.on and activation.task is not None:
        for skill in activation.skills:
            machine.recorder.emit(
                SkillDisabled,
                task=activation.task.number,
                what=machine.memory.canonical(skill),
            )
    assert isinstance(machine.world, Skilled)
    machine.world.deactivate(ticket)


def call_off(machine: Machine, run: MethodRun) -> None:
    """End what a method has under way in the world: its request, its skills."""
    if run.ticket is None:
        return
    if run.plan.activation is not None:
        deactivate(machine, run.ticket)
    else:
        cancel(machine, run)
