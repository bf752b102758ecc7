"""The robot's body: two driven wheels, dead reckoning, sonars, a laser, a battery.

What the body senses is noisy, and what it does is not quite what it was told to do. The
noise of each part has a random stream of its own. Not here: collisions (`simulation`),
and anything that decides (`skills`).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from random import Random

import msgspec

from rapc.worlds.hallway.channels import (
    DIRECTIONS,
    LASER_RANGE,
    SONAR_RANGE,
    SONARS,
    TOP_SPEED,
    TOP_TURN,
    Drive,
    Pose,
    Tag,
)
from rapc.worlds.hallway.map import Sign
from rapc.worlds.hallway.plan import FloorPlan

TICK = 0.1
"""Seconds between two steps of everything."""

ACCELERATION = 0.8
"""Of the wheels, in metres a second, every second."""

TURN_ACCELERATION = 4.0

SONAR_NOISE = 0.012
DEAF = 0.1
"""How often, of all ticks, one of the sonars hears no echo."""

LASER_NOISE = 0.006
STEEPEST = math.cos(math.radians(75))
"""A tag that is turned away further than this cannot be read."""

IDLE_DRAIN = 0.008
DRIVE_DRAIN = 0.02
"""Per cent of the battery a second."""

CHARGING = 1.0

Circle = tuple[float, float, float]
"""Somebody: x, y and radius."""


class Robot(msgspec.Struct):
    """The state of the body; positions in metres, angles in radians."""

    x: float
    y: float
    heading: float
    floor: int
    #: How fast the body moves ahead and turns.
    speed: float = 0.0
    turn: float = 0.0
    #: Where dead reckoning takes it to be.
    reckoned_x: float = 0.0
    reckoned_y: float = 0.0
    reckoned_heading: float = 0.0
    #: In per cent.
    battery: float = 100.0
    charging: bool = False
    #: Driven so far.
    distance: float = 0.0
    #: Whether it stood against something in the last tick.
    touching: bool = False


class Wear(msgspec.Struct, frozen=True):
    """How the wheels of this robot differ from those on paper."""

    #: What a metre is measured as, above one.
    scale: float
    #: What a turn is measured as, above one.
    turn: float
    #: How much dead reckoning turns by itself on a metre.
    pull: float


def worn(rng: Random, drift: float) -> Wear:
    """Return the wear of a robot; `drift` 1 is usual, 0 none."""
    return Wear(
        rng.uniform(-0.02, 0.02) * drift,
        rng.uniform(-0.01, 0.01) * drift,
        rng.uniform(-0.004, 0.004) * drift,
    )


def set_speeds(robot: Robot, drive: Drive | None) -> None:
    """Bring the wheels nearer to what they are to do; without orders they brake."""
    wanted = drive or Drive(0.0, 0.0)
    speed = max(-TOP_SPEED, min(TOP_SPEED, wanted.speed))
    turn = max(-TOP_TURN, min(TOP_TURN, wanted.turn))
    robot.speed = _towards(robot.speed, speed, ACCELERATION * TICK)
    robot.turn = _towards(robot.turn, turn, TURN_ACCELERATION * TICK)


def move(
    robot: Robot, x: float, y: float, turned: float, wear: Wear, rng: Random
) -> None:
    """Put the body somewhere near, and let dead reckoning follow as it can.

    Args:
        robot: the body.
        x: where it is now.
        y: where it is now.
        turned: radians that it has turned.
        wear: of its wheels.
        rng: the stream of its slipping.
    """
    dx, dy, middle = x - robot.x, y - robot.y, robot.heading + turned / 2
    ahead = dx * math.cos(middle) + dy * math.sin(middle)
    aside = dy * math.cos(middle) - dx * math.sin(middle)
    robot.x, robot.y = x, y
    robot.distance += math.hypot(dx, dy)
    robot.heading = math.remainder(robot.heading + turned, 2 * math.pi)
    if ahead or aside or turned:
        _reckon(robot, ahead, aside, turned, wear, rng)


def _reckon(
    robot: Robot, ahead: float, aside: float, turned: float, wear: Wear, rng: Random
) -> None:
    """Add a movement to dead reckoning, as the worn wheels measure it."""
    slip = 0.01 * math.sqrt(abs(ahead)) * rng.gauss(0, 1) if wear.scale else 0.0
    measured = ahead * (1 + wear.scale)
    middle = robot.reckoned_heading + turned / 2
    robot.reckoned_x += measured * math.cos(middle) - aside * math.sin(middle)
    robot.reckoned_y += measured * math.sin(middle) + aside * math.cos(middle)
    robot.reckoned_heading = math.remainder(
        robot.reckoned_heading + turned * (1 + wear.turn) + ahead * wear.pull + slip,
        2 * math.pi,
    )


def pose(robot: Robot) -> Pose:
    """Return what dead reckoning says."""
    return Pose(robot.reckoned_x, robot.reckoned_y, robot.reckoned_heading)


def drain(robot: Robot, usage: float) -> None:
    """Let a tick's worth of the battery go, or come."""
    if robot.charging:
        robot.battery = min(100.0, robot.battery + CHARGING * TICK)
        return
    moves = robot.speed != 0 or robot.turn != 0
    used = IDLE_DRAIN + (DRIVE_DRAIN if moves else 0.0)
    robot.battery = max(0.0, robot.battery - used * usage * TICK)


def sonar(
    robot: Robot, plan: FloorPlan, people: Iterable[Circle], rng: Random
) -> tuple[float, ...]:
    """Return what the ring of sonars measures, in metres from its middle."""
    x, y = robot.x, robot.y
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    cast, gauss = plan.cast, rng.gauss
    rays = [(cos * a - sin * b, sin * a + cos * b) for a, b in DIRECTIONS]
    ranges = [cast(x, y, dx, dy, SONAR_RANGE) for dx, dy in rays]
    for circle in people:
        _shadow(ranges, rays, circle[0] - x, circle[1] - y, circle[2])
    heard = [
        far if far >= SONAR_RANGE else max(0.0, far + gauss(0, SONAR_NOISE))
        for far in ranges
    ]
    if rng.random() < DEAF:
        heard[rng.randrange(SONARS)] = SONAR_RANGE
    return tuple(heard)


def _shadow(
    ranges: list[float],
    rays: Sequence[tuple[float, float]],
    dx: float,
    dy: float,
    radius: float,
) -> None:
    """Shorten the rays that somebody stands in the way of."""
    if dx * dx + dy * dy > (SONAR_RANGE + radius) ** 2:
        return
    for number, (ax, ay) in enumerate(rays):
        along = dx * ax + dy * ay
        if along > 0:
            across = dx * ay - dy * ax
            if -radius < across < radius:
                far = max(0.0, along - math.sqrt(radius * radius - across * across))
                ranges[number] = min(far, ranges[number])


def laser(
    robot: Robot,
    plan: FloorPlan,
    signs: Iterable[Sign],
    people: Sequence[Circle],
    rng: Random,
) -> tuple[Tag, ...]:
    """Return the tags that can be read from where the robot is."""
    seen: list[Tag] = []
    for sign in signs:
        away = math.hypot(sign.x - robot.x, sign.y - robot.y)
        if sign.floor == robot.floor and away <= LASER_RANGE:
            points = zip(sign.tags, sign.tag_points(), strict=True)
            for code, (x, y) in points:
                if _readable(robot, plan, sign.normal, x, y, people):
                    bearing = math.atan2(y - robot.y, x - robot.x) - robot.heading
                    noisy = bearing + rng.gauss(0, LASER_NOISE)
                    seen.append(Tag(code, math.remainder(noisy, 2 * math.pi)))
    return tuple(seen)


def _readable(
    robot: Robot,
    plan: FloorPlan,
    normal: float,
    x: float,
    y: float,
    people: Sequence[Circle],
) -> bool:
    """Whether nothing hides a tag, and it is not turned away."""
    dx, dy = x - robot.x, y - robot.y
    away = math.hypot(dx, dy)
    if away < 0.05:
        return False
    dx, dy = dx / away, dy / away
    if -(dx * math.cos(normal) + dy * math.sin(normal)) < STEEPEST:
        return False
    for px, py, radius in people:
        along = (px - robot.x) * dx + (py - robot.y) * dy
        across = (px - robot.x) * dy - (py - robot.y) * dx
        if 0 < along < away and abs(across) < radius:
            return False
    return plan.cast(robot.x, robot.y, dx, dy, away) > away - 0.02


def _towards(value: float, wanted: float, most: float) -> float:
    return value + max(-most, min(most, wanted - value))
