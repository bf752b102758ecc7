"""Maps as TOML texts: read, and held against themselves.

The maps that come with rapc are files of the folder `maps`, by their names.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from importlib.resources import files
from typing import Any

import msgspec

from rapc.worlds.hallway.map import (
    Box,
    Landmark,
    Map,
    MapError,
    Opening,
    Sign,
    Space,
    middle,
    openings,
    signs,
)

FREE = 0.4
"""What is free around somebody, and around the robot before a landmark, in metres."""

_MAPS = files("rapc.worlds.hallway") / "maps"
_SUFFIX = ".toml"
_PLACE = re.compile(r"(?P<said>.*) - at `\$(?P<path>.*)`", re.DOTALL)
_STEP = re.compile(r"\.(\w+)|\[(\d+)\]")


def map_names() -> list[str]:
    """Return the names of the maps that come with rapc, sorted."""
    names = (file.name for file in _MAPS.iterdir())
    return sorted(n.removesuffix(_SUFFIX) for n in names if n.endswith(_SUFFIX))


def named_map(name: str) -> Map:
    """Return a map that comes with rapc.

    Raises:
        MapError: if none has that name.
    """
    if name not in map_names():
        known = ", ".join(f"`{one}`" for one in map_names())
        raise MapError(f"no map is called `{name}`; there are {known}")
    return read_map((_MAPS / f"{name}{_SUFFIX}").read_text(encoding="utf-8"))


def read_map(text: str) -> Map:
    """Return the map that a TOML text describes.

    Raises:
        MapError: if the text is none, with line or key; or if the map contradicts
            itself.
    """
    try:
        raw = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise MapError(f"no TOML: {error}") from error
    try:
        made = msgspec.convert(raw, Map)
    except msgspec.ValidationError as error:
        raise MapError(_placed(str(error), raw)) from error
    _check(made)
    return made


def _placed(told: str, raw: Mapping[str, Any]) -> str:
    """Return what msgspec says is wrong with a text, its place in words.

    `$.doorway[3].at` becomes `at` of the doorway `office-door`, or of doorway 4.
    """
    found = _PLACE.fullmatch(told)
    if found is None:
        return told.lower()
    said = found["said"].replace("Object contains", "there is an").replace("Obj", "obj")
    said = said[:1].lower() + said[1:]
    match [word or int(at) for word, at in _STEP.findall(found["path"])]:
        case [str(kind), int(at), *rest]:
            entry = raw[kind][at]
            name = entry.get("name") if isinstance(entry, dict) else None
            owner = f"{kind} {at + 1}" if name is None else f"the {kind} `{name}`"
            key = f"`{rest[0]}` of " if rest else ""
            return f"{key}{owner}: {said}"
        case [str(key), *_]:
            return f"`{key}`: {said}"
    return said


def _check(map: Map) -> None:
    """Raise MapError if a map contradicts itself."""
    _check_names(map)
    for space in map.space:
        if space.kind != "lift" and len(space.floors) != 1:
            raise MapError(f"`{space.name}` is on several floors and is no lift")
        if len(set(space.floors)) != len(space.floors):
            raise MapError(f"`{space.name}` is twice on one floor")
        if not _has_area(space.box):
            raise MapError(f"`{space.name}` has no area")
    if sum(space.kind == "lift" for space in map.space) > 1:
        raise MapError("there is more than one lift")
    _check_overlaps(map)
    gaps, hung = openings(map), signs(map)
    _check_tags(hung)
    for mark in map.landmark:
        _check_wall(map.named_space(mark.space), mark, gaps)
    _check_obstacles(map, hung)


def _check_names(map: Map) -> None:
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


def _used_spaces(map: Map) -> Iterator[tuple[str, str]]:
    for doorway in map.doorway:
        for name in doorway.joins:
            yield f"`{doorway.name}`", name
    for mark in map.landmark:
        yield f"`{mark.name}`", mark.space
    for person in map.person:
        yield "a person", person.space


def _has_area(box: Box) -> bool:
    return box[0] < box[2] and box[1] < box[3]


def _check_overlaps(map: Map) -> None:
    for number, one in enumerate(map.space):
        for other in map.space[number + 1 :]:
            if set(one.floors) & set(other.floors) and _overlap(one.box, other.box):
                raise MapError(f"`{one.name}` and `{other.name}` overlap")


def _overlap(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _check_wall(space: Space, mark: Landmark, gaps: Sequence[Opening]) -> None:
    """A landmark hangs on its wall, with both tags, and not in a doorway."""
    along = 1 if mark.wall in {"east", "west"} else 0
    low, high = mark.at - mark.apart / 2, mark.at + mark.apart / 2
    if low < space.box[along] or high > space.box[along + 2]:
        raise MapError(
            f"`{mark.name}` does not hang on the {mark.wall} wall of `{space.name}`"
        )
    across = {"west": 0, "south": 1, "east": 2, "north": 3}[mark.wall]
    for gap in gaps:
        mine = space.name in gap.doorway.joins
        touches = space.box[across] in (gap.box[across], gap.box[(across + 2) % 4])
        if mine and touches and gap.box[along] < high and low < gap.box[along + 2]:
            raise MapError(f"`{mark.name}` hangs in the doorway `{gap.doorway.name}`")


def _check_obstacles(map: Map, hung: Sequence[Sign]) -> None:
    """Nothing stands where people begin, or where the robot is to stand."""
    spots = [(f"`{s.landmark}` in `{s.space}`", s.floor, s.front(1.0)) for s in hung]
    for person in map.person:
        space = map.named_space(person.space)
        spots.append(
            (f"somebody in `{space.name}`", space.floors[0], middle(space.box))
        )
    for obstacle in map.obstacle:
        left, bottom, right, top = obstacle.box
        told = f"the obstacle {list(obstacle.box)}"
        if not _has_area(obstacle.box):
            raise MapError(f"{told} has no area")
        floor = [space.box for space in map.space if obstacle.floor in space.floors]
        if not any(_overlap(box, obstacle.box) for box in floor):
            raise MapError(f"{told} is in no space of floor {obstacle.floor}")
        for who, level, (x, y) in spots:
            off = math.hypot(x - min(max(x, left), right), y - min(max(y, bottom), top))
            if level == obstacle.floor and off < FREE:
                raise MapError(f"{told} is too near to {who}")


def _check_tags(signs: Sequence[Sign]) -> None:
    """Every code belongs to one landmark, on which it is left or right."""
    owners: dict[int, tuple[str, int]] = {}
    for sign in signs:
        for place, code in enumerate(sign.tags):
            owner = (sign.landmark, place)
            if owners.setdefault(code, owner) != owner:
                raise MapError(f"the tag {code} is used twice")
