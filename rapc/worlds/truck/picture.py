"""The truck world as a picture: the layout of its map, its truth as neutral records.

Not here: drawing, and the robot's beliefs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rapc.base.pictures import DIRECTIONS
from rapc.world import Gauge, Picture, Spot, Thing
from rapc.worlds.truck.map import Map
from rapc.worlds.truck.scene import Scene
from rapc.worlds.truck.state import ARMS, BAYS, EXTERNAL
from rapc.worlds.truck.weather import dark, raining

_EIGHT = ((0, -1), (1, -1), (1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1))
_STEPS = dict(zip(DIRECTIONS, _EIGHT, strict=True))
"""Steps to the right and down, by direction."""

_ROUNDS = 200
"""The number of rounds of moving places towards the targets of their roads."""


Layout = Mapping[str, tuple[float, float]]
"""Coordinates of each place: to the right and down."""


def picture_of(scene: Scene, layout: Layout) -> Picture:
    """Return the picture of a scene, with its places at the layout's coordinates."""
    truck = scene.state.truck
    gauges = (
        Gauge("at", truck.place, ("truck-location",)),
        Gauge("fuel", truck.fuel, ("truck-fuel",)),
        Gauge("heading", truck.heading, ("truck-heading",)),
        Gauge("speed", truck.speed, ("truck-speed",)),
    )
    roads = tuple((road.a, road.b) for road in scene.map.roads)
    spots = tuple(_spots(scene, layout))
    return Picture(truck.place, spots, roads, truck.heading, "color", gauges)


def lay_out(ground: Map) -> Layout:
    """Return coordinates of each place, so that roads point roughly in their direction.

    A map has directions, no coordinates, and may not fit on a plane. So each place
    moves repeatedly to the mean of the targets of its roads.
    """
    where = {place.name: (0.0, 0.0) for place in ground.places}
    ways = {
        name: [(leg.to, *_STEPS[leg.direction]) for leg in ground.legs(name)]
        for name in where
    }
    for _ in range(_ROUNDS):
        for name, legs in ways.items():
            if legs:
                right = sum(where[to][0] - step for to, step, _ in legs)
                down = sum(where[to][1] - step for to, _, step in legs)
                where[name] = (right / len(legs), down / len(legs))
    left = min(right for right, _ in where.values())
    top = min(down for _, down in where.values())
    return {name: (_half(x - left), _half(y - top)) for name, (x, y) in where.items()}


def _half(steps: float) -> float:
    """Round steps to the nearest half."""
    return round(steps * 2) / 2


def _spots(scene: Scene, where: Layout) -> Iterator[Spot]:
    things: dict[str, list[Thing]] = {}
    for item in scene.state.items.values():
        things.setdefault(scene.root(item), []).append(Thing(item.kind, item.color))
    for name, at in where.items():
        yield Spot(name, tuple(things.get(name, ())), at, _weather(scene, name))
    for road in scene.map.roads:
        if road.name in things or road.name == scene.state.truck.place:
            (one, other), (up, down) = zip(where[road.a], where[road.b], strict=True)
            at = ((one + other) / 2, (up + down) / 2)
            there = tuple(things.get(road.name, ()))
            yield Spot(road.name, there, at, _weather(scene, road.name))
    for name in (*ARMS, *BAYS):
        yield Spot(name, tuple(things.get(name, ())), note=_note(scene, name))


def _weather(scene: Scene, spot: str) -> str:
    """Return `dark`, `rain`, both, or an empty text."""
    words = [("dark", dark(scene, spot)), ("rain", raining(scene, spot))]
    return " ".join(word for word, is_so in words if is_so)


def _note(scene: Scene, name: str) -> str:
    """Return an arm's position and the kind of item that the arm is at."""
    arm = scene.arm(name)
    if arm is None:
        return ""
    at = scene.at(name)
    place = "outside" if arm.place == EXTERNAL else arm.place
    return place if at is None else f"{place}, at a {at.kind}"
