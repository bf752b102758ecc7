"""Enemy troops: arrival, movement, and effects on the truck (T 6.1.1).

Units come in bands to places and, with `road-troops`, to roads. A band on a road stops
the truck half-way. A band stays for a while and moves on; a band at the truck's place
stays until its units are shot or the truck leaves. The chance of a capture, which ends
the run, rises with the time that enemies and truck are together. All chance in this
module comes from the streams `enemies` and `weapon`.
"""

from __future__ import annotations

from math import log2, sqrt

from rapc.base.names import hint
from rapc.base.values import Number, number
from rapc.worlds.truck.kinds import ENEMY
from rapc.worlds.truck.map import Map
from rapc.worlds.truck.scene import Scene
from rapc.worlds.truck.state import Demon, Encounter, TruckItem

SAFE = frozenset({"warehouse", "depot"})
"""Kinds of places without enemies."""


def haunts(ground: Map, sectors: str, on_roads: bool) -> tuple[str, ...]:
    """Return the places that enemies may visit: some sectors, or all zones.

    Args:
        ground: the map.
        sectors: names of sectors, with commas; if empty, all zones and all roads.
        on_roads: whether enemies visit roads as well as places.

    Raises:
        ValueError: for a sector that is not on the map.
    """
    roads = tuple(road.name for road in ground.roads) if on_roads else ()
    if not sectors:
        zones = (place.name for place in ground.places if place.kind == "zone")
        return (*zones, *roads)
    known = {sector.name: sector.spots for sector in ground.sectors}
    wanted: set[str] = set()
    for name in (part.strip() for part in sectors.split(",")):
        if name not in known:
            said = f"`enemy-sectors`: the map has no sector `{name[:40]}`"
            raise ValueError(said + hint(name, known))
        wanted.update(known[name])
    places = (place for place in ground.places if place.name in wanted)
    open_places = (place.name for place in places if place.kind not in SAFE)
    return (*open_places, *(road for road in roads if road in wanted))


def pause(scene: Scene) -> Number:
    """Draw the time to the next band: the option's value, varied by half."""
    return scene.vary(scene.settings.enemy_interval, 50, "enemies")


def appear(scene: Scene, demon: Demon) -> Number:
    """Put a band at a random place, if there are no enemies yet.

    No band comes to the road that the truck is on.
    """
    rng, settings = scene.chance["enemies"], scene.settings
    options = settings.enemy_sectors, settings.road_troops
    place = rng.choice(haunts(scene.map, *options))
    units = rng.randint(1, settings.enemy_units)
    on_road = scene.map.place(place) is None and place == scene.state.truck.place
    if not _units(scene, place) and not on_road:
        for _ in range(units):
            scene.make(ENEMY, place)
        scene.expect("leaving", place, settings.enemy_stay)
        meet(scene)
    return pause(scene)


def move_band_on(scene: Scene, demon: Demon) -> None:
    """Move the band at a place on, unless the truck is there."""
    if scene.state.truck.place != demon.place:
        _remove(scene, demon.place)


def meet(scene: Scene) -> None:
    """Start the time to the truck's capture if enemies are at the truck's place.

    The chance of a capture within a time t is 1 - 2 ** -((t / capture-time) ** 2): the
    hazard rises with t.
    """
    state, settings = scene.state, scene.settings
    place, units = state.truck.place, len(_units(scene, state.truck.place))
    if not units or _under_way(scene) is not None:
        return
    state.encounters.append(Encounter(state.now, place, units))
    if settings.capture_time > 0:
        spread = sqrt(-log2(1 - scene.chance["enemies"].random()))
        scene.expect("capture", place, settings.capture_time * spread)


def take_truck(scene: Scene, demon: Demon) -> None:
    """Capture the truck, which ends the run."""
    _over(scene, "captured")
    scene.end(f"captured at {demon.place}")


def part(scene: Scene) -> None:
    """End the encounter when the truck departs, and remove the enemies."""
    _over(scene, "left")
    _remove(scene, scene.state.truck.place)


def fire(scene: Scene, gun: TruckItem) -> None:
    """Fire rounds at the enemies outside until no enemies or no rounds are left.

    A burst is `gun-burst` rounds at most; without enemies no round is fired.
    """
    rng, settings = scene.chance["weapon"], scene.settings
    targets = _units(scene, scene.state.truck.place)
    for _ in range(settings.gun_burst):
        if not targets or gun.amount < 1:
            break
        gun.amount = number(gun.amount - 1)
        if rng.uniform(0, 100) < settings.gun_hits:
            scene.remove(targets.pop(0))
    if not targets:
        _over(scene, "shot")
        _remove(scene, scene.state.truck.place)


def _units(scene: Scene, place: str) -> list[TruckItem]:
    return [item for item in scene.items_at(place) if item.kind == ENEMY]


def _under_way(scene: Scene) -> Encounter | None:
    encounters = scene.state.encounters
    return encounters[-1] if encounters and encounters[-1].until is None else None


def _over(scene: Scene, how: str) -> None:
    encounter = _under_way(scene)
    if encounter is not None:
        encounter.until, encounter.how = scene.state.now, how


def _remove(scene: Scene, place: str) -> None:
    """Remove all enemies from a place, with their demons."""
    for item in _units(scene, place):
        scene.remove(item)
    scene.dismiss(place, "leaving", "capture")
