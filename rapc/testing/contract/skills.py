"""The part of the port's contract for skills.

Skills are switched on and off at random. The arguments are those that the author of a
`SkillWorld` has declared, and now and then others.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rapc.runtime.held_world import HeldWorld
from rapc.testing.contract.driver import Driver
from rapc.world import Message, Savable, Skilled, Time

ACTIVATIONS = 12
"""The number of activations under one seed."""

_SAVED = 3
"""The interval, in activations, at which the world is saved."""

_STEPS = 5
"""The number of time units between two changes of activations."""


def try_skills(driver: Driver, copy: HeldWorld) -> Iterator[str]:
    """Switch skills on and off; a skill that is off must send nothing.

    A world that can be saved is saved with skills on, and must continue alike.

    Args:
        driver: the driver, in a new world.
        copy: a second world, made like the first.

    Yields:
        The errors, as lines.
    """
    world, on = driver.world, set[int]()
    assert isinstance(world, Skilled)
    for ticket in range(1, ACTIVATIONS + 1):
        skills, events = driver.activation()
        answer = world.activate(ticket, skills, events)
        if answer is None:
            on.add(ticket)
        elif not set(answer.conflicts) <= on:
            said = "refuses skills because of an activation that is not on"
            yield f"{driver.world.breach('activate', said)}"
        _let_live(driver, on)
        if ticket % _SAVED == 0:
            yield from _saved(driver, copy, on)
        if ticket % 2 and on:
            world.deactivate(min(on))
            on.remove(min(on))
            _let_live(driver, on)
    for ticket in on:
        world.deactivate(ticket)
    world.deactivate(10**6)
    _let_live(driver, ())


def _saved(driver: Driver, copy: HeldWorld, on: Collection[int]) -> Iterator[str]:
    """Save the world; yield where a restored world continues differently."""
    world = driver.world
    if not (isinstance(world, Savable) and isinstance(copy, Savable)):
        return
    copy.restore(world.save())
    for _ in range(_STEPS):
        seen = [_goes_on(one) for one in (world, copy)]
        driver.hold(seen[0][1], on)
        if seen[0] != seen[1] or world.save() != copy.save():
            said = "continues differently from the saved world, with skills on"
            yield f"{world.breach('restore', said)}"
            return


def _goes_on(world: HeldWorld) -> tuple[Time, list[Message]]:
    """Advance by a time unit; return the time, and the messages sent."""
    if world.ended() is None:
        world.advance(world.now() + 1)
    return world.now(), list(world.messages())


def _let_live(driver: Driver, on: Collection[int]) -> None:
    """Advance for some time; validate that only skills that are on send anything."""
    driver.hold(driver.world.messages(), on)
    for _ in range(_STEPS):
        _, sent = _goes_on(driver.world)
        driver.hold(sent, on)
