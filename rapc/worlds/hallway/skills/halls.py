"""Following a hallway to its end [S 2, S 3]."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

import msgspec

from rapc.base.values import Atom
from rapc.worlds.hallway.channels import (
    HALL,
    POSE,
    PROGRESS,
    SONAR,
    TRAJECTORY,
    Hall,
    Pose,
    Trajectory,
)
from rapc.worlds.hallway.skills.sonar import (
    Point,
    Votes,
    bearing_of,
    echo_points,
    square_to,
    turned,
    vote,
)
from rapc.worlds.skills.declarations import Event, Ports, Skill

SPEED = 0.5
"""The speed in a hallway without a limit, in metres a second."""

BESIDE = 1.2
"""The length of the walls used for measuring, ahead and back, in metres."""

WIDEST = 3.0
"""The maximum width of a hallway, in metres."""

END = 1.0
"""The maximum distance of the wall at the end, in metres."""

SURE = 4
"""Ticks in which the end must be seen."""

FIRST = 20
"""Ticks after which the measured walls count as reliable."""

ELSEWHERE = 0.4
"""The minimum distance to the middle between other walls, in metres."""

BLOCKED = 6.0
"""Seconds without movement after which a hallway is blocked."""

BODY = 0.15
"""The distance to the wall below which the robot is in a doorway, in metres."""

OUTSIDE = 20.0
"""Seconds outside of the hallway after which the hallway is blocked."""


class EndOfHall(Event):
    """A wall closes the hallway right ahead, with or without a doorway in it."""

    name = "end-o-hall"
    inputs = (HALL,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple if the end is in sight, else None."""
        return () if ports[HALL].ends else None


class HallBlocked(Event):
    """An obstacle seems to fill the hallway."""

    name = "hall-blocked"
    inputs = (HALL, PROGRESS)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple if stuck before the hallway's end, else None."""
        hall = ports[HALL]
        stuck = ports[PROGRESS] >= BLOCKED or hall.outside >= OUTSIDE
        return () if stuck and not hall.ends else None


class Tracking(msgspec.Struct):
    """The state of `track-hallway`."""

    votes: Votes = msgspec.field(default_factory=Votes)
    #: The hallway's heading in the frame of dead reckoning.
    heading: float | None = None
    left: float = 1.0
    right: float = 1.0
    #: The middle of the hallway beside the robot; None before the first tick.
    x: float | None = None
    y: float = 0.0
    #: The distances from the middle to the walls.
    half: float = 1.0
    #: The number of measurements of the walls.
    looks: int = 0
    #: The time when the robot was last between the walls of the hallway.
    within: float | None = None
    #: The number of ticks with the end in view.
    ends: int = 0


class TrackHallway(Skill):
    """Estimate direction and width of the hallway; compute the way along its middle.

    The skill follows the direction of the hallway that the robot faces when the skill
    is switched on.
    """

    name = "track-hallway"
    inputs = (SONAR, POSE)
    outputs = (HALL, TRAJECTORY)
    events = (EndOfHall, HallBlocked)
    State = Tracking
    state: Tracking

    def step(self, now: float, ports: Ports) -> None:
        """Measure the walls, and write the trajectory along the middle."""
        state, pose, ranges = self.state, ports[POSE], ports[SONAR]
        vote(state.votes, ranges, pose)
        before = pose.heading if state.heading is None else state.heading
        state.heading = square_to(state.votes, before)
        bearing = bearing_of(state.heading, pose)
        echoes = turned(echo_points(ranges), bearing)
        self._measure(echoes)
        offset, width = self._offset(pose, state.heading), state.left + state.right
        if state.within is None or abs(offset) < state.half - BODY:
            state.within = now
        outside = now - state.within
        state.ends = state.ends + 1 if not outside and self._ends(echoes) else 0
        ends = state.ends >= SURE
        ports[HALL] = Hall(bearing, width, offset, ends, outside)
        aside = math.atan2(offset, 1.0) if width < WIDEST else 0.0
        ahead = math.remainder(bearing - aside, 2 * math.pi)
        ports[TRAJECTORY] = Trajectory(ahead, SPEED)

    def _measure(self, echoes: Sequence[Point]) -> None:
        """Measure the distances to the walls on both sides; doorways are deeper."""
        beside = [y for x, y in echoes if abs(x) < BESIDE]
        left = [y for y in beside if 0.2 < y < WIDEST]
        right = [-y for y in beside if 0.2 < -y < WIDEST]
        if len(left) > 1:
            self.state.left = median(left)
        if len(right) > 1:
            self.state.right = median(right)

    def _offset(self, pose: Pose, heading: float) -> float:
        """Return the robot's offset to the left of the middle of the hallway.

        The offset comes from the walls on both sides. While the walls differ from the
        known walls, as in a room into which the robot swerved, it comes from dead
        reckoning.
        """
        state = self.state
        offset, width = (state.right - state.left) / 2, state.left + state.right
        cos, sin = math.cos(heading), math.sin(heading)
        state.looks += 1
        if state.x is not None and state.looks > FIRST:
            reckoned = (pose.y - state.y) * cos - (pose.x - state.x) * sin
            wider = abs(width - 2 * state.half)
            if max(abs(offset - reckoned), wider) > ELSEWHERE:
                offset = reckoned
        else:
            state.half = width / 2
        state.x, state.y = pose.x + offset * sin, pose.y - offset * cos
        return offset

    def _ends(self, echoes: Sequence[Point]) -> bool:
        """Return whether walls on both sides of the middle are equally far ahead."""
        edge_left, edge_right = self.state.left - 0.12, self.state.right - 0.12
        left = [x for x, y in echoes if 0.3 < x < END and 0.4 < y < edge_left]
        right = [x for x, y in echoes if 0.3 < x < END and 0.4 < -y < edge_right]
        return bool(left and right) and abs(max(left) - max(right)) < 0.2
