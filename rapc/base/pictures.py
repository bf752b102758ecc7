"""Pictures of a world for people: the truth at a time, as data for drawing.

A picture has the truth and the prefixes of the facts that memory would hold. A reader
of pictures can compare both, and the world needs no access to memory.

Pictures that follow each other are written as changes: the form is a JSON merge patch
(RFC 7396), in which null removes a key.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, TypeVar, get_args

import msgspec

from rapc.base.values import Atom, Fact

T = TypeVar("T")

Point = tuple[float, float]
"""A point on a plan: to the right and up, in metres."""

Pose = tuple[float, float, float]
"""A point on a plan and a direction, counter-clockwise in radians."""

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

Rectangle = tuple[float, float, float, float]
"""Left, bottom, right and top on a plan."""


class Thing(msgspec.Struct, frozen=True):
    """An item in a picture: its class and, if known, its look (`red`)."""

    kind: str
    look: Atom | None = None


class Spot(msgspec.Struct, frozen=True):
    """A spot for things: a place by its name in memory, an arm, a bay.

    `at` is the position on the drawn map, in steps to the right and down from any
    origin; None for a spot that the robot carries. `things` are all things at the spot,
    with the things inside of other things. `note` is a short remark.
    """

    name: str
    things: tuple[Thing, ...] = ()
    at: tuple[float, float] | None = None
    note: str = ""


class Gauge(msgspec.Struct, frozen=True):
    """A quantity or state of the robot, and the believed fact without the value."""

    name: str
    value: Atom
    believed: Fact


class Area(msgspec.Struct, frozen=True):
    """A space on a plan, labelled with its name."""

    name: str
    box: Rectangle


class Door(msgspec.Struct, frozen=True):
    """A doorway on a plan that can be closed."""

    name: str
    #: The middle of the doorway.
    at: Point
    closed: bool
    #: The fact in memory for a closed doorway.
    believed: Fact = ()
    #: The lifetime of the fact in time units; None: no limit.
    counts: float | None = None


class Mark(msgspec.Struct, frozen=True):
    """A landmark on a plan."""

    name: str
    at: Point
    #: The pattern of the fact in memory about the landmark; None matches any value.
    believed: tuple[Atom | None, ...] = ()


class Stand(msgspec.Struct, frozen=True):
    """The pose on a plan in front of a landmark of a space."""

    landmark: str
    space: str
    pose: Pose


class Reckoning(msgspec.Struct, frozen=True):
    """The transformation from the robot's frame of odometry to a plan.

    A robot reckons its pose in its own frame. The pose in front of a landmark, in the
    plan and in the frame, determines the transformation.
    """

    #: The prefix of the fact with the robot's x, y and heading.
    place: Fact
    #: The prefix of the fact with a landmark, x, y and heading: the origin.
    origin: Fact
    #: The prefix of the fact with the robot's space.
    area: Fact
    #: The pose on the plan in front of each landmark of each space.
    stands: tuple[Stand, ...]


class Plan(msgspec.Struct, frozen=True):
    """A floor seen from above, true to scale."""

    areas: tuple[Area, ...]
    #: Straight walls, from one end to the other.
    walls: tuple[tuple[Point, Point], ...]
    #: Obstacles.
    blocks: tuple[Rectangle, ...] = ()
    doors: tuple[Door, ...] = ()
    marks: tuple[Mark, ...] = ()
    #: Other agents.
    others: tuple[Point, ...] = ()
    #: The pose of the robot, if it is on this floor.
    robot: Pose | None = None
    #: The end points of the last range readings, a point for each ray from the robot.
    echoes: tuple[Point, ...] = ()
    reckoning: Reckoning | None = None


class Picture(msgspec.Struct, frozen=True):
    """The truth in a world at a time, for drawing; independent of the robot.

    - `here`: the name of the robot's spot;
    - `heading`: the direction of the robot, a point of the compass, or nothing;
    - `roads`: the pairs of connected spots;
    - `look`: the property in memory for the look of a thing;
    - `plan`: drawn in place of spots and roads if there is space;
    - `said`: the last words of the robot.
    """

    here: str
    spots: tuple[Spot, ...]
    roads: tuple[tuple[str, str], ...] = ()
    heading: str = ""
    look: str = ""
    gauges: tuple[Gauge, ...] = ()
    plan: Plan | None = None
    said: str = ""


def outermost(place: T, places: Mapping[T, T]) -> T:
    """Return the place of a place of a place, and so on; `places` may have circles."""
    passed = {place}
    while place in places and places[place] not in passed:
        place = places[place]
        passed.add(place)
    return place


# --- pictures as plain data -----------------------------------------------------------

_DIGITS = 3
"""The digits after the point in the numbers of a plan: millimetres."""


def plain(picture: Picture) -> dict[str, Any]:
    """Return a picture as a JSON object, without keys whose value is None."""
    found: dict[str, Any] = _without_none(msgspec.to_builtins(picture))
    if "plan" in found:
        found["plan"] = _rounded(found["plan"])
    return found


def from_plain(data: Mapping[str, Any]) -> Picture:
    """Return the picture in a JSON object; raise ValueError for invalid data."""
    return msgspec.convert(data, Picture)


def change(before: Mapping[str, Any], after: Mapping[str, Any]) -> dict[str, Any]:
    """Return the merge patch that changes an object into another."""
    found: dict[str, Any] = dict.fromkeys(key for key in before if key not in after)
    for key, value in after.items():
        old = before.get(key)
        if isinstance(old, Mapping) and isinstance(value, Mapping):
            if inner := change(old, value):
                found[key] = inner
        elif key not in before or old != value:
            found[key] = value
    return found


def changed(before: Mapping[str, Any], patch: Mapping[str, Any]) -> dict[str, Any]:
    """Return an object after a merge patch."""
    found = dict(before)
    for key, value in patch.items():
        if value is None:
            found.pop(key, None)
        elif isinstance(value, Mapping):
            old = found.get(key)
            found[key] = changed(old if isinstance(old, Mapping) else {}, value)
        else:
            found[key] = value
    return found


def _without_none(data: Any) -> Any:
    if isinstance(data, dict):
        return {k: _without_none(v) for k, v in data.items() if v is not None}
    return data


def _rounded(data: Any) -> Any:
    if isinstance(data, float):
        return round(data, _DIGITS)
    if isinstance(data, dict):
        return {key: _rounded(value) for key, value in data.items()}
    return [_rounded(one) for one in data] if isinstance(data, list | tuple) else data
