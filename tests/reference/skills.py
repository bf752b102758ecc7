"""Skills: sets of them that are on for methods of tasks (section 9 of docs/language).

A method knows which of its skills are on; everything else is found anew.
"""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.values import Fact, format_list
from rapc.ir import nodes
from rapc.runtime.events import events
from rapc.world import Skilled
from tests.reference.run import Run
from tests.reference.tasks import Running
from tests.reference.things import Ask, filled, used


def skills_of(method: nodes.Method) -> Sequence[nodes.Skill]:
    """The skills that a method switches on, as its primitive or beside its steps."""
    return (
        method.body.enable if isinstance(method.body, nodes.Skills) else method.skills
    )


def waits_of(running: Running) -> Sequence[nodes.WaitFor]:
    """What a primitive of skills awaits."""
    body = running.method.body
    return body.waits if isinstance(body, nodes.Skills) else ()


def switch_on(run: Run, running: Running) -> bool:
    """Switch on all skills of a method; False, and traced, if one has no value."""
    skills: list[Fact] = []
    for pattern in skills_of(running.method):
        fact = run.ground(running.task, pattern, running.env, "skill")
        if fact is None:
            return False
        skills.append(fact)
    have_on(run, running, skills)
    tell(run, running, events.SkillEnabled, skills)
    return True


def have_on(run: Run, running: Running, skills: Sequence[Fact]) -> None:
    """Have just these skills on for a method, under a ticket of their own."""
    before, running.ticket = running.ticket, None
    world = run.world
    assert isinstance(world, Skilled)
    if skills:
        running.ticket = len(run.tickets) + 1
        run.tickets[running.ticket] = (skills[0], None)
        run.owners[running.ticket] = running.task
        run.switched[running.ticket] = running
        world.activate(running.ticket, tuple(skills), ())
    if before is not None:
        world.deactivate(before)
    running.on = list(skills)


def tell(
    run: Run,
    running: Running,
    kind: type[events.SkillEnabled | events.SkillDisabled],
    skills: Sequence[Fact],
) -> None:
    """Trace that skills are on, or off."""
    for skill in skills:
        run.tell(kind, task=running.task.number, what=format_list(skill))


def switch_off(run: Run, running: Running) -> None:
    """Switch off all that a method has on, for good."""
    tell(run, running, events.SkillDisabled, running.on)
    have_on(run, running, ())
    running.off, running.back = [], []


# --- in part ----------------------------------------------------------------------


def interrupt(run: Run, running: Running, taken: Sequence[Ask]) -> None:
    """Those skills of a method go off that use what is taken from it."""
    gone = {ask.thing for ask in taken} & set(running.uses)
    every = [used_by(run, running, skill) for skill in skills_of(running.method)]
    off = [at for at, uses in enumerate(every) if uses & gone or at in running.off]
    staying = [at for at in range(len(every)) if at not in off]
    before = list(running.on)
    have_on(run, running, [filled_in(run, running, at) for at in staying])
    gone_off = [skill for skill in before if skill not in running.on]
    tell(run, running, events.SkillDisabled, gone_off)
    still = {thing for at in staying for thing in every[at]}
    freed = {thing for at in off for thing in every[at]} - still
    running.back += [Ask(t, True) for t in running.uses if t in freed]
    running.uses = [thing for thing in running.uses if thing not in freed]
    running.off = off


def come_on_again(run: Run, running: Running) -> None:
    """All skills of a method are on again, and it holds again what they use."""
    before = list(running.on)
    every = range(len(skills_of(running.method)))
    have_on(run, running, [filled_in(run, running, at) for at in every])
    come_on = [skill for skill in running.on if skill not in before]
    tell(run, running, events.SkillEnabled, come_on)
    running.uses += [ask.thing for ask in running.back]
    running.off, running.back = [], []


def filled_in(run: Run, running: Running, at: int) -> Fact:
    """A skill of a method that has been switched on before."""
    pattern = skills_of(running.method)[at]
    found = filled(run, running.task, pattern, running.env)
    assert found is not None
    return found


def used_by(run: Run, running: Running, skill: nodes.Skill) -> set[Fact]:
    """What a skill of a method uses."""
    found = used(run, running.task, skill, running.env)
    assert found is not None
    return set(found)
