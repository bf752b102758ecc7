"""States with a right form that no world has left are refused, and change nothing."""

from __future__ import annotations

import pytest

from rapc.world import Savable, World
from rapc.worlds.courier import CourierWorld
from rapc.worlds.hallway import HallwayWorld
from rapc.worlds.registry import build_world
from rapc.worlds.truck import TruckWorld

ROCK = '"rock-1":{"name":"rock-1","kind":"rock","place":"quarry-1"'


@pytest.mark.parametrize(
    ("kind", "old", "new"),
    [
        (TruckWorld, '"job":"quarry"', '"job":"depot"'),
        (TruckWorld, '"job":"quarry"', '"job":"shuffle"'),
        (TruckWorld, '"now":3', '"now":100000'),
        (TruckWorld, ROCK, ROCK.replace("quarry-1", "nowhere")),
        (TruckWorld, ROCK, ROCK.replace("quarry-1", "rock-1")),
        (TruckWorld, ROCK, ROCK.replace('"kind":"rock"', '"kind":"roc"')),
        (TruckWorld, '"arms":{"arm1"', '"arms":{"arm3"'),
        (CourierWorld, '"room":"base"', '"room":"bas"'),
        (CourierWorld, '"calls":[]', '"calls":["base"]'),
        (CourierWorld, '"now":3', '"now":100000'),
        (HallwayWorld, '"towards":"east-hall"', '"towards":"east-hal"'),
        (HallwayWorld, '"doorway":"lab-door"', '"doorway":"lab-doo"'),
        (HallwayWorld, '"lift":{"floor":1', '"lift":{"floor":9'),
        (HallwayWorld, '"now":3,"ticks":30', '"now":3,"ticks":-1000000000'),
    ],
)
def test_impossible_state_is_refused(kind: type[World], old: str, new: str) -> None:
    world = build_world(kind, 1, {})
    assert isinstance(world, Savable)
    world.advance(3)
    before = world.save()
    changed = before.decode().replace(old, new, 1)
    assert changed != before.decode()
    with pytest.raises(ValueError, match="no state of"):
        world.restore(changed.encode())
    assert world.save() == before
