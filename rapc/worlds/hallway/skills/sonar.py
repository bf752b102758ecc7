"""What several skills make of the ring of sonars: points, and how the walls run.

Walls in buildings stand at right angles. Three neighbouring echoes that lie on a line
vote for the direction of that line, modulo a right angle: with four times the angle,
the votes of walls that are parallel or square to each other add up. Old votes fade.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import msgspec

from rapc.worlds.hallway.channels import DIRECTIONS, SONARS, Pose

Point = tuple[float, float]

FAR = 3.0
"""Echoes from farther away have no vote, in metres."""

STRAIGHT = 0.15
"""Two pieces of one line differ by less than this, in radians."""

FADING = 0.93

QUARTER = math.pi / 2


class Votes(msgspec.Struct):
    """The sum of all votes on how the walls run, in the frame of dead reckoning."""

    cos: float = 0.0
    sin: float = 0.0


def turned_by(x: float, y: float, heading: float) -> Point:
    """Return how far a place is along a heading, and to the left of it."""
    cos, sin = math.cos(heading), math.sin(heading)
    return x * cos + y * sin, y * cos - x * sin


def turned(echoes: Sequence[Point], bearing: float) -> list[Point]:
    """Return points as they are when `bearing` is ahead."""
    cos, sin = math.cos(bearing), math.sin(bearing)
    return [(x * cos + y * sin, y * cos - x * sin) for x, y in echoes]


def echo_points(ranges: Sequence[float]) -> list[Point]:
    """Return where the echoes come from, the robot's middle at (0, 0), ahead is x."""
    return [(r * dx, r * dy) for r, (dx, dy) in zip(ranges, DIRECTIONS, strict=True)]


def vote(votes: Votes, ranges: Sequence[float], pose: Pose) -> None:
    """Let the echoes of one tick vote."""
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
