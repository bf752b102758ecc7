"""Demons: agents that change the truck's world at times of their own (T 6.1.1, 6.1.2).

A demon is a job at a place, repeated or done once. The job returns the time until its
next turn. This module has the jobs of quarries, warehouses, depots and factories; their
intervals vary by half about the values of the options. Other jobs have modules of
their own. To add an agent, add a function to `JOBS` and create its demon in `summon`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rapc.base.values import Number
from rapc.worlds.truck import enemies
from rapc.worlds.truck.machines import work
from rapc.worlds.truck.map import PRODUCTS
from rapc.worlds.truck.scene import Scene, tidy
from rapc.worlds.truck.shuffle import shuffle
from rapc.worlds.truck.state import Demon, TruckState
from rapc.worlds.truck.weather import change_weather

Job = Callable[[Scene, Demon], Number | None]
"""A job: act, then return the time until the next turn; None: no next turn."""


def summon(scene: Scene) -> None:
    """Add to the state the demons that the map and the options require."""
    for job, place in standing(scene):
        demon = Demon(job, place, 0)
        if job in _PLACES:
            demon.time = _pause(scene, job)
        elif job == "shuffle":
            demon.time = scene.settings.shuffle_interval
        elif job == "weather":
            demon.time = change_weather(scene, demon)
        else:
            demon.time = enemies.pause(scene)
        scene.state.demons.append(demon)
    enemies.meet(scene)


def standing(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield job and place of each permanent demon, in order."""
    settings = scene.settings
    for place in scene.map.places:
        if place.kind in _PLACES and _interval(scene, place.kind) > 0:
            yield place.kind, place.name
    if settings.shuffle_interval > 0:
        yield "shuffle", ""
    for sector in scene.map.sectors if settings.rain > 0 else ():
        yield "weather", sector.name
    haunts = enemies.haunts(scene.map, settings.enemy_sectors, settings.road_troops)
    if settings.enemy_interval > 0 and settings.enemy_units > 0 and haunts:
        yield "enemies", ""


def check_demons(scene: Scene, state: TruckState) -> None:
    """Validate that a saved state has all permanent demons; raise ValueError."""
    known = {*standing(scene)}
    for demon in state.demons:
        passing = demon.job in {"leaving", "capture", "machine"}
        if demon.time < state.now or not (passing or (demon.job, demon.place) in known):
            raise ValueError(f"the demon `{demon.job}`")


def pass_time(scene: Scene, to: Number) -> None:
    """Advance the clock; demons that are due act in order of time."""
    state = scene.state
    while True:
        demon = min(state.demons, key=lambda each: each.time, default=None)
        if demon is None or demon.time > to:
            break
        state.now = max(state.now, demon.time)
        rest = JOBS[demon.job](scene, demon)
        if rest is None:
            state.demons = [each for each in state.demons if each is not demon]
        else:
            demon.time = tidy(demon.time + rest)
    state.now = max(state.now, to)


def _pause(scene: Scene, job: str) -> Number:
    return scene.vary(_interval(scene, job), 50)


def _interval(scene: Scene, job: str) -> Any:
    return getattr(scene.settings, f"{job}_interval")


def _produce(scene: Scene, demon: Demon) -> Number:
    """Make one item at a quarry or warehouse, unless the item limit is reached."""
    place = scene.map.place(demon.place)
    if place is not None and not scene.crowded(place.name):
        scene.make(PRODUCTS[place.kind], place.name, place.color)
    return _pause(scene, demon.job)


def _supply(scene: Scene, demon: Demon) -> Number:
    """Remove empty drums from all places and make a full drum at the depot."""
    lying_at = scene.map.spots()
    for item in [i for i in scene.state.items.values() if i.place in lying_at]:
        if item.kind == PRODUCTS["depot"] and item.amount == 0:
            scene.remove(item)
    return _produce(scene, demon)


def _take_in(scene: Scene, demon: Demon) -> Number:
    """Take in the rocks at a factory.

    The rocks stay at the factory, out of reach of eye and arms: a scan does not report
    these rocks as gone.
    """
    for item in [i for i in scene.items_at(demon.place) if i.kind == "rock"]:
        scene.remove(item)
        scene.state.sighted.pop(item.name, None)
    return _pause(scene, demon.job)


_PLACES: Mapping[str, Job] = {
    "quarry": _produce,
    "warehouse": _produce,
    "depot": _supply,
    "factory": _take_in,
}
"""Jobs by the kind of their place."""

JOBS: Mapping[str, Job] = {
    **_PLACES,
    "shuffle": shuffle,
    "enemies": enemies.appear,
    "leaving": enemies.move_band_on,
    "capture": enemies.take_truck,
    "weather": change_weather,
    "machine": work,
}
"""All jobs by name."""
