"""Shared geometry of the sonar ring: points, and the direction of walls.

Walls in buildings stand at right angles. Three neighbouring echoes on a line vote for
the direction of that line, modulo a right angle: with four times the angle, the votes
of parallel and square walls add up. Old votes fade.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec

from rapc.worlds.hallway.channels import DIRECTIONS, SONARS, Pose

Point = tuple[float, float]

FAR = 3.0
"""The maximum distance of echoes with a vote, in metres."""

STRAIGHT = 0.15
"""The maximum angle between two pieces of one line, in radians."""

FADING = 0.93

QUARTER = math.pi / 2


class Votes(msgspec.Struct):
    """The sum of all votes on the walls' direction, in the frame of dead reckoning."""

    cos: float = 0.0
    sin: float = 0.0


def turned_by(x: float, y: float, heading: float) -> Point:
    """Return the position of a point along a heading, and to the left of it."""
    cos, sin = math.cos(heading), math.sin(heading)
    return x * cos + y * sin, y * cos - x * sin


def turned(echoes: Sequence[Point], bearing: float) -> list[Point]:
    """Return points in a frame with `bearing` ahead."""
    cos, sin = math.cos(bearing), math.sin(bearing)
    return [(x * cos + y * sin, y * cos - x * sin) for x, y in echoes]


def echo_points(ranges: Sequence[float]) -> list[Point]:
    """Return the points of the echoes, the robot's middle at (0, 0), ahead is x."""
    return [(r * dx, r * dy) for r, (dx, dy) in zip(ranges, DIRECTIONS, strict=True)]


def vote(votes: Votes, ranges: Sequence[float], pose: Pose) -> None:
    """Add the votes of one tick's echoes."""
    votes.cos *= FADING
    votes.sin *= FADING
    echoes = echo_points(ranges)
    near = [r < FAR for r in ranges]
    for middle in range(SONARS):
        before, after = middle - 1, (middle + 1) % SONARS
        if not (near[before] and near[middle] and near[after]):
            continue
        (ax, ay), (bx, by), (cx, cy) = echoes[before], echoes[middle], echoes[after]
        ux, uy, vx, vy = bx - ax, by - ay, cx - bx, cy - by
        across, along = ux * vy - uy * vx, ux * vx + uy * vy
        if along > 0 and abs(across) < STRAIGHT * along:
            angle = 4 * (math.atan2(cy - ay, cx - ax) + pose.heading)
            length = math.hypot(cx - ax, cy - ay)
            votes.cos += length * math.cos(angle)
            votes.sin += length * math.sin(angle)


def square_to(votes: Votes, heading: float) -> float:
    """Return the heading along or across the walls that is nearest to `heading`."""
    if votes.cos == 0 and votes.sin == 0:
        return heading
    axis = math.atan2(votes.sin, votes.cos) / 4
    return heading - math.remainder(heading - axis, QUARTER)


def bearing_of(heading: float, pose: Pose) -> float:
    """Return a heading as a bearing, between minus and plus half a turn."""
    return math.remainder(heading - pose.heading, 2 * math.pi)
