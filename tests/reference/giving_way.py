"""Who gives way to whom, and what a world refuses beside others [L 8.16, 8.24, 8.28].

Everything is found anew whenever it is asked for.
"""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.values import Fact, format_list
from rapc.ir import nodes
from rapc.world import Refused
from tests.reference.endings import method_badly, suspend, undo
from tests.reference.primitives import request
from tests.reference.run import Run
from tests.reference.skills import come_on_again, interrupt, skills_of, switch_on
from tests.reference.tasks import Running, Task
from tests.reference.things import Ask, filled, giving_way, obstacles, written
from tests.reference.waking import hold_up


def ask_world(run: Run, running: Running) -> bool:
    """Ask for the request or the skills of a method; False if a skill has no value.

    What the world refuses is asked for again if all in conflict with it give way.
    """
    body = running.method.body
    answer: bool | Refused | None = None
    while running.task.running is running:
        if isinstance(body, nodes.Primitive):
            answer = request(run, running, body)
        else:
            answer = switch_on(run, running)
        if not isinstance(answer, Refused):
            break
        conflict(run, running, answer)
    return answer is not False


def give_way(run: Run, task: Task, wanted: Sequence[Ask], said: str = "") -> None:
    """What is lower and uses what a task takes is suspended, or skills of it go off."""
    for other, thing in giving_way(run, task, wanted):
        assert other.running is not None
        if other.running.method.skills:
            interrupt(run, other.running, wanted)
        else:
            on = said if thing in other.running.said else written(thing)
            suspend(run, other, on, task)


def resume_skills(run: Run) -> bool:
    """Skills come on again that nothing is in the way of; whether there were any."""
    found = False
    for task in run.live():
        running = task.running
        while task.running is running and running is not None and running.off:
            if obstacles(run, task, running.back):
                break
            found = True
            said = in_words(run, running)
            give_way(run, task, running.back, said)
            refused = come_on_again(run, running)
            if refused is None:
                break
            thing = shared(run, running, refused)
            if thing is not None:
                running.back.append(Ask(thing, True))
                running.said[thing] = said
    return found


# --- what a world refuses ---------------------------------------------------------


def conflict(run: Run, running: Running, refused: Refused) -> None:
    """Let a method wait for those that a world names, or these give way to it."""
    task, said = running.task, in_words(run, running)
    thing = shared(run, running, refused)
    if thing is None:
        return
    ask = Ask(thing, True)
    blocking = obstacles(run, task, [ask])
    if blocking:
        undo(run, running)
        task.wanted = [[*running.asked, ask]]
        hold_up(run, task, blocking[0])
    else:
        give_way(run, task, [ask], said)
        take(running, thing, said)


def shared(run: Run, running: Running, refused: Refused) -> Fact | None:
    """The thing that those use from now on that a world names as in conflict.

    With none of them, or one of an ancestor, the method ends badly; None.
    """
    named = [other for other in under_way(run, refused) if other is not running]
    line = list(running.task.line())
    if not named or any(other.task in line for other in named):
        method_badly(run, running, "interference", "sibling-failed")
        return None
    run.conflicts += 1
    thing = ("#", run.conflicts)
    for other in named:
        take(other, thing, in_words(run, other))
    return thing


def under_way(run: Run, refused: Refused) -> list[Running]:
    """The methods whose requests or skills a world names, as they stand now."""
    found = []
    for task in run.live():
        asked = [n for n, (_, asker) in run.tickets.items() if asker is task]
        running = task.running
        if running is not None and running.ticket is not None:
            asked.append(running.ticket)
        if running is not None and set(asked) & set(refused.conflicts):
            found.append(running)
    return found


def take(running: Running, thing: Fact, said: str) -> None:
    """A method uses one thing more, which has no name."""
    running.uses.append(thing)
    running.asked.append(Ask(thing, True))
    running.said[thing] = said


def in_words(run: Run, running: Running) -> str:
    """What a method asks of the world."""
    if running.skills:
        return " ".join(map(format_list, running.skills))
    body = running.method.body
    asked: list[nodes.Pattern] = [*skills_of(running.method)]
    if isinstance(body, nodes.Primitive):
        asked = [body.request]
    every = [filled(run, running.task, one, running.env) for one in asked]
    return " ".join(format_list(one) for one in every if one is not None)
