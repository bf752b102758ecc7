"""Following a trajectory around obstacles.

`follow-trajectory` looks along the wanted bearing for a free lane as wide as the robot
and a margin. If the lane is blocked, the skill tries bearings to the left and the right
in turn and takes the first free lane. For some seconds the skill keeps to that side, to
avoid wavering before a post. The speed depends on the free way straight ahead: the
robot can always stop within that way.

    wanted:  0 degrees, an obstacle 0.6 m ahead
    tried:   10 left, 10 right (blocked), 20 left (blocked), 20 right: free, taken
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import msgspec

from rapc.base.values import Atom
from rapc.worlds.hallway.channels import (
    DRIVE,
    OBSTACLES,
    POSE,
    PROGRESS,
    RADIUS,
    SONAR,
    SONAR_RANGE,
    SPEED_LIMIT,
    TRAJECTORY,
    Drive,
    Trajectory,
)
from rapc.worlds.hallway.skills.sonar import Point, echo_points
from rapc.worlds.skills.declarations import (
    Arbiter,
    Event,
    Input,
    Parameter,
    Ports,
    Skill,
)

LOOK_AHEAD = 1.2
"""The free length that a lane needs, in metres from the robot's edge."""

MARGINS = (0.12, 0.05)
"""Margins of a lane on each side of the robot, in metres: preferred and minimum."""

STEP = math.radians(10)

WIDEST = 12
"""The maximum number of steps aside for a lane."""

TIGHT_WIDEST = 6
"""The maximum number of steps aside for a lane with the minimum margin."""

TIGHT_COSTS = 1.5
"""The penalty of the minimum margin, in steps aside."""

OTHER_SIDE_COSTS = 4
"""The penalty of the other side while the robot keeps to a side, in steps aside."""

KEEP_SIDE = 3.0
"""The time that the robot keeps to its side after a swerve, in seconds."""


NARROW = 0.03
"""The margin in a doorway, in metres."""

WAITING = 0.4
"""The factor on the time without progress in a doorway, where people want to pass."""

BRAKING = 0.4
"""The planned deceleration, in metres a second, every second."""

STOP_BEFORE = 0.1
"""The distance left to an obstacle after braking, in metres."""

TURNING = 2.5
"""The gain of turning towards a bearing, per second."""

STUCK = 8.0
"""Seconds without movement after which the robot is stuck."""

CIRCLING = 15.0
"""Additional seconds for a robot that moves without approaching its goal."""


class Echoes(msgspec.Struct):
    """The two readings before the present one."""

    last: tuple[float, ...] | None = None
    before: tuple[float, ...] | None = None


class DetectObstacles(Skill):
    """Detect the obstacles around the robot, without transient echoes."""

    name = "detect-obstacles"
    inputs = (SONAR,)
    outputs = (OBSTACLES,)
    State = Echoes
    state: Echoes

    def step(self, now: float, ports: Ports) -> None:
        """Write the median of the last three readings of each sonar."""
        new = ports[SONAR]
        last = self.state.last or new
        before = self.state.before or last
        ports[OBSTACLES] = tuple(
            [sorted(three)[1] for three in zip(new, last, before, strict=True)]
        )
        self.state.last, self.state.before = new, last


class Stuck(Event):
    """The robot cannot move to its goal."""

    name = "stuck"
    inputs = (PROGRESS,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple after some time without progress, else None."""
        return () if ports[PROGRESS] >= STUCK else None


class Following(msgspec.Struct):
    """The state of `follow-trajectory`."""

    #: The side of the last swerve, 1 left, -1 right, and its time.
    side: int = 1
    swerved: float = -100.0
    #: The position and time of the last progress.
    x: float | None = None
    y: float = 0.0
    moved: float = 0.0
    #: The least remaining distance, and its time.
    left: float | None = None
    nearer: float = 0.0


class FollowTrajectory(Skill):
    """Drive along a trajectory, around obstacles."""

    name = "follow-trajectory"
    inputs = (OBSTACLES, TRAJECTORY, POSE, Input(SPEED_LIMIT, optional=True))
    outputs = (DRIVE, PROGRESS)
    events = (Stuck,)
    uses = ("wheels",)
    State = Following
    state: Following

    def step(self, now: float, ports: Ports) -> None:
        """Choose a bearing and a speed."""
        wanted, limit = ports[TRAJECTORY], ports.get(SPEED_LIMIT)
        ports[PROGRESS] = self._stalled(now, ports)
        if wanted.turn:
            ports[DRIVE] = Drive(0.0, TURNING * wanted.bearing)
            return
        most = wanted.speed if limit is None else min(limit, wanted.speed)
        near = [p for p in echo_points(ports[OBSTACLES]) if abs(p[0]) + abs(p[1]) < 2.6]
        bearing = self._choose(now, near, wanted)
        if bearing is None:
            ports[DRIVE] = Drive(0.0, 0.0)
            return
        margin = NARROW if wanted.narrow else MARGINS[1]
        ahead = lane(near, 0.0, RADIUS + margin)
        speed = min(most, math.sqrt(2 * BRAKING * max(0.0, ahead - STOP_BEFORE)))
        if wanted.distance is not None:
            speed = min(speed, 0.05 + math.sqrt(2 * BRAKING * wanted.distance))
        speed *= max(0.0, math.cos(bearing)) ** 3
        ports[DRIVE] = Drive(speed, TURNING * bearing)

    def _choose(
        self, now: float, near: Sequence[Point], wanted: Trajectory
    ) -> float | None:
        """Return the bearing to take; None if everything is blocked."""
        left = math.inf if wanted.distance is None else wanted.distance
        need = min(LOOK_AHEAD, left + STOP_BEFORE)
        if wanted.narrow:
            return wanted.bearing
        if lane(near, wanted.bearing, RADIUS + MARGINS[0]) >= need:
            return wanted.bearing
        state = self.state
        keeps = now - state.swerved < KEEP_SIDE
        for side, step, margin in _swerves(keeps):
            bearing = wanted.bearing + side * state.side * step * STEP
            if lane(near, bearing, RADIUS + margin) >= min(need, 0.8):
                state.side, state.swerved = side * state.side, now
                return math.remainder(bearing, 2 * math.pi)
        return None

    def _stalled(self, now: float, ports: Ports) -> float:
        """Return the seconds without progress of the robot."""
        state, pose, wanted = self.state, ports[POSE], ports[TRAJECTORY]
        far = state.x is None or math.hypot(pose.x - state.x, pose.y - state.y) > 0.25
        if far or wanted.turn:
            state.x, state.y, state.moved = pose.x, pose.y, now
        left = wanted.distance
        if left is None or wanted.turn:
            state.left, state.nearer = None, now
        elif state.left is None or not state.left - 0.15 < left < state.left + 1:
            state.left, state.nearer = left, now
        stalled = max(now - state.moved, now - state.nearer - CIRCLING)
        return stalled * WAITING if wanted.narrow else stalled


@functools.cache
def _swerves(keeps: bool) -> tuple[tuple[int, int, float], ...]:
    """Return the lanes to try, best first: side (1 the last side), steps, margin."""
    rated: list[tuple[float, int, int, float]] = []
    for step in range(1, WIDEST + 1):
        for side in (1, -1):
            cost = step + (OTHER_SIDE_COSTS if keeps and side < 0 else 0)
            rated.append((cost, -side, step, MARGINS[0]))
            if step <= TIGHT_WIDEST:
                rated.append((cost + TIGHT_COSTS, -side, step, MARGINS[1]))
    return tuple((-side, step, margin) for _, side, step, margin in sorted(rated))


def lane(near: Sequence[Point], bearing: float, half: float) -> float:
    """Return the free length of a lane, from the robot's edge, in metres.

    Args:
        near: the points with echoes.
        bearing: the bearing of the lane.
        half: half the width of the lane.
    """
    cos, sin = math.cos(bearing), math.sin(bearing)
    free = SONAR_RANGE
    for x, y in near:
        ahead = x * cos + y * sin
        if 0 < ahead < free and -half < y * cos - x * sin < half:
            free = ahead
    return free - RADIUS


class LimitSpeed(Skill):
    """Limit the speed; the lowest of several limits holds."""

    name = "limit-speed"
    outputs = (SPEED_LIMIT,)
    parameters = (Parameter("speed", "number", "m/s", low=0),)

    def step(self, now: float, ports: Ports) -> None:
        """Write the limit."""
        ports[SPEED_LIMIT] = float(self.arguments["speed"])


class LowestLimit(Arbiter):
    """The lowest of several speed limits holds."""

    channel = SPEED_LIMIT

    def decide(self, values: list[float]) -> float:
        """Return the lowest value."""
        return min(values)
