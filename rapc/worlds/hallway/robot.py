"""The robot's body: two driven wheels, dead reckoning, sonars, a laser, a battery.

Sensors are noisy, and movements differ slightly from the orders. The noise of each part
has its own random stream. Not here: collisions (`driving`) and decisions (`skills`).
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
"""The length of a step of the simulation, in seconds."""

ACCELERATION = 0.8
"""The acceleration of the wheels, in metres a second, every second."""

TURN_ACCELERATION = 4.0


class SonarModel(msgspec.Struct, frozen=True):
    """The echoes that a sonar hears."""

    #: The rays on each side of the middle ray, 5 degrees apart; the
    #: nearest echo counts.
    beside: int = 0
    #: The maximum angle of incidence of a ray with an echo, in degrees.
    steepest: float = 90.0


SONAR_MODELS = {
    "ideal": SonarModel(),
    "slant-50": SonarModel(steepest=50),
    "slant-30": SonarModel(steepest=30),
    "cone": SonarModel(beside=2),
}
"""The models of sonars, by name."""

FAN = 3
"""The number of rays from a sonar to the next one, for sonars with rays beside."""

RAYS = tuple(
    (math.cos(angle), math.sin(angle))
    for angle in (2 * math.pi * n / (SONARS * FAN) for n in range(SONARS * FAN))
)

SONAR_NOISE = 0.012
DEAF = 0.1
"""The probability in a tick that one of the sonars hears no echo."""

LASER_NOISE = 0.006
STEEPEST = math.cos(math.radians(75))
"""The minimum cosine of the angle at which a tag can be read."""

IDLE_DRAIN = 0.008
DRIVE_DRAIN = 0.02
"""The drain of the battery by driving, in per cent a second."""

CHARGING = 1.0

Circle = tuple[float, float, float]
"""A person: x, y and radius."""


class Robot(msgspec.Struct):
    """The state of the body; positions in metres, angles in radians."""

    x: float
    y: float
    heading: float
    floor: int
    #: The speed ahead and the turning speed of the body.
    speed: float = 0.0
    turn: float = 0.0
    #: The pose by dead reckoning.
    reckoned_x: float = 0.0
    reckoned_y: float = 0.0
    reckoned_heading: float = 0.0
    #: The charge of the battery, in per cent.
    battery: float = 100.0
    charging: bool = False
    #: The distance driven.
    distance: float = 0.0
    #: Whether the body touched an obstacle in the last tick.
    touching: bool = False


class Wear(msgspec.Struct, frozen=True):
    """The errors of this robot's wheels."""

    #: The relative error of a measured metre.
    scale: float
    #: The relative error of a measured turn.
    turn: float
    #: The turn of dead reckoning on a straight metre.
    pull: float


def worn(rng: Random, drift: float) -> Wear:
    """Return the wear of a robot; `drift` 1 is usual, 0 none."""
    return Wear(
        rng.uniform(-0.02, 0.02) * drift,
        rng.uniform(-0.01, 0.01) * drift,
        rng.uniform(-0.004, 0.004) * drift,
    )


def set_speeds(robot: Robot, drive: Drive | None) -> None:
    """Move the speeds towards the ordered speeds; without orders the wheels brake."""
    wanted = drive or Drive(0.0, 0.0)
    speed = max(-TOP_SPEED, min(TOP_SPEED, wanted.speed))
    turn = max(-TOP_TURN, min(TOP_TURN, wanted.turn))
    robot.speed = _towards(robot.speed, speed, ACCELERATION * TICK)
    robot.turn = _towards(robot.turn, turn, TURN_ACCELERATION * TICK)


def move(
    robot: Robot,
    x: float,
    y: float,
    turned: float,
    wear: Wear,
    rng: Random,
    rolled: float | None = None,
) -> None:
    """Move the body, and update dead reckoning with its errors.

    Args:
        robot: the body.
        x: the new position.
        y: the new position.
        turned: the radians turned.
        wear: the wear of its wheels.
        rng: the stream of its slip.
        rolled: the way that the wheels rolled, if only the wheels are measured; None:
            the movement of the body is measured.
    """
    dx, dy, middle = x - robot.x, y - robot.y, robot.heading + turned / 2
    ahead = dx * math.cos(middle) + dy * math.sin(middle)
    aside = dy * math.cos(middle) - dx * math.sin(middle)
    robot.x, robot.y = x, y
    robot.distance += math.hypot(dx, dy)
    robot.heading = math.remainder(robot.heading + turned, 2 * math.pi)
    if rolled is not None:
        ahead, aside = rolled, 0.0
    if ahead or aside or turned:
        _reckon(robot, ahead, aside, turned, wear, rng)


def _reckon(
    robot: Robot, ahead: float, aside: float, turned: float, wear: Wear, rng: Random
) -> None:
    """Add a movement to dead reckoning, as measured by the worn wheels."""
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
    """Return the pose by dead reckoning."""
    return Pose(robot.reckoned_x, robot.reckoned_y, robot.reckoned_heading)


def drain(robot: Robot, usage: float) -> None:
    """Drain or charge the battery for a tick."""
    if robot.charging:
        robot.battery = min(100.0, robot.battery + CHARGING * TICK)
        return
    moves = robot.speed != 0 or robot.turn != 0
    used = IDLE_DRAIN + (DRIVE_DRAIN if moves else 0.0)
    robot.battery = max(0.0, robot.battery - used * usage * TICK)


def sonar(
    robot: Robot,
    plan: FloorPlan,
    people: Iterable[Circle],
    rng: Random,
    model: SonarModel = SONAR_MODELS["ideal"],
) -> tuple[float, ...]:
    """Return the readings of the sonar ring, in metres from its middle."""
    x, y = robot.x, robot.y
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    hit, gauss = plan.hit, rng.gauss
    ring = RAYS if model.beside else DIRECTIONS
    rays = [(cos * a - sin * b, sin * a + cos * b) for a, b in ring]
    hits = [hit(x, y, dx, dy, SONAR_RANGE) for dx, dy in rays]
    for circle in people:
        _shadow(hits, rays, circle[0] - x, circle[1] - y, circle[2])
    least = math.cos(math.radians(model.steepest))
    ranges = [far if cosine >= least else SONAR_RANGE for far, cosine in hits]
    if model.beside:
        near = range(-model.beside, model.beside + 1)
        ranges = [
            min(ranges[(number + off) % len(ranges)] for off in near)
            for number in range(0, len(ranges), FAN)
        ]
    heard = [
        far if far >= SONAR_RANGE else max(0.0, far + gauss(0, SONAR_NOISE))
        for far in ranges
    ]
    if rng.random() < DEAF:
        heard[rng.randrange(SONARS)] = SONAR_RANGE
    return tuple(heard)


def _shadow(
    hits: list[tuple[float, float]],
    rays: Sequence[tuple[float, float]],
    dx: float,
    dy: float,
    radius: float,
) -> None:
    """Shorten the rays that a person blocks."""
    if dx * dx + dy * dy > (SONAR_RANGE + radius) ** 2:
        return
    for number, (ax, ay) in enumerate(rays):
        along = dx * ax + dy * ay
        if along > 0:
            across = dx * ay - dy * ax
            if -radius < across < radius:
                deep = math.sqrt(radius * radius - across * across)
                far = max(0.0, along - deep)
                if far < hits[number][0]:
                    hits[number] = far, deep / radius


def laser(
    robot: Robot,
    plan: FloorPlan,
    signs: Iterable[Sign],
    people: Sequence[Circle],
    rng: Random,
) -> tuple[Tag, ...]:
    """Return the tags that the laser can read from the robot's position."""
    seen: list[Tag] = []
    for sign in signs:
        if sign.floor != robot.floor:
            continue
        dx, dy = sign.x - robot.x, sign.y - robot.y
        if math.hypot(dx, dy) > LASER_RANGE:
            continue
        ahead = math.cos(sign.normal), math.sin(sign.normal)
        if dx * ahead[0] + dy * ahead[1] >= 0:  # the robot is behind the sign
            continue
        for code, (x, y) in zip(sign.tags, sign.tag_points(), strict=True):
            if _readable(robot, plan, ahead, x, y, people):
                bearing = math.atan2(y - robot.y, x - robot.x) - robot.heading
                noisy = bearing + rng.gauss(0, LASER_NOISE)
                seen.append(Tag(code, math.remainder(noisy, 2 * math.pi)))
    return tuple(seen)


def _readable(
    robot: Robot,
    plan: FloorPlan,
    ahead: tuple[float, float],
    x: float,
    y: float,
    people: Sequence[Circle],
) -> bool:
    """Return whether a tag that faces the direction `ahead` can be read."""
    dx, dy = x - robot.x, y - robot.y
    away = math.hypot(dx, dy)
    if away < 0.05:
        return False
    dx, dy = dx / away, dy / away
    if -(dx * ahead[0] + dy * ahead[1]) < STEEPEST:
        return False
    if plan.cast(robot.x, robot.y, dx, dy, away) <= away - 0.02:
        return False
    for px, py, radius in people:
        along = (px - robot.x) * dx + (py - robot.y) * dy
        across = (px - robot.x) * dy - (py - robot.y) * dx
        if 0 < along < away and abs(across) < radius:
            return False
    return True


def _towards(value: float, wanted: float, most: float) -> float:
    return value + max(-most, min(most, wanted - value))
