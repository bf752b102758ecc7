"""The primitives that move the truck (T B.1): turning, speed, and trips along roads."""

from __future__ import annotations

from collections.abc import Mapping

from rapc.base.pictures import DIRECTIONS
from rapc.base.values import Atom, Number
from rapc.world import OKAY, Reply
from rapc.worlds.truck.demons import pass_time
from rapc.worlds.truck.enemies import meet, part
from rapc.worlds.truck.kinds import ENEMY
from rapc.worlds.truck.map import WayOut
from rapc.worlds.truck.scene import Scene, tidy
from rapc.worlds.truck.state import EXTERNAL
from rapc.worlds.truck.weather import hardships

SPEEDS: Mapping[str, tuple[Number, Number]] = {
    "slow": (1.5, 0.9),
    "medium": (1, 1),
    "fast": (0.75, 1.3),
}
"""Factors on the nominal time and the nominal fuel of a road, by speed."""

MISHAP = "truck-mishap"


def truck_turn(scene: Scene, direction: Atom) -> Reply:
    """Turn the truck to a direction."""
    if direction not in DIRECTIONS:
        return Reply("truck-bad-direction")
    scene.state.truck.heading = str(direction)
    return Reply(OKAY, (("heading", direction),))


def truck_speed(scene: Scene, speed: Atom) -> Reply:
    """Set the speed of later trips."""
    if speed not in SPEEDS:
        return Reply("truck-bad-speed")
    scene.state.truck.speed = str(speed)
    return Reply(OKAY, (("speed", speed),))


def truck_move(scene: Scene) -> Reply:
    """Travel along the road ahead to its end, or until eye or enemies stop the truck.

    Raise RefusedError if there is no road ahead or an arm is outside. Without enough
    fuel for the trip, or in a mishap, the truck stays on the road and the run ends. A
    captured truck does not move.
    """
    truck = scene.state.truck
    if scene.state.ended is not None:
        return Reply(MISHAP)
    leg = _ahead(scene)
    if leg is None or any(arm.place == EXTERNAL for arm in truck.arms.values()):
        return Reply("truck-cant-move")
    stop = _stops_on(scene, leg)
    part = leg.part * (0.5 if stop else 1)
    slower, thirstier, mud = hardships(scene, leg.road)
    time, fuel = _cost(scene, leg, part, slower, thirstier)
    mishap = _mishap(scene, leg, mud)
    if fuel > truck.fuel:
        time = time * truck.fuel / fuel
        return _stranded(scene, leg, time, truck.fuel, "out of fuel")
    if mishap:
        return _stranded(scene, leg, time, fuel, "mishap")
    _drive(scene, leg, leg.road.name if stop else leg.to, time, fuel)
    data = (("new-location", truck.place), ("fuel-level", truck.fuel))
    return Reply(OKAY, data)


def _ahead(scene: Scene) -> WayOut | None:
    truck = scene.state.truck
    legs = scene.map.legs(truck.place)
    return next((leg for leg in legs if leg.direction == truck.heading), None)


def _stops_on(scene: Scene, leg: WayOut) -> bool:
    """Return whether enemies or watched items are on the road."""
    if scene.state.truck.place == leg.road.name:
        return False
    stopping = (ENEMY, *scene.state.monitored)
    return any(item.kind in stopping for item in scene.items_at(leg.road.name))


def _cost(
    scene: Scene, leg: WayOut, part: Number, time: Number, fuel: Number
) -> tuple[Number, Number]:
    """Return time and fuel for a part of a road at the set speed, with factors."""
    settings = scene.settings
    slower, thirstier = SPEEDS[scene.state.truck.speed]
    nominal = leg.road.time * settings.road_time * part * slower * time
    time = scene.vary(nominal, settings.time_spread)
    fuel = scene.vary(leg.road.fuel * part * thirstier * fuel, settings.fuel_spread)
    return time, tidy(fuel * settings.fuel_use)


def _mishap(scene: Scene, leg: WayOut, mud: Number) -> bool:
    """Return whether a trip ends in a mishap: at high speed, or stuck in mud."""
    if mud > 0 and scene.chance["weather"].random() < mud:
        return True
    risky = leg.road.mishap > 0 and scene.state.truck.speed == "fast"
    return risky and scene.rng.random() < leg.road.mishap


def _stranded(scene: Scene, leg: WayOut, time: Number, fuel: Number, why: str) -> Reply:
    _drive(scene, leg, leg.road.name, tidy(time), fuel)
    scene.end(f"{why} on {leg.road.name}")
    return Reply(MISHAP, (("fuel-level", scene.state.truck.fuel),))


def _drive(scene: Scene, leg: WayOut, to: str, time: Number, fuel: Number) -> None:
    """Make the trip; the truck forgets the items sensed at its old place."""
    state = scene.state
    part(scene)
    state.truck.place = leg.road.name
    pass_time(scene, tidy(state.now + time))
    state.truck.place = to
    meet(scene)
    state.truck.fuel = tidy(state.truck.fuel - fuel)
    state.sighted.clear()
    state.names.clear()
