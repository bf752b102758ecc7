"""Ground truth of a simulator, for hosts: its figures, and the wrong beliefs.

The robot has no access to ground truth.
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
"""The name of the figure that counts the wrong beliefs in a world that is a `Truth`."""


class WrongBelief(NamedTuple):
    """A believed fact that is not true."""

    fact: Fact
    #: The time of its last assertion; None if the fact was never asserted.
    since: Time | None
    #: The true facts of the same property with the same arguments; empty for relations.
    truth: tuple[Fact, ...]


def wrong_beliefs(
    world: World, memory: Memory, signatures: Signatures
) -> Iterator[WrongBelief]:
    """Yield the wrong beliefs; none if the world is not a `Truth`.

    The truth has the sensor names of items. A fact about an item is compared only while
    the item has one. A property with its default value, such as `unknown`, is not a
    belief.

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
            in_world = tuple([sensors.get(part, part) for part in fact])
            if in_world in true or None in in_world:
                continue
            same_index: Iterable[Fact] = ()
            if relation is not None and relation.is_property:
                if fact[-1] == relation.default:
                    continue
                same_index = [one for one in facts if one[:-1] == in_world[:-1]]
            since = None if stamp == NEVER else stamp
            yield WrongBelief(fact, since, tuple(same_index))


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
    named: Any = held.figures() if isinstance(held, Measured) else {}
    figures: dict[str, int | float]
    figures = {n.replace("_", "-"): v for n, v in named.items() if is_number(v)}
    if isinstance(held, Truth):
        figures[WRONG_BELIEFS] = sum(1 for _ in wrong)
    return figures
