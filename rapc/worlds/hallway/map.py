"""The building as data: spaces, doorways, landmarks, obstacles, people.

A map is a TOML text. Spaces are rectangles `[left, bottom, right, top]` in metres, with
walls of some thickness between them; a doorway is a gap in the wall between two spaces,
`at` its middle along the wall. A doorway is a landmark on both its sides [S 3.2]; other
landmarks hang on one wall of a space.

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
from collections.abc import Iterator, Sequence
from typing import Literal

import msgspec

Box = tuple[float, float, float, float]
"""Left, bottom, right and top of a rectangle, in metres."""

Side = Literal["north", "east", "south", "west"]

NORMALS: dict[str, float] = {
    "north": -math.pi / 2,
    "east": math.pi,
    "south": math.pi / 2,
    "west": 0.0,
}
"""Where a wall faces, from its own side of the space, in radians from the x axis."""

WALL = (0.1, 0.5)
"""The thinnest and the thickest wall that a doorway may lead through, in metres."""


FREE = 0.4
"""What is free around somebody, and around the robot before a landmark, in metres."""


class MapError(ValueError):
    """A text that is no map, or a map that contradicts itself."""


class Space(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A rectangle in which the robot can be."""

    name: str
    box: Box
    kind: Literal["room", "hall", "lift"] = "room"
    #: The floors on which the space is; more than one for a lift only.
    floors: tuple[int, ...] = (1,)


class Doorway(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A gap in the wall between two spaces, with a pair of tags on both sides."""

    name: str
    joins: tuple[str, str]
    #: The middle of the gap along the wall.
    at: float
    #: The codes of the left and the right tag, as seen when facing the doorway.
    tags: tuple[int, int]
    width: float = 1.0
    #: Between the two tags.
    apart: float = 1.4
    #: Whether there is a door that closes now and then.
    door: bool = False
    says: str = ""


class Landmark(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A pair of tags on a wall of a space."""

    name: str
    space: str
    wall: Side
    #: The middle of the pair along the wall.
    at: float
    tags: tuple[int, int]
    apart: float = 1.0
    #: Whether the robot can charge its battery here.
    charger: bool = False
    says: str = ""


class Obstacle(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A box that stands in a space."""

    box: Box
    floor: int = 1


class Person(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Somebody who walks about, from the middle of a space."""

    space: str
    #: In metres a second.
    speed: float = 0.8


class Map(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A building."""

    space: tuple[Space, ...]
    doorway: tuple[Doorway, ...]
    #: The landmark that the robot stands at in the beginning.
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
    """A doorway as it lies in the building, computed from the spaces it joins."""

    doorway: Doorway
    floor: int
    box: Box
    #: The side of the first joined space on which it is.
    side: Side


class Sign(msgspec.Struct, frozen=True):
    """A pair of tags as it hangs in a space."""

    landmark: str
    space: str
    floor: int
    #: The middle between the tags.
    x: float
    y: float
    #: The direction in which the tags face, in radians.
    normal: float
    tags: tuple[int, int]
    apart: float
    says: str

    def tag_points(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return where the left and the right tag are, as seen from in front."""
        half = self.apart / 2
        dx, dy = -math.sin(self.normal) * half, math.cos(self.normal) * half
        return (self.x - dx, self.y - dy), (self.x + dx, self.y + dy)

    def front(self, distance: float) -> tuple[float, float]:
        """Return the point straight in front of the sign."""
        return (
            self.x + distance * math.cos(self.normal),
            self.y + distance * math.sin(self.normal),
        )


def read_map(text: str) -> Map:
    """Return the map that a TOML text describes.

    Raises:
        MapError: if the text is none, or the map contradicts itself.
    """
    try:
        made = msgspec.toml.decode(text, type=Map)
    except (msgspec.DecodeError, ValueError) as error:
        raise MapError(f"no map: {error}") from error
    _check(made)
    return made


def openings(map: Map) -> tuple[Opening, ...]:
    """Return where the doorways of a map are.

    Raises:
        MapError: if a doorway does not lie in a wall between its spaces.
    """
    return tuple(_opening(map, doorway) for doorway in map.doorway)


def signs(map: Map) -> tuple[Sign, ...]:
    """Return all pairs of tags: two for a doorway, one for any other landmark."""
    made: list[Sign] = []
    for opening in openings(map):
        doorway = opening.doorway
        left, bottom, right, top = opening.box
        for space, side in zip(
            doorway.joins, (opening.side, _opposite(opening.side)), strict=True
        ):
            x = {"east": left, "west": right}.get(side, (left + right) / 2)
            y = {"north": bottom, "south": top}.get(side, (bottom + top) / 2)
            made.append(
                Sign(
                    doorway.name,
                    space,
                    opening.floor,
                    x,
                    y,
                    NORMALS[side],
                    doorway.tags,
                    doorway.apart,
                    doorway.says or doorway.name,
                )
            )
    for mark in map.landmark:
        made.append(_sign(map.named_space(mark.space), mark))
    return tuple(made)


def _sign(space: Space, mark: Landmark) -> Sign:
    left, bottom, right, top = space.box
    x = {"east": right, "west": left}.get(mark.wall, mark.at)
    y = {"north": top, "south": bottom}.get(mark.wall, mark.at)
    return Sign(
        mark.name,
        space.name,
        space.floors[0],
        x,
        y,
        NORMALS[mark.wall],
        mark.tags,
        mark.apart,
        mark.says or mark.name,
    )


def _opposite(side: Side) -> Side:
    pairs: dict[Side, Side] = {
        "north": "south",
        "south": "north",
        "east": "west",
        "west": "east",
    }
    return pairs[side]


def _opening(map: Map, doorway: Doorway) -> Opening:
    first, second = (map.named_space(name) for name in doorway.joins)
    floors = [floor for floor in first.floors if floor in second.floors]
    if len(floors) != 1:
        raise MapError(f"the spaces of `{doorway.name}` share no single floor")
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
        f"`{doorway.name}` does not lie in a wall between `{first.name}` and "
        f"`{second.name}`"
    )


def _check(map: Map) -> None:
    names: list[str] = [space.name for space in map.space]
    marks: list[str] = [mark.name for mark in map.doorway]
    marks += (mark.name for mark in map.landmark)
    for kind, listed in (("space", names), ("landmark", marks)):
        for twice in listed:
            if listed.count(twice) > 1:
                raise MapError(f"two {kind}s are named `{twice}`")
    for owner, used in _used_spaces(map):
        if used not in names:
            raise MapError(f"{owner} names the space `{used}`, which is not there")
    if map.start not in [mark.name for mark in map.landmark]:
        raise MapError(f"`start` is no landmark on a wall: `{map.start}`")
    for space in map.space:
        if space.kind != "lift" and len(space.floors) != 1:
            raise MapError(f"`{space.name}` is on several floors and is no lift")
        if space.box[0] >= space.box[2] or space.box[1] >= space.box[3]:
            raise MapError(f"`{space.name}` has no area")
    if sum(space.kind == "lift" for space in map.space) > 1:
        raise MapError("there is more than one lift")
    _check_overlaps(map)
    openings(map)
    hung = signs(map)
    _check_tags(hung)
    _check_obstacles(map, hung)


def _used_spaces(map: Map) -> Iterator[tuple[str, str]]:
    for doorway in map.doorway:
        for name in doorway.joins:
            yield f"`{doorway.name}`", name
    for mark in map.landmark:
        yield f"`{mark.name}`", mark.space
    for person in map.person:
        yield "a person", person.space


def _check_overlaps(map: Map) -> None:
    for number, one in enumerate(map.space):
        for other in map.space[number + 1 :]:
            if set(one.floors) & set(other.floors) and _overlap(one.box, other.box):
                raise MapError(f"`{one.name}` and `{other.name}` overlap")


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _check_obstacles(map: Map, hung: Sequence[Sign]) -> None:
    """Nothing stands where people begin, or where the robot is to stand."""
    spots = [(f"`{s.landmark}` in `{s.space}`", s.floor, s.front(1.0)) for s in hung]
    for person in map.person:
        space = map.named_space(person.space)
        left, bottom, right, top = space.box
        middle = ((left + right) / 2, (bottom + top) / 2)
        spots.append((f"somebody in `{space.name}`", space.floors[0], middle))
    for obstacle in map.obstacle:
        left, bottom, right, top = obstacle.box
        for who, floor, (x, y) in spots:
            off = math.hypot(x - min(max(x, left), right), y - min(max(y, bottom), top))
            if floor == obstacle.floor and off < FREE:
                raise MapError(
                    f"the obstacle {list(obstacle.box)} is too near to {who}"
                )


def _check_tags(signs: Sequence[Sign]) -> None:
    """Every code belongs to one landmark, on which it is left or right."""
    owners: dict[int, tuple[str, int]] = {}
    for sign in signs:
        for place, code in enumerate(sign.tags):
            if owners.setdefault(code, (sign.landmark, place)) != (
                sign.landmark,
                place,
            ):
                raise MapError(f"the tag {code} is used twice")
