"""What a host may know of a simulator: its figures, and which beliefs are wrong.

Neither is known to the robot.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from rapc.base.values import Fact, is_number
from rapc.library.signatures import Signatures
from rapc.runtime.held_world import HeldWorld
from rapc.runtime.memory.facts import NEVER
from rapc.runtime.memory.memory import Memory
from rapc.world import Measured, Time, Truth, World

WRONG_BELIEFS = "wrong-beliefs"
"""The figure that counts the wrong beliefs, of a world that is a `Truth`."""


class WrongBelief(NamedTuple):
    """A believed fact that is not true."""

    fact: Fact
    #: The time of its last assertion; None if nobody asserted it.
    since: Time | None
    #: The true facts with the same index, if the fact is that of a property.
    truth: tuple[Fact, ...]


def wrong_beliefs(
    world: World, memory: Memory, signatures: Signatures
) -> Iterator[WrongBelief]:
    """Yield the wrong beliefs; none if the world is no `Truth`.

    A fact about an item is only compared while the item has a sensor name. A property
    with its default value, such as `unknown`, is no belief.

    Raises:
        PortError: if a `HeldWorld` violates the port.
    """
    if not isinstance(world, Truth):
        return
    sensors: dict[object, str | None] = {
        item.name: item.sensor if item.accessible else None
        for item in memory.items.known.values()
    }
    for name, facts in world.truth().items():
        true = set(facts)
        relation = signatures.relations.get(name)
        for fact, stamp in memory.facts.table(name).stamps.items():
            seen = tuple([sensors.get(part, part) for part in fact])
            if seen in true or None in seen:
                continue
            others: Iterable[Fact] = ()
            if relation is not None and relation.is_property:
                if fact[-1] == relation.default:
                    continue
                others = [one for one in facts if one[:-1] == seen[:-1]]
            since = None if stamp == NEVER else stamp
            yield WrongBelief(fact, since, tuple(others))


def figures_of(
    world: World, wrong: Iterable[WrongBelief] = ()
) -> dict[str, int | float]:
    """Return the ground-truth figures of a world; none if it has none.

    Args:
        world: the world.
        wrong: the wrong beliefs of the robot, counted if the world is a `Truth`.

    Raises:
        PortError: if the world violates the port, or returns no mapping.
    """
    held = world if isinstance(world, HeldWorld) else HeldWorld(world)
    told: Any = held.figures() if isinstance(held, Measured) else {}
    figures: dict[str, int | float]
    figures = {n.replace("_", "-"): v for n, v in told.items() if is_number(v)}
    if isinstance(held, Truth):
        figures[WRONG_BELIEFS] = sum(1 for _ in wrong)
    return figures
