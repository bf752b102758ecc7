"""Operations of tasks on things: request, hold, wait and suspend [L 8].

A method requests all its things at once before it starts. If a thing is blocked, the
choice is undone and the task is blocked. Otherwise the interpreter suspends lower
methods whose requests use one of the things.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from rapc.base.values import format_list
from rapc.compiler.rap_plan import MethodPlan
from rapc.events import MethodSuspended
from rapc.language.results import INTERFERENCE
from rapc.runtime.run import Run
from rapc.runtime.state.states import BLOCKED
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.runtime.state.things import Ask, Hold, Thing, ThingWait, format_thing, words
from rapc.runtime.tasks.activations import (
    activatable,
    activate,
    call_off,
    reactivate,
)
from rapc.runtime.tasks.causes import of_refusal
from rapc.runtime.tasks.finish import end_method
from rapc.runtime.tasks.primitives import filled_in, ground, request, sendable
from rapc.runtime.tasks.remove import stop
from rapc.world import Refused

HOLDS: Final = "holds"
WAITS: Final = "waits"
UNFILLED: Final = "unfilled"
"""The result of a request for things."""

Asks = tuple[Ask, ...]


def asks_of(run: Run, task: Task, method: MethodPlan, env: Env) -> Asks | None:
    """Return the things that a method of `task` requests, with the bindings `env`.

    None if a thing or the request cannot be filled in: then the method requests
    nothing, starts and ends badly.
    """
    request, skills = method.request, method.activation
    if request is not None and sendable(run, task, request, env) is None:
        return None
    if skills is not None and not activatable(run, task, skills, env):
        return None
    found: dict[Thing, Ask] = {}
    for asked in method.things:
        thing = filled_in(run, task, asked.plan, env)
        if thing is None:
            return None
        thing = run.beliefs.canonical(thing)
        if thing not in found:
            found[thing] = run.things.ask(task, thing, asked.used)
    return tuple(found.values())


def must_wait(run: Run, task: Task, method: MethodPlan, found: Env) -> bool:
    """Return whether a method would have to wait; `found` are its choice's bindings."""
    if not method.things:
        return False
    asks = asks_of(run, task, method, {**task.env, **found})
    return asks is not None and run.things.obstacle(task, asks) is not None


def hold_or_wait(
    run: Run, method_run: MethodRun, others: Sequence[tuple[MethodPlan, Env]]
) -> str:
    """Let a method hold its things before its start, or block its task.

    Args:
        run: the run.
        method_run: the method.
        others: all choices for whose things the task may wait, each with its bindings.

    Return `HOLDS`, `WAITS`, or `UNFILLED` for a method that is to start and end badly.
    """
    task, method = method_run.task, method_run.plan
    asks = asks_of(run, task, method, method_run.env)
    if asks is None:
        return UNFILLED
    obstacle = run.things.obstacle(task, asks)
    if obstacle is None:
        give_way(run, task, asks)
        run.things.take(method_run, asks)
        return HOLDS
    alternatives = {asks: None}
    for other, found in others:
        env = {**task.env, **found}
        alternatives[asks_of(run, task, other, env) or ()] = None
    task.forget_choice()
    _block(run, task, tuple(alternatives), obstacle)
    return WAITS


def can_claim(run: Run, method_run: MethodRun) -> bool:
    """Return whether all claims of a method can be filled in; trace the others."""
    claims = [asked.plan for asked in method_run.plan.things if not asked.used]
    return all(ground(run, method_run, plan) is not None for plan in claims)


def give_way(run: Run, task: Task, asks: Asks, said: str = "") -> None:
    """Suspend the lower methods whose requests use things of `task`, by number.

    For background skills, only the `skills` that use these things go off, and the
    method goes on. `said` is the text for a thing without a name.
    """
    lower: dict[int, tuple[MethodRun, str]] = {}
    for ask in asks:
        for hold in run.things.lower_users(task, ask):
            on = said if hold.said else format_thing(ask.thing)
            lower.setdefault(hold.run.task.number, (hold.run, on))
    for number in sorted(lower):
        method_run, on = lower[number]
        if (
            method_run.plan.activation is not None
            and method_run.plan.activation.background
        ):
            _interrupt_skills(run, method_run, asks, on, task.number)
        else:
            _suspend(run, method_run, on, task.number)


def _suspend(run: Run, method_run: MethodRun, on: str, by: int) -> None:
    """Undo a method with a request under way, as if never chosen."""
    task = method_run.task
    asks = tuple([hold.ask for hold in run.things.held[task.number]])
    call_off(run, method_run)
    _undo(run, method_run)
    if run.recorder.on:
        run.recorder.emit(
            MethodSuspended,
            task=task.number,
            method=method_run.plan.name,
            for_=on,
            by=by,
        )
    _wait(run, ThingWait(task, (asks,), on, by))


def _undo(run: Run, method_run: MethodRun) -> None:
    """Undo a method without steps, as if never chosen."""
    task = method_run.task
    stop(run, task)
    for notation in method_run.notations:
        run.beliefs.release_notation(notation)
    run.things.release(task)
    task.forget_choice()
    task.forget_method()


def _block(
    run: Run, task: Task, alternatives: tuple[Asks, ...], obstacle: Hold
) -> None:
    """Block a task until an alternative is free; report the block."""
    on, holder = words(obstacle), obstacle.run.task.number
    wait = ThingWait(task, alternatives, on, holder)
    _wait(run, wait)
    run.monitors.tell_blocked(wait)


def _wait(run: Run, wait: ThingWait) -> None:
    wait.task.state = BLOCKED
    if wait.task.wait is not None:
        wait.task.wait.timer = None
    run.things.wait(wait)


# --- skills of a method that goes on ----------------------------------------------


def _interrupt_skills(
    run: Run, method_run: MethodRun, taken: Asks, on: str, by: int
) -> None:
    """Switch off the `skills` that use the `taken` things, until the things are free.

    A conflict that only the world reports concerns all skills of the method.
    """
    task, things = method_run.task, run.things
    held = [hold.ask for hold in things.held[task.number]]
    gone = {ask.thing for ask in taken} & {ask.thing for ask in held if ask.used}
    uses = _used_by_skills(run, method_run)
    nameless = gone - set().union(*uses)
    before = things.waits.get(task.number)
    off = set(before.skills if before is not None else ())
    off |= {at for at, used in enumerate(uses) if used & gone or nameless}
    staying = [at for at in range(len(uses)) if at not in off]
    if reactivate(run, method_run, staying) is not True:
        off = set(range(len(uses)))
        reactivate(run, method_run, ())
    still = set().union(*[used for at, used in enumerate(uses) if at not in off])
    needed = {*gone, *set().union(*[uses[at] for at in off])} - still
    asks = [ask for ask in held if ask.used and ask.thing in needed]
    if before is not None:
        asks += before.alternatives[0]
        things.stop_waiting(task)
    things.hold_just(method_run, _without(run, method_run, held, needed))
    wait = ThingWait(task, (tuple(asks),), on, by)
    wait.skills = tuple(sorted(off))
    things.wait(wait)


def _without(
    run: Run, method_run: MethodRun, held: Iterable[Ask], freed: set[Thing]
) -> Iterator[Ask]:
    """Yield the things that a method keeps: those in `freed` only if claimed."""
    claimed = [
        filled_in(run, method_run.task, one.plan, method_run.env)
        for one in method_run.plan.things
        if not one.used
    ]
    names = {run.beliefs.canonical(one) for one in claimed if one is not None}
    for ask in held:
        if not ask.used or ask.thing not in freed:
            yield ask
        elif ask.thing in names:
            yield ask._replace(used=False)


def _used_by_skills(run: Run, method_run: MethodRun) -> list[set[Thing]]:
    """Return the things that each skill of a method uses."""
    plan = method_run.plan.activation
    assert plan is not None
    found = []
    for uses, skill in zip(plan.uses, method_run.skills, strict=True):
        given = dict(zip(uses.args, run.beliefs.canonical(skill)[1:], strict=True))
        things = [filled_in(run, method_run.task, one, given) for one in uses.things]
        known = [thing for thing in things if thing is not None]
        found.append({run.beliefs.canonical(thing) for thing in known})
    return found


def resume_skills(run: Run) -> None:
    """Switch suspended skills of methods on again if their things are free."""
    things = run.things
    for number in sorted(things.resumable):
        task = things.resumable.pop(number, None)
        wait = things.waits.get(number)
        method_run = None if task is None else task.run
        if task is None or method_run is None or wait is None:
            continue
        _resume(run, method_run, wait)


def _resume(run: Run, method_run: MethodRun, wait: ThingWait) -> None:
    """Switch all skills of a method on again, if their things are free.

    If the world refuses and names others, the method waits for these others as well. If
    the world names no method that is under way, or an ancestor's method, the method
    ends badly.
    """
    task, things, said = method_run.task, run.things, _said(run, method_run)
    plan, asks = method_run.plan.activation, wait.alternatives[0]
    assert plan is not None
    while things.obstacle(task, asks) is None:
        give_way(run, task, asks, said)
        done = reactivate(run, method_run, range(len(plan.skills)))
        if not isinstance(done, Refused):
            if done:
                _hold_again(run, method_run, asks, said)
            return
        shared = _share(run, method_run, done)
        if shared is None:
            because = of_refusal(run, method_run, done.reason)
            end_method(run, method_run, INTERFERENCE, because)
            return
        asks = (*asks, shared)
        later = ThingWait(task, (asks,), wait.on, wait.holder)
        later.skills = wait.skills
        things.stop_waiting(task)
        things.wait(later)


def _hold_again(run: Run, method_run: MethodRun, asks: Asks, said: str) -> None:
    """Hold the awaited things for a method with all skills on again."""
    things = run.things
    things.stop_waiting(method_run.task)
    again = {ask.thing for ask in asks}
    held = [hold.ask for hold in things.held.get(method_run.task.number, ())]
    kept = [ask for ask in held if ask.thing not in again]
    things.hold_just(method_run, (*asks, *kept), said)


# --- refusals of a world ----------------------------------------------------------


def settle_refusal(run: Run, method_run: MethodRun, reply: Refused) -> str | None:
    """Wait for the methods that a world names as in conflict, or repeat the request.

    Return the result of `request` or `activate`: `interference` if the world names no
    method that is under way, or an ancestor's method. The conflict is treated like a
    thing that all these requests use until they end.
    """
    task, things = method_run.task, run.things
    answer: str | Refused | None = reply
    while isinstance(answer, Refused):
        if task.run is not method_run:
            return None
        ask = _share(run, method_run, answer)
        if ask is None:
            return INTERFERENCE
        obstacle = things.obstacle(task, (ask,))
        if obstacle is not None:
            held = tuple([hold.ask for hold in things.held.get(task.number, ())])
            _undo(run, method_run)
            _block(run, task, ((*held, ask),), obstacle)
            return None
        said = _said(run, method_run)
        give_way(run, task, (ask,), said)
        things.take(method_run, (ask,), said)
        answer = _ask_again(run, method_run)
    return answer


def _share(run: Run, method_run: MethodRun, refused: Refused) -> Ask | None:
    """Let the methods that a world names as in conflict share a new thing.

    Return the request of `method_run` for the thing; None if the world names no method
    that is under way, or an ancestor's method.
    """
    task, things = method_run.task, run.things
    named = [other for other in _under_way(run, refused) if other is not method_run]
    if not named or any(_is_above(other.task, task) for other in named):
        return None
    thing = things.conflict()
    for other in named:
        ask = Ask(thing, other.task.priority, True)
        things.take(other, (ask,), _said(run, other))
    return Ask(thing, task.priority, True)


def _is_above(other: Task, task: Task) -> bool:
    """Return whether `other` is an ancestor: then `task` cannot wait for `other`."""
    above = task.parent
    while above is not None and above is not other:
        above = above.parent
    return above is other


def _said(run: Run, method_run: MethodRun) -> str:
    """Return the request or the skills of a method as text."""
    plan, env = method_run.plan, method_run.env
    if method_run.skills:
        return " ".join(
            [format_list(run.beliefs.canonical(s)) for s in method_run.skills]
        )
    asked = [plan.request] if plan.request is not None else []
    if plan.activation is not None:
        asked += plan.activation.skills
    found = [filled_in(run, method_run.task, one, env) or one.bare for one in asked]
    return " ".join(map(format_list, found))


def _ask_again(run: Run, method_run: MethodRun) -> str | Refused | None:
    plan = method_run.plan
    if plan.activation is not None:
        return activate(run, method_run, plan.activation)
    assert plan.request is not None
    return request(run, method_run, plan.request)


def _under_way(run: Run, refused: Refused) -> list[MethodRun]:
    """Return the methods whose requests or skills a world names, by task number."""
    found = {}
    for ticket in refused.conflicts:
        task = run.state.pending.get(ticket, (None, ()))[0]
        activation = run.state.activations.on.get(ticket)
        if activation is not None:
            task = activation.task
        if task is not None and task.run is not None:
            found[task.number] = task.run
    return [found[number] for number in sorted(found)]
