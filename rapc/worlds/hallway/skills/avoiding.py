"""Going along a trajectory without bumping into anything.

`follow-trajectory` looks along the wanted bearing for a free lane as wide as the robot
and a margin. If there is none it tries bearings to the left and the right of it in turn
and takes the first with a lane; for some seconds it keeps to the side that it took, so
that it does not dither before a post. How fast it goes depends on how much is free
straight ahead: it can always stop within that.

    wanted:  0 degrees, something 0.6 m ahead
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
"""How much of a lane has to be free, in metres from the robot's edge."""

MARGINS = (0.12, 0.05)
"""How much wider than the robot a lane is on each side, in metres; at best, at least.
"""

STEP = math.radians(10)

WIDEST = 12
"""How many steps aside a lane is looked for."""

TIGHT_WIDEST = 6
"""How many steps aside a lane of the lesser margin is looked for."""

TIGHT_COSTS = 1.5
"""A lane of the lesser margin is as good as one so many steps farther aside."""

OTHER_SIDE_COSTS = 4
"""While the robot keeps to a side, so is one on the other side."""

KEEP_SIDE = 3.0
"""For how long after a swerve the robot keeps to its side, in seconds."""


NARROW = 0.03
"""The margin in a doorway."""

WAITING = 0.4
"""How fast the robot grows tired of waiting in a doorway, where others want to pass."""

BRAKING = 0.4
"""How hard the robot means to brake, in metres a second, every second."""

STOP_BEFORE = 0.1
"""What is left free when it has stopped, in metres."""

TURNING = 2.5
"""How fast it turns towards a bearing, per second."""

STUCK = 8.0
"""Seconds without moving after which the robot is stuck."""

CIRCLING = 15.0
"""Seconds more for a robot that moves, but comes no nearer."""


class Echoes(msgspec.Struct):
    """The two readings before the present one."""

    last: tuple[float, ...] | None = None
    before: tuple[float, ...] | None = None


class DetectObstacles(Skill):
    """Keep a picture of what is near, without echoes that come and go."""

    name = "detect-obstacles"
    inputs = (SONAR,)
    outputs = (OBSTACLES,)
    State = Echoes
    state: Echoes

    def step(self, now: float, ports: Ports) -> None:
        """Write the middle one of the last three readings of each sonar."""
        new = ports[SONAR]
        last = self.state.last or new
        before = self.state.before or last
        ports[OBSTACLES] = tuple(
            [sorted(three)[1] for three in zip(new, last, before, strict=True)]
        )
        self.state.last, self.state.before = new, last


class Stuck(Event):
    """The robot cannot go where it is to go."""

    name = "stuck"
    inputs = (PROGRESS,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Whether it has come no nearer for some time."""
        return () if ports[PROGRESS] >= STUCK else None


class Following(msgspec.Struct):
    """What `follow-trajectory` remembers."""

    #: The side on which it last swerved, 1 left, -1 right, and when.
    side: int = 1
    swerved: float = -100.0
    #: Where and when it last had moved on.
    x: float | None = None
    y: float = 0.0
    moved: float = 0.0
    #: The least that was left to go, and when.
    left: float | None = None
    nearer: float = 0.0


class FollowTrajectory(Skill):
    """Drive along a trajectory, around what is in the way."""

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
        """The bearing to take; None if everything is blocked."""
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
        """For how long the robot has come no nearer, in seconds."""
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
    """The lanes to be tried, best first: side (1 the last one), steps, margin."""
    rated: list[tuple[float, int, int, float]] = []
    for step in range(1, WIDEST + 1):
        for side in (1, -1):
            cost = step + (OTHER_SIDE_COSTS if keeps and side < 0 else 0)
            rated.append((cost, -side, step, MARGINS[0]))
            if step <= TIGHT_WIDEST:
                rated.append((cost + TIGHT_COSTS, -side, step, MARGINS[1]))
    return tuple((-side, step, margin) for _, side, step, margin in sorted(rated))


def lane(near: Sequence[Point], bearing: float, half: float) -> float:
    """Return how far a lane is free, from the robot's edge, in metres.

    Args:
        near: where there is something.
        bearing: of the lane.
        half: half its width.
    """
    cos, sin = math.cos(bearing), math.sin(bearing)
    free = SONAR_RANGE
    for x, y in near:
        ahead = x * cos + y * sin
        if 0 < ahead < free and -half < y * cos - x * sin < half:
            free = ahead
    return free - RADIUS


class LimitSpeed(Skill):
    """Go no faster than this; of several limits the lowest holds."""

    name = "limit-speed"
    outputs = (SPEED_LIMIT,)
    parameters = (Parameter("speed", "number", "m/s", low=0),)

    def step(self, now: float, ports: Ports) -> None:
        """Say the limit."""
        ports[SPEED_LIMIT] = float(self.arguments["speed"])


class LowestLimit(Arbiter):
    """The lowest of several speed limits holds."""

    channel = SPEED_LIMIT

    def decide(self, values: list[float]) -> float:
        """Return the lowest."""
        return min(values)
