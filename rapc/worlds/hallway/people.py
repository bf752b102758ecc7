"""People who walk about, and never into the robot."""

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
"""What a person leaves between the robot and themselves."""

PATIENCE = 2.0
"""Seconds for which somebody waits for the robot to go before turning elsewhere."""

POLITE = 1.2
"""Nobody stands about for long so near to the robot, or to a doorway, in metres."""

STEP_ASIDE = 0.7
"""How far from a doorway's middle somebody begins to walk through, in metres."""


class Walker(msgspec.Struct):
    """Somebody, and where they are going."""

    x: float
    y: float
    floor: int
    space: str
    speed: float
    #: Points to walk to, the next one first.
    way: list[tuple[float, float]] = []
    #: The space at the end of the way.
    towards: str = ""
    #: Seconds for which they stay where they are.
    pause: float = 0.0
    #: Seconds for which they have been held up.
    held: float = 0.0
    #: The doorway out of which they turned back; it is not tried again before they have
    #: been elsewhere.
    barred: str = ""


class Surroundings(msgspec.Struct, frozen=True):
    """What people see of the building."""

    map: Map
    plans: Mapping[int, FloorPlan]
    openings: Sequence[Opening]


def everybody(map: Map) -> list[Walker]:
    """Return the people of a map where they begin."""
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
) -> None:
    """Let somebody live for some time.

    Args:
        walker: who.
        around: the building as it is now.
        robot: its place and radius, if it is on the same floor.
        rng: the stream of all people.
        seconds: how long.
    """
    if walker.pause > 0:
        walker.pause -= seconds
        if robot and math.hypot(robot[0] - walker.x, robot[1] - walker.y) < POLITE:
            walker.pause = min(walker.pause, PATIENCE)
        return
    if not walker.way:
        _choose(walker, around, rng)
        return
    at = x, y = walker.way[0]
    away = math.hypot(x - walker.x, y - walker.y)
    step = min(away, walker.speed * seconds)
    if away > 0:
        x = walker.x + (x - walker.x) / away * step
        y = walker.y + (y - walker.y) / away * step
    if _held_up(walker, around, robot, x, y):
        walker.held += seconds
        if walker.held >= PATIENCE:
            _turn_elsewhere(walker, around)
        return
    walker.x, walker.y, walker.held = x, y, 0.0
    if step == away:
        walker.way.pop(0)
        if not walker.way:
            walker.space = walker.towards
            if not any(_near(gap, *at) for gap in _doors(walker, around)):
                walker.barred = ""
                walker.pause = rng.choice((0.0, 0.0, 1.0, 4.0, 15.0))


def _held_up(
    walker: Walker,
    around: Surroundings,
    robot: tuple[float, float, float] | None,
    x: float,
    y: float,
) -> bool:
    """Whether the robot, or a door that has closed, is in the way of a step."""
    if robot is not None:
        rx, ry, radius = robot
        near = math.hypot(rx - x, ry - y)
        nearer = near < math.hypot(rx - walker.x, ry - walker.y)
        if nearer and near < radius + GIRTH + ROOM:
            return True
    return around.plans[walker.floor].nearest(x, y, 0.1)[0] < 0.1


def _turn_elsewhere(walker: Walker, around: Surroundings) -> None:
    """Let somebody who is held up go where nobody is in the way.

    Who is on the way through a doorway first goes back out of it, for whoever stands in
    there has no other way than the one that is taken.
    """
    through, walker.way, walker.held = walker.towards != walker.space, [], 0.0
    walker.towards = walker.space
    for gap in _doors(walker, around) if through else ():
        if _near(gap, walker.x, walker.y):
            space = around.map.named_space(walker.space)
            walker.way = _through(gap, around.map, space)[0][:1]
            walker.barred = gap.doorway.name


def _doors(walker: Walker, around: Surroundings) -> list[Opening]:
    """Return the doorways of the space that somebody is in."""
    here = [gap for gap in around.openings if gap.floor == walker.floor]
    return [gap for gap in here if walker.space in gap.doorway.joins]


def _choose(walker: Walker, around: Surroundings, rng: Random) -> None:
    """Give somebody something to walk to, or a little rest."""
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
    """The way through a doorway, out of a space, and where it leads."""
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
    """Whether a person fits along a straight line, closed doors in mind."""
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
