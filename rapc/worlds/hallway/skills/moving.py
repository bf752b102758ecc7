"""Moving by dead reckoning: in a direction, on the spot, backwards."""

from __future__ import annotations

import math

import msgspec

from rapc.base.values import Atom
from rapc.worlds.hallway.channels import (
    DRIVE,
    POSE,
    PROGRESS,
    TRAJECTORY,
    TRAVEL,
    Drive,
    Trajectory,
)
from rapc.worlds.hallway.skills.sonar import bearing_of
from rapc.worlds.skills.declarations import Event, Parameter, Ports, Skill

ARRIVED = 0.3
"""The distance from its end at which a movement is complete, in metres."""

FACING = 0.05
"""The angle from its bearing at which a turn is complete, in radians."""

HALTED = 2.0
"""Seconds without progress after which an obstacle is behind the robot."""

DIRECTION = Parameter(
    "direction", "number", "rad", "a heading in the frame of dead reckoning"
)
SPEED = Parameter("speed", "number", "m/s", "at most", low=0.05, high=0.6)


class MovementComplete(Event):
    """The movement is complete."""

    name = "movement-complete"
    inputs = (TRAVEL,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple if the movement has ended, else None."""
        return () if ports[TRAVEL] else None


class Start(msgspec.Struct):
    """The start of a movement."""

    x: float | None = None
    y: float = 0.0


class SteerInDirection(Skill):
    """Make for the point that is so far in a direction from where it came on."""

    name = "steer-in-direction"
    inputs = (POSE,)
    outputs = (TRAJECTORY, TRAVEL)
    parameters = (DIRECTION, Parameter("distance", "number", "m", low=0), SPEED)
    events = (MovementComplete,)
    State = Start
    state: Start

    def step(self, now: float, ports: Ports) -> None:
        """Write the trajectory to the point; its distance is 0 at or past the point."""
        pose, state, wanted = ports[POSE], self.state, self.arguments
        if state.x is None:
            state.x, state.y = pose.x, pose.y
        cos, sin = math.cos(wanted["direction"]), math.sin(wanted["direction"])
        x = state.x + wanted["distance"] * cos - pose.x
        y = state.y + wanted["distance"] * sin - pose.y
        left, ahead = math.hypot(x, y), x * cos + y * sin
        done = left < ARRIVED or ahead < 0
        ports[TRAVEL] = done
        bearing = bearing_of(math.atan2(y, x), pose)
        speed = 0.0 if done else float(wanted["speed"])
        ports[TRAJECTORY] = Trajectory(bearing, speed, left)


class FaceDirection(Skill):
    """Turn on the spot to a heading."""

    name = "face-direction"
    inputs = (POSE,)
    outputs = (TRAJECTORY, TRAVEL)
    parameters = (DIRECTION,)
    events = (MovementComplete,)

    def step(self, now: float, ports: Ports) -> None:
        """Write the angle left to turn."""
        bearing = bearing_of(self.arguments["direction"], ports[POSE])
        ports[TRAVEL] = abs(bearing) < FACING
        ports[TRAJECTORY] = Trajectory(bearing, 0.0, turn=True)


class Halted(Event):
    """The robot has come no farther backwards."""

    name = "stuck"
    inputs = (PROGRESS,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple if the robot stands for some time, else None."""
        return () if ports[PROGRESS] >= HALTED else None


class Backing(Start):
    """The state of `back-off`."""

    #: The distance and time of the last progress.
    far: float = 0.0
    moved: float | None = None


class BackOff(Skill):
    """Move backwards after a bump, slowly and without sensing."""

    name = "back-off"
    inputs = (POSE,)
    outputs = (DRIVE, TRAVEL, PROGRESS)
    parameters = (Parameter("distance", "number", "m", low=0, high=0.5),)
    events = (MovementComplete, Halted)
    uses = ("wheels",)
    State = Backing
    state: Backing

    def step(self, now: float, ports: Ports) -> None:
        """Drive until the distance is complete."""
        pose, state = ports[POSE], self.state
        if state.x is None:
            state.x, state.y = pose.x, pose.y
        far = math.hypot(pose.x - state.x, pose.y - state.y)
        if state.moved is None or far > state.far + 0.02:
            state.far, state.moved = far, now
        done = far >= self.arguments["distance"]
        ports[TRAVEL] = done
        ports[PROGRESS] = now - state.moved
        ports[DRIVE] = Drive(0.0 if done else -0.08, 0.0)
