"""People who walk about; careless people walk into the robot."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from random import Random

import msgspec

from rapc.worlds.hallway.map import Map, Opening, Space, middle
from rapc.worlds.hallway.plan import FloorPlan

GIRTH = 0.25
"""The radius of a person, in metres."""

ROOM = 0.35
"""The minimum distance that a person keeps from the robot, in metres."""

PATIENCE = 2.0
"""The time that a person waits for the robot before turning elsewhere, in seconds."""

POLITE = 1.2
"""The distance that a standing person keeps from robot and doorways, in metres."""

CONTACT = 0.1
"""The distance from the robot at which a careless person walks into the robot, in
metres: more than the way of the robot in a tick.
"""

SHOVE = 0.3
"""The duration of the push by a person who walks into the robot, in seconds."""

STEP_ASIDE = 0.7
"""The distance from a doorway's middle at which a person starts through, in metres."""


class Walker(msgspec.Struct):
    """A person with a destination."""

    x: float
    y: float
    floor: int
    space: str
    speed: float
    #: The points of the way, the next point first.
    way: list[tuple[float, float]] = []
    #: The space at the end of the way.
    towards: str = ""
    #: The seconds left of a pause.
    pause: float = 0.0
    #: The seconds of the present hold-up.
    held: float = 0.0
    #: The doorway at which the person turned back. The person does not try this doorway
    #: again before visiting another space.
    barred: str = ""
    #: Whether the person does not look out for the robot on this way.
    careless: bool = False


class Surroundings(msgspec.Struct, frozen=True):
    """The building as people see it."""

    map: Map
    plans: Mapping[int, FloorPlan]
    openings: Sequence[Opening]


def everybody(map: Map) -> list[Walker]:
    """Return the people of a map at their start."""
    made = []
    for person in map.person:
        space = map.named_space(person.space)
        x, y = middle(space.box)
        made.append(Walker(x, y, space.floors[0], space.name, person.speed))
    return made


def walk(
    walker: Walker,
    around: Surroundings,
    robot: tuple[float, float, float] | None,
    rng: Random,
    seconds: float,
    careless: float = 0.0,
) -> bool:
    """Advance a person by some time; return whether the person runs into the robot.

    Args:
        walker: the person.
        around: the present state of the building.
        robot: its position and radius, if it is on the same floor.
        rng: the stream of all people.
        seconds: the time.
        careless: the part of their ways on which people do not look out for the robot.
    """
    if walker.pause > 0:
        walker.pause -= seconds
        if robot and math.hypot(robot[0] - walker.x, robot[1] - walker.y) < POLITE:
            walker.pause = min(walker.pause, PATIENCE)
        return False
    if not walker.way:
        _choose(walker, around, rng)
        walker.careless = careless > 0 and rng.random() < careless
        return False
    at = x, y = walker.way[0]
    away = math.hypot(x - walker.x, y - walker.y)
    step = min(away, walker.speed * seconds)
    if away > 0:
        x = walker.x + (x - walker.x) / away * step
        y = walker.y + (y - walker.y) / away * step
    meets = robot is not None and _meets(walker, robot, x, y)
    if meets or around.plans[walker.floor].nearest(x, y, 0.1)[0] < 0.1:
        ran = meets and walker.careless
        walker.careless = walker.careless and not ran
        walker.held += seconds
        if walker.held >= PATIENCE:
            _turn_elsewhere(walker, around)
        return ran
    walker.x, walker.y, walker.held = x, y, 0.0
    if step == away:
        walker.way.pop(0)
        if not walker.way:
            walker.space = walker.towards
            if not any(_near(gap, *at) for gap in _doors(walker, around)):
                walker.barred = ""
                walker.pause = rng.choice((0.0, 0.0, 1.0, 4.0, 15.0))
    return False


def _meets(
    walker: Walker, robot: tuple[float, float, float], x: float, y: float
) -> bool:
    """Return whether the robot blocks the next step of a person."""
    rx, ry, radius = robot
    near = math.hypot(rx - x, ry - y)
    nearer = near < math.hypot(rx - walker.x, ry - walker.y)
    keeps = CONTACT if walker.careless else ROOM
    return nearer and near < radius + GIRTH + keeps


def _turn_elsewhere(walker: Walker, around: Surroundings) -> None:
    """Turn a held-up person to a free place.

    A person on the way through a doorway first goes back out, because the robot in the
    doorway has no other way.
    """
    through, walker.way, walker.held = walker.towards != walker.space, [], 0.0
    walker.towards = walker.space
    for gap in _doors(walker, around) if through else ():
        if _near(gap, walker.x, walker.y):
            space = around.map.named_space(walker.space)
            walker.way = _through(gap, around.map, space)[0][:1]
            walker.barred = gap.doorway.name


def _doors(walker: Walker, around: Surroundings) -> list[Opening]:
    """Return the doorways of a person's space."""
    here = [gap for gap in around.openings if gap.floor == walker.floor]
    return [gap for gap in here if walker.space in gap.doorway.joins]


def _choose(walker: Walker, around: Surroundings, rng: Random) -> None:
    """Choose a destination or a short rest for a person."""
    space = around.map.named_space(walker.space)
    doors = _doors(walker, around)
    tried = [gap for gap in doors if gap.doorway.name != walker.barred]
    if tried and rng.random() < 0.3:
        way, towards = _through(rng.choice(tried), around.map, space)
    else:
        left, bottom, right, top = space.box
        x = rng.uniform(left + 0.5, max(left + 0.5, right - 0.5))
        y = rng.uniform(bottom + 0.5, max(bottom + 0.5, top - 0.5))
        way, towards = [(x, y)], space.name
        if any(_near(gap, x, y) for gap in doors):
            walker.pause = 0.5
            return
    plan, kind = around.plans[walker.floor], around.map.named_space(towards).kind
    legs = pairwise([(walker.x, walker.y), *way])
    if kind != "lift" and all(_free(plan, *leg) for leg in legs):
        walker.way, walker.towards = way, towards
    else:
        walker.pause = 0.5


def _through(
    gap: Opening, map: Map, space: Space
) -> tuple[list[tuple[float, float]], str]:
    """Return the way out of a space through a doorway, and the space beyond."""
    first, second = gap.doorway.joins
    x, y = middle(gap.box)
    across = gap.side in {"east", "west"}
    onwards = (gap.side in {"east", "north"}) != (space.name == second)
    step = STEP_ASIDE if onwards else -STEP_ASIDE
    dx, dy = (step, 0.0) if across else (0.0, step)
    towards = second if space.name == first else first
    return [(x - dx, y - dy), (x + dx, y + dy)], towards


def _free(
    plan: FloorPlan, start: tuple[float, float], end: tuple[float, float]
) -> bool:
    """Return whether a person fits along a straight line; closed doors are walls."""
    away = math.hypot(end[0] - start[0], end[1] - start[1])
    if away < 1e-6:
        return True
    dx, dy = (end[0] - start[0]) / away, (end[1] - start[1]) / away
    for aside in (-0.3, 0.0, 0.3):
        x, y = start[0] - dy * aside, start[1] + dx * aside
        left = away
        while left > 0:
            piece = min(left, 5.0)
            if plan.cast(x, y, dx, dy, piece) < piece:
                return False
            x, y, left = x + dx * piece, y + dy * piece, left - piece
    return True


def _near(gap: Opening, x: float, y: float) -> bool:
    return math.dist(middle(gap.box), (x, y)) < POLITE
