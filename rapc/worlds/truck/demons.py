"""What happens in the truck's world without it, at times of its own (T 6.1.1, 6.1.2).

A demon is a job done at a place again and again, at intervals that vary by half about
what the options say. A new kind of agent is one more function in `JOBS` and a demon
that `summon` puts into the state.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rapc.terms import Number, number
from rapc.worlds.truck.map import PRODUCTS
from rapc.worlds.truck.scene import Scene
from rapc.worlds.truck.state import Demon


def summon(scene: Scene) -> None:
    """Put into the state the demons that the map and the options call for."""
    for place in scene.map.places:
        if place.kind in JOBS and _interval(scene, place.kind) > 0:
            demon = Demon(place.kind, place.name, 0)
            _rest(scene, demon)
            scene.state.demons.append(demon)


def pass_time(scene: Scene, to: Number) -> None:
    """Move the clock on; demons whose times come act at them, in turn."""
    state = scene.state
    while True:
        demon = min(state.demons, key=lambda d: d.time, default=None)
        if demon is None or demon.time > to:
            break
        state.now = max(state.now, demon.time)
        JOBS[demon.job](scene, demon.place)
        _rest(scene, demon)
    state.now = max(state.now, to)


def _rest(scene: Scene, demon: Demon) -> None:
    pause = scene.vary(_interval(scene, demon.job), 50)
    demon.time = number(round(demon.time + pause, 2))


def _interval(scene: Scene, job: str) -> Number:
    settings = scene.settings
    intervals: Mapping[str, Number] = {
        "quarry": settings.quarry_interval,
        "warehouse": settings.warehouse_interval,
        "depot": settings.depot_interval,
        "factory": settings.factory_interval,
    }
    return intervals[job]


def _produce(scene: Scene, name: str) -> None:
    """A quarry or warehouse makes one item, unless too many lie there already."""
    place = scene.map.place(name)
    lying = sum(1 for _ in scene.items_at(name))
    if place is not None and lying < scene.settings.item_limit:
        scene.make(PRODUCTS[place.kind], name, place.color)


def _supply(scene: Scene, name: str) -> None:
    """A depot removes empty drums wherever they lie about, and makes a full one."""
    lying_at = scene.map.spots()
    for item in [i for i in scene.state.items.values() if i.place in lying_at]:
        if item.kind == PRODUCTS["depot"] and item.amount == 0:
            scene.remove(item)
    _produce(scene, name)


def _take_in(scene: Scene, name: str) -> None:
    """A factory takes in the rocks that lie there.

    They are still at the factory, where no eye and no arm gets at them: a scan does
    not report them gone.
    """
    for item in [i for i in scene.items_at(name) if i.kind == "rock"]:
        scene.remove(item)
        scene.state.sighted.pop(item.name, None)


JOBS: Mapping[str, Callable[[Scene, str], None]] = {
    "quarry": _produce,
    "warehouse": _produce,
    "depot": _supply,
    "factory": _take_in,
}
"""The jobs by the kind of place at which they are done."""
