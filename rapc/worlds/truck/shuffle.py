"""The shuffling demon: an agent that moves items about the world (T 6.1.1, 6.3.1)."""

from __future__ import annotations

from rapc.base.values import Number
from rapc.worlds.truck.kinds import ENEMY
from rapc.worlds.truck.scene import Scene
from rapc.worlds.truck.state import Demon, TruckItem

TOOLS = frozenset({"gun", "gun-tool"})
"""Kinds that the demon moves only with the option `shuffle-tools`."""


def shuffle(scene: Scene, demon: Demon) -> Number | None:
    """Move some items to other places, chosen at random.

    The demon moves no items from or to factories, no items on the truck, no fixed
    items, and nothing to a place that has reached `item-limit`.
    """
    settings, rng = scene.settings, scene.chance["shuffle"]
    chance = settings.shuffle_efficiency / 100
    left = {kind for kind in scene.kinds if scene.kinds[kind].fixed}
    left |= frozenset() if settings.shuffle_tools else TOOLS
    if 0 < settings.shuffle_until <= scene.state.now:
        return None
    lying = _lying(scene)
    spare = {place: settings.item_limit - len(lying[place]) for place in lying}
    room = [place for place in lying if spare[place] > 0]
    for place, items in lying.items():
        for item in items:
            if item.kind in left or rng.random() >= chance:
                continue
            others = len(room) - (spare[place] > 0)
            if others == 0:
                continue
            target = room[int(rng.random() * others)]
            scene.put(item, room[others] if target == place else target)
            _count(spare, room, place, 1)
            _count(spare, room, item.place, -1)
    return settings.shuffle_interval


def _count(spare: dict[str, int], room: list[str], place: str, more: int) -> None:
    """Count items at a place; `room` lists the places that have room for more."""
    before = spare[place] > 0
    spare[place] += more
    if spare[place] > 0 and not before:
        room.append(place)
    elif before and spare[place] <= 0:
        room.remove(place)


def _lying(scene: Scene) -> dict[str, list[TruckItem]]:
    """Return the items at each place, factories and enemies excluded."""
    lying: dict[str, list[TruckItem]] = {
        place.name: [] for place in scene.map.places if place.kind != "factory"
    }
    for item in scene.state.items.values():
        if item.place in lying and item.kind != ENEMY:
            lying[item.place].append(item)
    return lying
