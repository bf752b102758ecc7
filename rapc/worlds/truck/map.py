"""The map: places, the roads between them, what lies where at the start (T 6.1.1).

A map is data, read and checked by `map_text`. What the robot may know of it are
`facts`: places and roads, never items.
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
"""What places of a kind produce."""

TAKEN = frozenset(
    {"external", "folded", "bay1", "bay2", "weapon-bay", "fuel-bay", "arm1", "arm2"}
    | {"unknown", *KINDS, *DIRECTIONS}
)
"""Names that mean something else in a request or in memory."""


class MapPlace(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A place; `color` is that of the rocks of a quarry."""

    name: Word
    kind: PlaceKind
    color: Color | None = None


class Road(
    msgspec.Struct,
    frozen=True,
    forbid_unknown_fields=True,
    rename={"a": "from", "b": "to"},
):
    """A road from one place in a direction to another; it goes both ways.

    `time` and `fuel` are what a trip takes at medium speed, about. `mishap` is the
    chance that a trip at high speed ends in one, `mud` that a trip in the rain does.
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
    """Part of the map, as names of places and roads; some are always `dark`."""

    name: Word
    spots: tuple[str, ...]
    dark: bool = False


class Lying(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Items of a kind that lie at a place, a road or in an item, at the start."""

    kind: str
    place: str
    count: Annotated[int, msgspec.Meta(ge=1, le=10_000)] = 1
    color: Color | None = None
    #: Whether they are machines that do not work.
    broken: bool = False


class WayOut(msgspec.Struct, frozen=True):
    """A way out of a place: down a road in a direction to its end."""

    road: Road
    direction: str
    to: str
    part: Number


class Map(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A map as it is written: see docs/truck.md."""

    start: str
    places: tuple[MapPlace, ...]
    roads: tuple[Road, ...]
    items: tuple[Lying, ...] = ()
    sectors: tuple[Sector, ...] = ()
    kinds: Mapping[Word, Kind] = {}
    heading: Direction = "north"

    def legs(self, place: str) -> Iterator[WayOut]:
        """The ways out of a place or, named by its road, of a stop half-way on it."""
        for road in self.roads:
            if road.a == place:
                yield WayOut(road, road.direction, road.b, 1)
            if road.b == place:
                yield WayOut(road, opposite(road.direction), road.a, 1)
            if road.name == place:
                yield WayOut(road, road.direction, road.b, 0.5)
                yield WayOut(road, opposite(road.direction), road.a, 0.5)

    def place(self, name: str) -> MapPlace | None:
        """The place of a name, or None."""
        return next((p for p in self.places if p.name == name), None)

    def spots(self) -> tuple[str, ...]:
        """Return the names of all places and roads."""
        places = (place.name for place in self.places)
        return (*places, *(road.name for road in self.roads))

    def facts(self) -> Iterator[Fact]:
        """Yield what the robot knows of the map."""
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
    """The direction half a turn away."""
    return DIRECTIONS[(DIRECTIONS.index(direction) + 4) % 8]
