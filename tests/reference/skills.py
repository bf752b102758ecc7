"""Skills: sets of them that are on for methods of tasks (section 9 of docs/language).

A method knows which of its skills are on; everything else is found anew.
"""

from __future__ import annotations

from collections.abc import Sequence

from rapc import events
from rapc.base.values import Fact, format_list
from rapc.ir import nodes
from rapc.world import Refused, Skilled
from tests.reference.run import Run
from tests.reference.tasks import Running
from tests.reference.things import Ask, used_once_filled


def skills_of(method: nodes.Method) -> Sequence[nodes.Skill]:
    """The skills that a method switches on, as its primitive or beside its steps."""
    return (
        method.body.enable if isinstance(method.body, nodes.Skills) else method.skills
    )


def waits_of(running: Running) -> Sequence[nodes.WaitFor]:
    """What a primitive of skills awaits."""
    body = running.method.body
    return body.waits if isinstance(body, nodes.Skills) else ()


def switch_on(run: Run, running: Running) -> bool | Refused:
    """Switch on all skills of a method; False, and traced, if one has no value.

    What the world says is returned if it will not have them on beside others.
    """
    skills: list[Fact] = []
    for pattern in skills_of(running.method):
        fact = run.ground(running.task, pattern, running.env, "skill")
        if fact is None:
            return False
        skills.append(fact)
    refused = have_on(run, running, skills)
    if refused is not None:
        return refused
    running.skills = skills
    tell(run, running, events.SkillEnabled, skills)
    return True


def have_on(run: Run, running: Running, skills: Sequence[Fact]) -> Refused | None:
    """Have just these skills on for a method, under a ticket of their own.

    Nothing has changed if the world refuses; what it says is returned.
    """
    before, ticket, world = running.ticket, None, run.world
    assert isinstance(world, Skilled)
    if skills:
        ticket = len(run.tickets) + 1
        run.tickets[ticket] = (skills[0], None)
        run.owners[ticket] = running.task
        refused = world.activate(ticket, tuple(skills), ())
        if refused is not None:
            for text in map(format_list, skills):
                number = running.task.number
                run.tell(events.RequestRefused, task=number, request=text, sent=text)
            return refused
        run.switched[ticket] = running
    running.ticket = ticket
    if before is not None:
        world.deactivate(before)
    running.on = list(skills)
    return None


def tell(
    run: Run,
    running: Running,
    kind: type[events.SkillEnabled | events.SkillDisabled],
    skills: Sequence[Fact],
) -> None:
    """Trace that skills are on, or off."""
    waits = isinstance(running.method.body, nodes.Skills)
    more = {} if waits or kind is events.SkillDisabled else {"background": True}
    for skill in skills:
        run.tell(kind, task=running.task.number, what=format_list(skill), **more)


def switch_off(run: Run, running: Running) -> None:
    """Switch off all that a method has on, for good."""
    tell(run, running, events.SkillDisabled, running.on)
    have_on(run, running, ())
    running.off, running.back = [], []


# --- in part ----------------------------------------------------------------------


def interrupt(run: Run, running: Running, taken: Sequence[Ask]) -> None:
    """Those skills of a method go off that use what is taken from it."""
    gone = {ask.thing for ask in taken} & set(running.uses)
    nameless = gone & set(running.said)
    every = [used_by(run, running, skill) for skill in running.skills]
    before_off = running.off
    off = [
        at
        for at, uses in enumerate(every)
        if uses & gone or nameless or at in before_off
    ]
    staying = [at for at in range(len(every)) if at not in off]
    before = list(running.on)
    refused = have_on(run, running, [running.skills[at] for at in staying])
    assert refused is None
    gone_off = [skill for skill in before if skill not in running.on]
    tell(run, running, events.SkillDisabled, gone_off)
    still = {thing for at in staying for thing in every[at]}
    freed = ({thing for at in off for thing in every[at]} - still) | nameless
    running.back += [Ask(t, True) for t in running.uses if t in freed]
    running.uses = [thing for thing in running.uses if thing not in freed]
    running.off = off


def come_on_again(run: Run, running: Running) -> Refused | None:
    """All skills of a method are on again, and it holds again what they use.

    Nothing has changed if the world refuses; what it says is returned.
    """
    before = list(running.on)
    refused = have_on(run, running, running.skills)
    if refused is not None:
        return refused
    come_on = [skill for skill in running.on if skill not in before]
    tell(run, running, events.SkillEnabled, come_on)
    running.uses += [ask.thing for ask in running.back]
    running.off, running.back = [], []
    return None


def used_by(run: Run, running: Running, skill: Fact) -> set[Fact]:
    """What a skill of a method uses."""
    found = used_once_filled(run, running.task, skill)
    assert found is not None
    return set(found)
