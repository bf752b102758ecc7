"""Pictures of a world for people: what is true at a time, as data to be drawn.

A picture names, beside what is true, the facts in which memory would hold it. So who
draws it can set the one against the other, and the world knows nothing of memory.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, get_args

import msgspec

from rapc.base.values import Atom, Fact

Point = tuple[float, float]
"""A place on a plan: to the right and up, in metres."""

Pose = tuple[float, float, float]
"""A place on a plan and the direction faced there, counter-clockwise in radians."""

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
    """An item in a picture: its class, and what it looks like (`red`), if anything."""

    kind: str
    look: Atom | None = None


class Spot(msgspec.Struct, frozen=True):
    """Where things are: a place by the name that memory has for it, an arm, a bay.

    `at` is where it is drawn on the map, in steps to the right and down from
    anywhere; None for what the robot carries along. `things` are all that it holds,
    what is inside of other things too; `note` says in a few words what else is so.
    """

    name: str
    things: tuple[Thing, ...] = ()
    at: tuple[float, float] | None = None
    note: str = ""


class Gauge(msgspec.Struct, frozen=True):
    """A quantity or state of the robot, and the fact, up to it, that believes it."""

    name: str
    value: Atom
    believed: Fact


class Area(msgspec.Struct, frozen=True):
    """A space on a plan, to be labelled with its name."""

    name: str
    box: Rectangle


class Door(msgspec.Struct, frozen=True):
    """A doorway on a plan that can be closed."""

    name: str
    #: Its middle.
    at: Point
    closed: bool
    #: The fact by which memory holds the doorway to be closed.
    believed: Fact = ()
    #: For how many time units that fact counts; None: for ever.
    counts: float | None = None


class Mark(msgspec.Struct, frozen=True):
    """A landmark on a plan."""

    name: str
    at: Point
    #: The fact by which memory knows it, None for what may be anything.
    believed: tuple[Atom | None, ...] = ()


class Reckoning(msgspec.Struct, frozen=True):
    """How the robot's own idea of its place is laid over a plan.

    A robot counts its way in a frame of its own. Where it stands before a landmark, as
    the plan has it, and where its frame has that, tell how the two lie.
    """

    #: The fact, up to x, y and heading, in which memory holds the robot's place.
    place: Fact
    #: The fact, up to a landmark with x, y and heading, from which memory counts.
    origin: Fact
    #: The fact, up to a space, in which memory holds where the robot is.
    area: Fact
    #: Where who is before a landmark of a space stands on the plan.
    stands: Mapping[tuple[str, str], Pose]


class Plan(msgspec.Struct, frozen=True):
    """A floor seen from above, true to scale."""

    areas: tuple[Area, ...]
    #: Straight walls, from one end to the other.
    walls: tuple[tuple[Point, Point], ...]
    #: What stands about.
    blocks: tuple[Rectangle, ...] = ()
    doors: tuple[Door, ...] = ()
    marks: tuple[Mark, ...] = ()
    #: Who else is there.
    others: tuple[Point, ...] = ()
    #: Where the robot is, if it is on this floor.
    robot: Pose | None = None
    #: Where what its sensors measured last ends, a point for each ray from the robot.
    echoes: tuple[Point, ...] = ()
    reckoning: Reckoning | None = None


class Picture(msgspec.Struct, frozen=True):
    """What is true in a world at a time, to be drawn; the robot has no part in it.

    `here` names the spot where the robot is, `heading` the direction it points in (a
    point of the compass, or nothing), `roads` the spots that are joined, `look` the
    property under which memory has what a thing looks like, `said` what the robot is
    heard to say. Where there is a `plan`, it is drawn in place of spots and roads if
    there is room.
    """

    here: str
    spots: tuple[Spot, ...]
    roads: tuple[tuple[str, str], ...] = ()
    heading: str = ""
    look: str = ""
    gauges: tuple[Gauge, ...] = ()
    plan: Plan | None = None
    said: str = ""
