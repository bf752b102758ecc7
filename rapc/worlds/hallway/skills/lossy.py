"""The skills of a robot with sonars that lose echoes.

A smooth wall reflects the sound of a slanted beam away from the robot: the sonar hears
no echo, and the corner of a box or a doorway is silent from most places. So silence
shows nothing. `detect-obstacles` keeps the points of the last echoes in the frame of
dead reckoning. A point counts until an echo from behind the point shows that it is
free, or until the point is old. `track-door-jambs` takes a doorway as closed only if
echoes from right ahead show a wall; otherwise the robot goes straight on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, ClassVar

import msgspec

from rapc.worlds.hallway.channels import (
    BEARINGS,
    DIRECTIONS,
    OBSTACLES,
    POSE,
    SONAR,
    SONAR_RANGE,
    SONARS,
    SPEED_LIMIT,
    TOP_SPEED,
)
from rapc.worlds.hallway.skills.doorways import (
    BIN,
    BINS,
    DEEPER,
    LOOKS,
    TrackDoorJambs,
    gap_in,
    is_before,
    plane_in,
)
from rapc.worlds.hallway.skills.landmarks import TrackLandmark
from rapc.worlds.hallway.skills.sonar import Point, Votes, square_to, vote
from rapc.worlds.skills.declarations import Channel, Ports, Skill

CELL = 0.05
"""The size of a cell for points, in metres: one point is kept for each cell."""

NEAR = 1.6
"""The maximum distance of remembered points, in metres."""

KEPT = 8.0
"""The time for which a point is remembered, in seconds."""

BEHIND = 0.2
"""The distance of an echo behind a point that shows that the point is free."""

BESIDE = 0.06
"""The maximum distance of that echo's beam from the point, in metres."""

STANDING = 1.0
"""The distance of a doorway's wall if no echo shows the wall, in metres."""

DOORWAY = 0.3
"""Half the width of the way in which an echo shows a closed door, in metres."""


OBLIQUE = math.radians(15)
"""The angle between heading and walls above which corners may be silent."""

CAREFUL = 0.25
"""The maximum speed at such an angle, in metres a second."""


class Points(msgspec.Struct):
    """The remembered points by cell: x, y and the time of the last echo."""

    cells: dict[str, tuple[float, float, float]] = {}


class RememberObstacles(Skill):
    """Detect the obstacles around the robot, with the echoes of the last seconds."""

    name = "detect-obstacles"
    inputs = (SONAR, POSE)
    outputs: ClassVar[tuple[Channel[Any], ...]] = (OBSTACLES,)
    State = Points
    state: Points

    def step(self, now: float, ports: Ports) -> None:
        """Write the nearest point in each direction: heard, or remembered."""
        ranges, pose, cells = ports[SONAR], ports[POSE], self.state.cells
        cos, sin = math.cos(pose.heading), math.sin(pose.heading)
        nearest = list(ranges)
        for cell, (x, y, time) in list(cells.items()):
            dx, dy = x - pose.x, y - pose.y
            far, bearing = math.hypot(dx, dy), math.atan2(dy, dx) - pose.heading
            number = round(bearing / (2 * math.pi) * SONARS) % SONARS
            heard = ranges[number]
            aside = far * math.sin(bearing - BEARINGS[number])
            free = far + BEHIND < heard < SONAR_RANGE and abs(aside) < BESIDE
            if free or far > NEAR or now - time > KEPT:
                del cells[cell]
            elif far < nearest[number]:
                nearest[number] = far
        for far, (dx, dy) in zip(ranges, DIRECTIONS, strict=True):
            if far < NEAR:
                x = pose.x + far * (cos * dx - sin * dy)
                y = pose.y + far * (sin * dx + cos * dy)
                cell = f"{math.floor(x / CELL)} {math.floor(y / CELL)}"
                cells[cell] = (round(x, 3), round(y, 3), now)
        ports[OBSTACLES] = tuple(nearest)


class CarefulPoints(Points):
    """The remembered points, and the direction of the walls."""

    votes: Votes = msgspec.field(default_factory=Votes)


class RememberCarefully(RememberObstacles):
    """Detect the obstacles around the robot; go slowly where corners may be silent."""

    outputs = (OBSTACLES, SPEED_LIMIT)
    State = CarefulPoints
    state: CarefulPoints

    def step(self, now: float, ports: Ports) -> None:
        """Write the obstacles, and limit the speed at an angle to the walls."""
        super().step(now, ports)
        vote(self.state.votes, ports[SONAR], pose := ports[POSE])
        off = abs(square_to(self.state.votes, pose.heading) - pose.heading)
        ports[SPEED_LIMIT] = CAREFUL if off > OBLIQUE else TOP_SPEED


class TrackLandmarkInSilence(TrackLandmark):
    """Keep an estimate of where a landmark is and how it is turned."""

    hears_walls = False


class TrackDoorwayInSilence(TrackDoorJambs):
    """Find the doorway ahead, and lead through its middle, or straight on."""

    def _look(
        self,
        ranges: Sequence[float],
        echoes: Sequence[Point],
        along: float,
        across: float,
    ) -> None:
        """Find the wall, or assume it; enter the beams with an echo into the bins."""
        state, wall = self.state, plane_in(echoes)
        state.looks += 1
        if state.stage == "looking" and state.looks == 1:
            state.origin = across
        if not is_before(wall):
            self._look_aside(echoes, along, across)
            wall = None
        if wall is not None and (state.wall is None or state.stage == "looking"):
            state.wall = along + wall
        elif state.wall is None and state.looks > LOOKS:
            lane = [x for x, y in echoes if abs(y) < DOORWAY and x > 0]
            if min(lane, default=SONAR_RANGE) > STANDING + DEEPER:
                state.wall = along + STANDING
        if state.wall is not None:
            heard = [
                pair
                for pair in zip(ranges, echoes, strict=True)
                if pair[0] < SONAR_RANGE
            ]
            self._enter(heard, state.wall - along, across)

    def _gap(self) -> float | None:
        """Return the middle of the gap; straight on unless echoes show a wall there."""
        gap = gap_in(self.state.bins)
        if gap is not None:
            return gap
        ahead = round(DOORWAY / BIN)
        middle = self.state.bins[BINS - ahead : BINS + ahead]
        return None if any(value < 0 for value in middle) else 0.0
