"""Checks that a map is consistent, and that the robot's skills can handle the building.

A `MapError` has one line: the key with its doorway, landmark or space, then the fault.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rapc.worlds.hallway.map import (
    NORMALS,
    Box,
    Doorway,
    Landmark,
    Map,
    Sign,
    Space,
    middle,
    signs,
)
from rapc.worlds.hallway.planner import shortest
from rapc.worlds.hallway.simulation import STANDOFF
from rapc.worlds.maps import MapError

FREE = 0.4
"""Free space around a person, and around the robot before a landmark, in metres."""


Mark = Doorway | Landmark
"""An entry with tags."""


def check_map(map: Map) -> None:
    """Validate a map; raise MapError with the first fault."""
    marks: list[Mark] = [*map.doorway, *map.landmark]
    _check_names(map, marks)
    _check_spaces(map)
    for mark in marks:
        _check_codes(mark)
    _check_tags(marks)
    for doorway in map.doorway:
        if doorway.apart < doorway.width:
            raise MapError(
                f"`apart` of {_named(doorway)}: expected at least its width "
                f"{doorway.width}, not `{doorway.apart}`"
            )
    hung = signs(map)
    by_name = {mark.name: mark for mark in marks}
    for sign in hung:
        _check_place(by_name[sign.landmark], sign, map.named_space(sign.space))
    _check_shared_walls(by_name, hung)
    _check_obstacles(map, hung)
    _check_ways(map)


def _named(entry: Space | Mark) -> str:
    """Return the name of an entry for messages: the doorway `d`."""
    return f"the {type(entry).__name__.lower()} `{entry.name}`"


def _check_names(map: Map, marks: Sequence[Mark]) -> None:
    """Check that names are unique, and that references to spaces are valid."""
    spaces = {space.name for space in map.space}
    kinds: tuple[Sequence[Space | Mark], ...] = (map.space, marks)
    for entries in kinds:
        named: dict[str, Space | Mark] = {}
        for entry in entries:
            other = named.setdefault(entry.name, entry)
            if other is not entry:
                raise MapError(f"`name` of {_named(entry)}: duplicate")
    for key, used in _used_spaces(map):
        if used not in spaces:
            raise MapError(f"{key}: unknown space `{used}`")
    if map.start not in [mark.name for mark in map.landmark]:
        raise MapError(f"`start`: expected a landmark, not `{map.start}`")


def _used_spaces(map: Map) -> Iterator[tuple[str, str]]:
    for doorway in map.doorway:
        for name in doorway.joins:
            yield f"`joins` of {_named(doorway)}", name
    for mark in map.landmark:
        yield f"`space` of {_named(mark)}", mark.space
    for number, person in enumerate(map.person, 1):
        yield f"`space` of person {number}", person.space


def _check_spaces(map: Map) -> None:
    """Check the boxes and the floors of the spaces."""
    lifts = [space for space in map.space if space.kind == "lift"]
    if len(lifts) > 1:
        raise MapError(f"`kind` of {_named(lifts[1])}: there is another lift")
    for space in map.space:
        if space.kind != "lift" and len(space.floors) != 1:
            raise MapError(f"`floors` of {_named(space)}: only a lift has several")
        if len(set(space.floors)) != len(space.floors):
            raise MapError(f"`floors` of {_named(space)}: duplicate floor")
        if not _has_area(space.box):
            raise MapError(f"`box` of {_named(space)}: no area")
    for number, one in enumerate(map.space):
        for other in map.space[number + 1 :]:
            if set(one.floors) & set(other.floors) and _overlap(one.box, other.box):
                raise MapError(f"`box` of {_named(other)}: overlaps {_named(one)}")


def _has_area(box: Box) -> bool:
    return box[0] < box[2] and box[1] < box[3]


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _check_codes(mark: Mark) -> None:
    """Check that `see-tags` recognises the two codes as a pair."""
    left, right = mark.tags
    if left % 2 or right != left + 1:
        raise MapError(
            f"`tags` of {_named(mark)}: expected an even code and the next one, "
            f"not `{list(mark.tags)}`"
        )


def _check_tags(marks: Sequence[Mark]) -> None:
    """Check that each pair of tags belongs to one landmark."""
    owners: dict[tuple[int, int], Mark] = {}
    for mark in marks:
        other = owners.setdefault(mark.tags, mark)
        if other is not mark:
            raise MapError(
                f"`tags` of {_named(mark)}: {_named(other)} has the same tags"
            )


def _check_place(mark: Mark, sign: Sign, space: Space) -> None:
    """Check that tags are on their wall, and that the robot has room before them."""
    low, high = _extent(sign)
    along = _axis(sign)
    near, far = space.box[along], space.box[along + 2]
    if low < near or high > far:
        raise MapError(
            f"`at` of {_named(mark)}: a tag is beyond the wall of {_named(space)}"
        )
    if mark.at < near + FREE or mark.at > far - FREE:
        raise MapError(
            f"`at` of {_named(mark)}: less than {FREE} m from a corner of "
            f"{_named(space)}"
        )
    if space.box[3 - along] - space.box[1 - along] < STANDOFF + FREE:
        raise MapError(
            f"`box` of {_named(space)}: less than {STANDOFF + FREE} m before "
            f"{_named(mark)}"
        )


def _axis(sign: Sign) -> int:
    """Return the axis along the wall of a sign: 0 for x, 1 for y."""
    return 1 if sign.normal in {NORMALS["east"], NORMALS["west"]} else 0


def _extent(sign: Sign) -> tuple[float, float]:
    """Return the ends of the tags' extent along their wall."""
    at = (sign.x, sign.y)[_axis(sign)]
    return at - sign.apart / 2, at + sign.apart / 2


def _check_shared_walls(marks: dict[str, Mark], hung: Sequence[Sign]) -> None:
    """Check that no landmark lies between or over the tags of another landmark."""
    for number, one in enumerate(hung):
        low, high = _extent(one)
        for other in hung[number + 1 :]:
            first, last = _extent(other)
            wall = (one.space, one.floor, one.normal)
            if wall == (other.space, other.floor, other.normal) and (
                low < last and first < high
            ):
                raise MapError(
                    f"`at` of {_named(marks[other.landmark])}: overlaps "
                    f"{_named(marks[one.landmark])} on a wall of `{one.space}`"
                )


def _check_obstacles(map: Map, hung: Sequence[Sign]) -> None:
    """Check that obstacles leave free each start and the place before each landmark."""
    spots = [
        (f"`{s.landmark}` in `{s.space}`", s.floor, s.front(STANDOFF)) for s in hung
    ]
    for person in map.person:
        space = map.named_space(person.space)
        spots.append(
            (f"somebody in `{space.name}`", space.floors[0], middle(space.box))
        )
    for number, obstacle in enumerate(map.obstacle, 1):
        left, bottom, right, top = obstacle.box
        told = f"`box` of obstacle {number}"
        if not _has_area(obstacle.box):
            raise MapError(f"{told}: no area")
        floor = [space.box for space in map.space if obstacle.floor in space.floors]
        if not any(_overlap(box, obstacle.box) for box in floor):
            raise MapError(f"{told}: in no space of floor {obstacle.floor}")
        for who, level, (x, y) in spots:
            off = math.hypot(x - min(max(x, left), right), y - min(max(y, bottom), top))
            if level == obstacle.floor and off < FREE:
                raise MapError(f"{told}: less than {FREE} m from {who}")


def _check_ways(map: Map) -> None:
    """Check that doorways lead from the start to every space."""
    joins = [doorway.joins for doorway in map.doorway]
    joined = [(a, "", b) for pair in joins for a, b in (pair, pair[::-1])]
    start = next(mark.space for mark in map.landmark if mark.name == map.start)
    for space in map.space:
        if space.name != start and not shortest(joined, start, space.name):
            raise MapError(f"{_named(space)}: no doorways lead there from `start`")
