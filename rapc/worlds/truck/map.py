"""The map: places, roads, and the items at the start (T 6.1.1).

A map is data, read and validated by `map_text`. `Map.facts` is the part that the robot
may know: places and roads, never items.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Literal

import msgspec

from rapc.base.pictures import DIRECTIONS, Direction
from rapc.base.values import Fact, Number, number
from rapc.worlds.truck.kinds import KINDS, Color, Kind, Word

PlaceKind = Literal["quarry", "factory", "warehouse", "depot", "zone"]

PRODUCTS: Mapping[str, str] = {
    "quarry": "rock",
    "warehouse": "ammo-box",
    "depot": "fuel-drum",
}
"""Products by kind of place."""

TAKEN = frozenset(
    {"external", "folded", "bay1", "bay2", "weapon-bay", "fuel-bay", "arm1", "arm2"}
    | {"unknown", *KINDS, *DIRECTIONS}
)
"""Reserved names, with another meaning in a request or in memory."""


class MapPlace(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A place; `color` is the colour of a quarry's rocks."""

    name: Word
    kind: PlaceKind
    color: Color | None = None


class Road(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    rename={"a": "from", "b": "to"},
):
    """A road from a place in a direction to another place, open both ways.

    `time` and `fuel` are the approximate cost of a trip at medium speed. `mishap` is
    the chance of a mishap at high speed, `mud` the chance of a mishap in the rain.
    """

    name: Word
    a: str
    direction: Direction
    b: str
    time: Number
    fuel: Number
    mishap: Number = 0
    mud: Number = 0


class Sector(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A part of the map: names of places and roads; some sectors are always `dark`."""

    name: Word
    spots: tuple[str, ...]
    dark: bool = False


class Lying(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Items of a kind at a place, on a road or in an item, at the start."""

    kind: str
    place: str
    count: Annotated[int, msgspec.Meta(ge=1, le=10_000)] = 1
    color: Color | None = None
    #: Whether the items are broken machines.
    broken: bool = False


class WayOut(msgspec.Struct, frozen=True):
    """A way out of a place: along a road in a direction to its end."""

    road: Road
    direction: str
    to: str
    part: Number


class Map(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A map in its written form: see docs/reference/truck.md."""

    start: str
    places: tuple[MapPlace, ...]
    roads: tuple[Road, ...]
    items: tuple[Lying, ...] = ()
    sectors: tuple[Sector, ...] = ()
    kinds: Mapping[Word, Kind] = {}
    heading: Direction = "north"

    def legs(self, place: str) -> Iterator[WayOut]:
        """Yield the ways out of a place, or out of a stop half-way on a road."""
        for road in self.roads:
            if road.a == place:
                yield WayOut(road, road.direction, road.b, 1)
            if road.b == place:
                yield WayOut(road, opposite(road.direction), road.a, 1)
            if road.name == place:
                yield WayOut(road, road.direction, road.b, 0.5)
                yield WayOut(road, opposite(road.direction), road.a, 0.5)

    def place(self, name: str) -> MapPlace | None:
        """Return the place with this name, or None."""
        return next((p for p in self.places if p.name == name), None)

    def spots(self) -> tuple[str, ...]:
        """Return the names of all places and roads."""
        places = (place.name for place in self.places)
        return (*places, *(road.name for road in self.roads))

    def facts(self) -> Iterator[Fact]:
        """Yield the facts about the map that the robot knows."""
        for place in self.places:
            yield ("place", place.name, place.kind)
            if place.kind in PRODUCTS:
                yield ("produces", place.name, PRODUCTS[place.kind])
            if place.color is not None:
                yield ("quarry-color", place.name, place.color)
        for road in self.roads:
            yield ("place", road.name, "road")
            yield ("road-time", road.name, number(road.time))
            yield ("road-fuel", road.name, number(road.fuel))
            if road.mishap > 0:
                yield ("road-risk", road.name, "speed")
            if road.mud > 0:
                yield ("road-risk", road.name, "mud")
        for spot in self.spots():
            for leg in self.legs(spot):
                yield ("road", leg.road.name, spot, leg.direction, leg.to)
        for direction in DIRECTIONS:
            yield ("opposite", direction, opposite(direction))


def opposite(direction: str) -> str:
    """Return the opposite direction."""
    return DIRECTIONS[(DIRECTIONS.index(direction) + 4) % 8]
