"""The map: places, the roads between them, what lies where at the start (T 6.1.1).

A map is data, read from JSON text and checked here; `default_map.py` holds the one
that is used if no other is given. What the robot may know of it are `facts`: places
and roads, never items.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Annotated, Literal, get_args

import msgspec

from rapc.spell import nearest
from rapc.terms import Fact, Number, number
from rapc.worlds.truck.kinds import COLORED, KINDS, Color

Direction = Literal[
    "north",
    "northeast",
    "east",
    "southeast",
    "south",
    "southwest",
    "west",
    "northwest",
]
DIRECTIONS: tuple[str, ...] = get_args(Direction)
"""The eight directions, clockwise."""

PlaceKind = Literal["quarry", "factory", "warehouse", "depot", "zone"]
Name = Annotated[str, msgspec.Meta(pattern=r"^[a-z][a-z0-9-]*$", max_length=40)]
_MOST = 1_000_000

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


class MapError(ValueError):
    """A map that cannot be used; the text says why, in one line."""


class Place(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A place; `color` is that of the rocks of a quarry."""

    name: Name
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
    chance that a trip at high speed ends in one.
    """

    name: Name
    a: str
    direction: Direction
    b: str
    time: Number
    fuel: Number
    mishap: Number = 0


class Sector(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Part of the map, as names of places and roads (T 1.4.2)."""

    name: Name
    spots: tuple[str, ...]


class Lying(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Items of a kind that lie at a place, or on a road, at the start."""

    kind: str
    place: str
    count: Annotated[int, msgspec.Meta(ge=1, le=10_000)] = 1
    color: Color | None = None


class Leg(msgspec.Struct, frozen=True):
    """A way out of a place: down a road in a direction to its end."""

    road: Road
    direction: str
    to: str
    part: Number


class Map(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A map as it is written: see docs/truck.md."""

    start: str
    places: tuple[Place, ...]
    roads: tuple[Road, ...]
    items: tuple[Lying, ...] = ()
    sectors: tuple[Sector, ...] = ()
    heading: Direction = "north"

    def legs(self, place: str) -> Iterator[Leg]:
        """The ways out of a place or, named by its road, of a stop half-way on it."""
        for road in self.roads:
            back = opposite(road.direction)
            if road.a == place:
                yield Leg(road, road.direction, road.b, 1)
            if road.b == place:
                yield Leg(road, back, road.a, 1)
            if road.name == place:
                yield Leg(road, road.direction, road.b, 0.5)
                yield Leg(road, back, road.a, 0.5)

    def place(self, name: str) -> Place | None:
        """The place of a name, or None."""
        return next((p for p in self.places if p.name == name), None)

    def spots(self) -> tuple[str, ...]:
        """The names of all places and roads."""
        places = (place.name for place in self.places)
        return (*places, *(road.name for road in self.roads))

    def facts(self) -> Iterator[Fact]:
        """What the robot knows of the map."""
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
        for spot in self.spots():
            for leg in self.legs(spot):
                yield ("road", leg.road.name, spot, leg.direction, leg.to)
        for direction in DIRECTIONS:
            yield ("opposite", direction, opposite(direction))


def opposite(direction: str) -> str:
    """The direction half a turn away."""
    return DIRECTIONS[(DIRECTIONS.index(direction) + 4) % 8]


def read_map(text: str) -> Map:
    """A map from JSON text.

    Raises:
        MapError: for what is no JSON, has other fields, or makes no sense.
    """
    try:
        made = msgspec.json.decode(text.encode(), type=Map)
    except (msgspec.DecodeError, UnicodeEncodeError, RecursionError) as error:
        raise MapError(f"cannot be read: {str(error).lower()}") from error
    for problem in _problems(made):
        raise MapError(problem)
    return made


def _problems(made: Map) -> Iterator[str]:
    names = made.spots()
    for index, name in enumerate(names):
        if name in names[:index]:
            yield f"`{name}` stands for two places or roads"
        if name in TAKEN:
            yield f"`{name}` cannot be the name of a place or road"
    places = [place.name for place in made.places]
    yield from _unknown(made.start, places, "the start")
    for road in made.roads:
        for end in (road.a, road.b):
            yield from _unknown(end, places, f"an end of `{road.name}`")
        if road.a == road.b:
            yield f"`{road.name}` leads from `{road.a}` to itself"
        if not (0 < road.time <= _MOST and 0 <= road.fuel <= _MOST):
            yield f"`{road.name}` must take time, and no less fuel than none"
        if not 0 <= road.mishap <= 1:
            yield f"`{road.name}`: the chance of a mishap is not from 0 to 1"
    yield from _crossed(made)
    yield from _bad_colors(made)
    yield from _bad_sectors(made, names)
    for lying in made.items:
        yield from _unknown(lying.kind, KINDS, "an item's kind")
        yield from _unknown(lying.place, names, f"the place of a `{lying.kind}`")


def _unknown(name: str, known: Collection[str], what: str) -> Iterator[str]:
    if name not in known:
        near = nearest(name, known)
        hint = f"; did you mean `{near}`?" if near else ""
        yield f"{what} is `{name}`, which is unknown{hint}"


def _crossed(made: Map) -> Iterator[str]:
    for place in made.places:
        taken: dict[str, str] = {}
        for leg in made.legs(place.name):
            first = taken.setdefault(leg.direction, leg.road.name)
            if first != leg.road.name:
                yield (
                    f"`{first}` and `{leg.road.name}` both lead "
                    f"{leg.direction} from `{place.name}`"
                )


def _bad_sectors(made: Map, names: Collection[str]) -> Iterator[str]:
    sectors: dict[str, str] = {}
    for index, sector in enumerate(made.sectors):
        if sector.name in [other.name for other in made.sectors[:index]]:
            yield f"`{sector.name}` stands for two sectors"
        for spot in sector.spots:
            yield from _unknown(spot, names, f"part of the sector `{sector.name}`")
            if sectors.setdefault(spot, sector.name) != sector.name:
                yield f"`{spot}` is in two sectors"


def _bad_colors(made: Map) -> Iterator[str]:
    for place in made.places:
        if (place.color is not None) != (place.kind == "quarry"):
            yield f"`{place.name}`: quarries alone have a colour"
    for lying in made.items:
        if (lying.color is not None) != (lying.kind in COLORED):
            yield f"`{lying.kind}` at `{lying.place}`: rocks alone have a colour"
