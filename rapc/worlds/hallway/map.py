"""The building as data: spaces, doorways, landmarks, obstacles, people.

Spaces are rectangles `[left, bottom, right, top]` in metres, with walls of some
thickness between them; a doorway is a gap in the wall between two spaces, `at` its
middle along the wall. A doorway is a landmark on both its sides [S 3.2]; other
landmarks hang on one wall of a space. `map_text` reads maps in TOML, `map_checks`
validates them:

    start = "charger"

    [[space]]
    name = "lab"
    box = [0, 0, 6, 5]

    [[doorway]]
    name = "lab-door"
    joins = ["lab", "hall"]
    at = 3.0
    tags = [4, 5]

    [[landmark]]
    name = "charger"
    space = "lab"
    wall = "west"
    at = 2.5
    tags = [0, 1]
    charger = true
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, get_args

import msgspec
from msgspec import Meta

from rapc.worlds.maps import MapError

Metres = Annotated[float, Meta(ge=-1000, le=1000)]
"""A coordinate in metres."""

Name = Annotated[str, Meta(pattern=r"^[a-z][a-z0-9-]*\Z")]
"""A name on a map: a symbol of the language."""

Code = Annotated[int, Meta(ge=0, le=9999)]
"""The code on a tag."""

Apart = Annotated[float, Meta(ge=0.2, le=5)]
"""The distance between two tags, in metres."""

FloorNumber = Annotated[int, Meta(ge=-9, le=99)]

Box = tuple[Metres, Metres, Metres, Metres]
"""Left, bottom, right and top of a rectangle, in metres."""


def middle(box: Box) -> tuple[float, float]:
    """Return the middle of a rectangle."""
    left, bottom, right, top = box
    return (left + right) / 2, (bottom + top) / 2


Side = Literal["north", "east", "south", "west"]
SIDES: tuple[Side, ...] = get_args(Side)

_FACING = (-math.pi / 2, math.pi, math.pi / 2, 0.0)
NORMALS: dict[str, float] = dict(zip(SIDES, _FACING, strict=True))
"""The direction that a wall faces, in radians from the x axis, by side of the space."""

WALL = (0.1, 0.5)
"""The minimum and maximum thickness of a wall with a doorway, in metres."""


class Space(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A rectangle for the robot and for people."""

    name: Name
    box: Box
    kind: Literal["room", "hall", "lift"] = "room"
    #: The floors of the space; only a lift has more than one.
    floors: Annotated[tuple[FloorNumber, ...], Meta(min_length=1)] = (1,)


class Doorway(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A gap in the wall between two spaces, with a pair of tags on both sides."""

    name: Name
    joins: tuple[str, str]
    #: The middle of the gap along the wall.
    at: Metres
    #: The codes of the left and the right tag, as seen from in front of the doorway: an
    #: even code and the next code.
    tags: tuple[Code, Code]
    #: The width of the gap; the robot's skills do not recognise a wider doorway.
    width: Annotated[float, Meta(ge=0.7, le=1.3)] = 1.0
    #: The distance between the two tags on the wall beside the gap.
    apart: Apart = 1.4
    #: Whether the doorway has a door that closes now and then.
    door: bool = False
    says: str = ""


class Landmark(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A pair of tags on a wall of a space."""

    name: Name
    space: str
    wall: Side
    #: The middle of the pair along the wall.
    at: Metres
    tags: tuple[Code, Code]
    apart: Apart = 1.0
    #: Whether the landmark is a charger for the robot's battery.
    charger: bool = False
    says: str = ""


class Obstacle(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A box in a space."""

    box: Box
    floor: FloorNumber = 1


class Person(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A person who walks about, starting in the middle of a space."""

    space: str
    #: The walking speed, in metres a second.
    speed: Annotated[float, Meta(ge=0.1, le=2)] = 0.8


class Map(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A building."""

    space: Annotated[tuple[Space, ...], Meta(min_length=1)]
    doorway: tuple[Doorway, ...]
    #: The landmark at the robot's start.
    start: str
    landmark: tuple[Landmark, ...] = ()
    obstacle: tuple[Obstacle, ...] = ()
    person: tuple[Person, ...] = ()

    def named_space(self, name: str) -> Space:
        """Return a space by name. Raises KeyError."""
        for space in self.space:
            if space.name == name:
                return space
        raise KeyError(name)


class Opening(msgspec.Struct, frozen=True):
    """A doorway with its position in the building, computed from the joined spaces."""

    doorway: Doorway
    floor: int
    box: Box
    #: The side of the first joined space that has the doorway.
    side: Side


class Sign(msgspec.Struct, frozen=True):
    """A pair of tags with its position in a space."""

    landmark: str
    space: str
    floor: int
    #: The middle between the tags.
    x: float
    y: float
    #: The direction that the tags face, in radians.
    normal: float
    tags: tuple[int, int]
    apart: float
    says: str

    def tag_points(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the points of the left and the right tag, as seen from in front."""
        half = self.apart / 2
        dx, dy = -math.sin(self.normal) * half, math.cos(self.normal) * half
        return (self.x - dx, self.y - dy), (self.x + dx, self.y + dy)

    def front(self, distance: float) -> tuple[float, float]:
        """Return the point straight in front of the sign."""
        return (
            self.x + distance * math.cos(self.normal),
            self.y + distance * math.sin(self.normal),
        )


def openings(map: Map) -> tuple[Opening, ...]:
    """Return the doorways of a map with their positions.

    Raises:
        MapError: if a doorway does not lie in a wall between its spaces.
    """
    return tuple(_opening(map, doorway) for doorway in map.doorway)


def signs(map: Map) -> tuple[Sign, ...]:
    """Return all pairs of tags: two of a doorway, one of any other landmark."""
    made = []
    for opening in openings(map):
        doorway, along = opening.doorway, opening.side in {"north", "south"}
        at = middle(opening.box)[0 if along else 1]
        walls = (opening.side, SIDES[SIDES.index(opening.side) - 2])
        for name, wall in zip(doorway.joins, walls, strict=True):
            space = map.named_space(name)
            made.append(_sign(space, opening.floor, wall, at, doorway))
    for mark in map.landmark:
        space = map.named_space(mark.space)
        made.append(_sign(space, space.floors[0], mark.wall, mark.at, mark))
    return tuple(made)


def _sign(
    space: Space, floor: int, wall: Side, at: float, mark: Doorway | Landmark
) -> Sign:
    """Return a pair of tags on a wall of a space."""
    left, bottom, right, top = space.box
    x = {"east": right, "west": left}.get(wall, at)
    y = {"north": top, "south": bottom}.get(wall, at)
    facing, says = NORMALS[wall], mark.says or mark.name
    name, tags, apart = mark.name, mark.tags, mark.apart
    return Sign(name, space.name, floor, x, y, facing, tags, apart, says)


def _opening(map: Map, doorway: Doorway) -> Opening:
    first, second = (map.named_space(name) for name in doorway.joins)
    floors = [floor for floor in first.floors if floor in second.floors]
    if len(floors) != 1:
        raise MapError(
            f"`joins` of the doorway `{doorway.name}`: `{first.name}` and "
            f"`{second.name}` share no single floor"
        )
    a, b = first.box, second.box
    low, high = doorway.at - doorway.width / 2, doorway.at + doorway.width / 2
    gaps: list[tuple[Side, float, int, Box]] = [
        ("east", b[0] - a[2], 1, (a[2], low, b[0], high)),
        ("west", a[0] - b[2], 1, (b[2], low, a[0], high)),
        ("north", b[1] - a[3], 0, (low, a[3], high, b[1])),
        ("south", a[1] - b[3], 0, (low, b[3], high, a[1])),
    ]
    for side, thick, along, box in gaps:
        inside = all(s[along] <= low and high <= s[along + 2] for s in (a, b))
        if WALL[0] - 1e-9 <= thick <= WALL[1] + 1e-9 and inside:
            return Opening(doorway, floors[0], box, side)
    raise MapError(
        f"`at` of the doorway `{doorway.name}`: not in a wall of {WALL[0]} to "
        f"{WALL[1]} m between `{first.name}` and `{second.name}`"
    )
