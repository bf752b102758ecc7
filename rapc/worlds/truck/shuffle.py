"""The shuffling demon: somebody who moves things about the world (T 6.1.1, 6.3.1)."""

from __future__ import annotations

from rapc.terms import Number
from rapc.worlds.truck.kinds import ENEMY
from rapc.worlds.truck.scene import Scene
from rapc.worlds.truck.state import Demon, Item

TOOLS = frozenset({"gun", "gun-tool"})
"""What is left alone unless the option `shuffle-tools` says otherwise."""


def shuffle(scene: Scene, demon: Demon) -> Number | None:
    """Move some of what lies about to other places, chosen at random.

    Never at factories, never to a place that holds `item-limit` items already, and
    nothing that is on the truck or fixed.
    """
    settings, rng = scene.settings, scene.chance["shuffle"]
    if 0 < settings.shuffle_until <= scene.state.now:
        return None
    lying = _lying(scene)
    counts = {place: len(items) for place, items in lying.items()}
    left = frozenset() if settings.shuffle_tools else TOOLS
    for place, items in lying.items():
        for item in items:
            stays = item.kind in left or scene.kinds[item.kind].fixed
            if stays or rng.random() * 100 >= settings.shuffle_efficiency:
                continue
            limit = settings.item_limit
            others = [p for p, n in counts.items() if n < limit and p != place]
            if others:
                target = others[int(rng.random() * len(others))]
                scene.put(item, target)
                counts[place] -= 1
                counts[target] += 1
    return settings.shuffle_interval


def _lying(scene: Scene) -> dict[str, list[Item]]:
    """What lies at each place but the factories; enemies do not lie."""
    lying: dict[str, list[Item]] = {
        place.name: [] for place in scene.map.places if place.kind != "factory"
    }
    for item in scene.state.items.values():
        if item.place in lying and item.kind != ENEMY:
            lying[item.place].append(item)
    return lying
