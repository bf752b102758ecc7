"""Going through a doorway by sonar.

The skill gets the rough heading of the doorway. It squares that heading to the walls in
view, and finds the wall ahead as the plane that most echoes share. For every place
along that wall, the skill records whether beams end there or go on. Places are kept in
bins of five centimetres. Each beam moves its bin towards *wall* or *open*, so a closing
door is noticed soon. The gap is the run of open bins nearest to straight ahead. Its
edges lie half-way between the last open place and the first place with wall:

    wall wall  .  open open  .  open open  .   .  wall      (. unknown)
              ^----------- the gap -----------^

At the end of a narrow hall no three echoes share a plane. After some looks, an echo on
each side of the way, equally far ahead, marks the edges of the wall.

A robot that was stopped in the doorway has no wall ahead. If the robot stands
between two jambs (`jambs`), it goes on from there. The robot is through if a wall
behind it begins on both sides of the way.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from statistics import median

import msgspec

from rapc.base.values import Atom
from rapc.worlds.hallway.channels import (
    GAP,
    POSE,
    SONAR,
    SONAR_RANGE,
    TRAJECTORY,
    Pose,
    Trajectory,
)
from rapc.worlds.hallway.skills.jambs import between_jambs
from rapc.worlds.hallway.skills.moving import DIRECTION, SPEED
from rapc.worlds.hallway.skills.passages import KEPT, Ring, is_walled
from rapc.worlds.hallway.skills.sonar import (
    Point,
    Votes,
    bearing_of,
    echo_points,
    square_to,
    turned,
    turned_by,
    vote,
)
from rapc.worlds.skills.declarations import Event, Ports, Skill

BIN = 0.05
BINS = 60
"""Bins along the wall, as many to the left as to the right."""

FACED = 0.12
"""The maximum error of the heading for judging the doorway, in radians."""

LOOKS = 12
"""Ticks of looking before the skill takes the door as closed."""

DEEPER = 0.3
"""The minimum length of a beam beyond the wall that goes through it, in metres."""

LEAST = 0.5
"""The minimum width of a gap, in metres."""

OFF = 0.8
"""The maximum distance of a gap to the side of straight ahead, in metres."""

BEYOND = 0.8
"""The way of the robot past the wall's face, in metres."""

CLOSE = 0.4
"""The distance from the wall below which the gap is not searched, in metres."""

AHEAD = (0.6, 1.5)
"""Distances of a wall ahead at which the robot stands before a doorway, in metres."""

EDGE = (0.3, 1.2)
"""Distances of a doorway's edge to each side of straight ahead, in metres."""

FLAT = 0.1
"""The maximum difference of the distances to two edges of a doorway, in metres."""

LINE_UP = 0.4
"""The way in which the robot lines up with the gap, in metres."""


class Passage(msgspec.Struct):
    """The state of `track-door-jambs`."""

    votes: Votes = msgspec.field(default_factory=Votes)
    stage: str = "looking"
    #: Ticks spent looking.
    looks: int = 0
    #: The robot's position by dead reckoning at the start of the skill. The following
    #: fields are relative to it. The heading is refined while the robot stands there;
    #: relative to a far origin, a small turn would be a large step along the axis.
    x: float | None = None
    y: float = 0.0
    #: The heading squared to the walls: the axis of the following fields.
    heading: float | None = None
    #: The distance of the wall along the axis.
    wall: float | None = None
    #: The robot's position across the axis at the start of the bins.
    origin: float = 0.0
    #: Per bin: 1 where beams go through, -1 where beams end, 0 without a beam.
    bins: list[float] = msgspec.field(default_factory=lambda: [0.0] * (2 * BINS))
    #: The middle of the gap across the axis.
    middle: float | None = None
    #: For each tick of looking with the robot between jambs: the position of the middle
    #: along and across the axis, and the distance between the jambs.
    jambs: list[tuple[float, float, float]] = []
    #: The distance between the jambs around the robot.
    wide: float = 0.0
    #: The rings of echoes on the way from there, oldest first.
    rings: list[Ring] = []


class ThroughDoorway(Event):
    """The robot has gone through the doorway."""

    name = "movement-complete"
    inputs = (GAP,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple if the robot is on the other side, else None."""
        return () if ports[GAP] == "through" else None


class DoorClosed(Event):
    """There is wall, or a door, where the doorway should be."""

    name = "door-closed"
    inputs = (GAP,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple if no gap was found, else None."""
        return () if ports[GAP] == "closed" else None


class TrackDoorJambs(Skill):
    """Find the doorway ahead, and lead through its middle."""

    name = "track-door-jambs"
    inputs = (SONAR, POSE)
    outputs = (TRAJECTORY, GAP)
    parameters = (DIRECTION, SPEED)
    events = (ThroughDoorway, DoorClosed)
    State = Passage
    state: Passage

    def step(self, now: float, ports: Ports) -> None:
        """Look at the wall ahead, and write the trajectory."""
        state, pose, ranges = self.state, ports[POSE], ports[SONAR]
        if state.x is None:
            state.x, state.y = pose.x, pose.y
        if state.stage == "looking":
            vote(state.votes, ranges, pose)
            state.heading = square_to(state.votes, self.arguments["direction"])
        heading = state.heading
        assert heading is not None
        along, across = turned_by(pose.x - state.x, pose.y - state.y, heading)
        bearing = bearing_of(heading, pose)
        if state.stage == "between":
            self._hear(pose, ranges)
            self._look_back(along, heading)
        elif state.stage in {"looking", "going"}:
            going = state.stage == "going"
            echoes = turned(echo_points(ranges), bearing)
            if self._far(along) if going else abs(bearing) < FACED:
                self._look(ranges, echoes, along, across)
            self._judge(along)
        ports[GAP] = state.stage
        ports[TRAJECTORY] = self._lead(pose, along, across, bearing)

    def _lead(
        self, pose: Pose, along: float, across: float, bearing: float
    ) -> Trajectory:
        """Return the way: face the wall, line up with the gap, go through, stop."""
        state = self.state
        led = state.stage in {"going", "between"}
        if not led or state.wall is None or state.middle is None:
            return Trajectory(bearing, 0.0, turn=True)
        aside = math.atan2(state.middle - across, LINE_UP)
        left = max(0.0, state.wall + BEYOND - along)
        ahead = math.remainder(bearing + aside, 2 * math.pi)
        return Trajectory(ahead, float(self.arguments["speed"]), left, narrow=True)

    def _look(
        self,
        ranges: Sequence[float],
        echoes: Sequence[Point],
        along: float,
        across: float,
    ) -> None:
        """Find the wall, and enter the beams into the bins."""
        state = self.state
        wall = plane_in(echoes)
        state.looks += 1
        if state.stage == "looking" and state.looks == 1:
            state.origin = across
        if not is_before(wall):
            self._look_aside(echoes, along, across)
        if wall is None and state.wall is None and state.looks > LOOKS:
            wall = _edges(echoes)
        if wall is not None and (state.wall is None or state.stage == "looking"):
            state.wall = along + wall
        if state.wall is None:
            return
        self._enter(zip(ranges, echoes, strict=True), state.wall - along, across)

    def _enter(
        self, beams: Iterable[tuple[float, Point]], ahead: float, across: float
    ) -> None:
        """Enter beams into the bins, with the wall at a distance."""
        state = self.state
        for far, (x, y) in beams:
            if x <= 0.3 * far:
                continue
            opens = x > ahead + DEEPER or far >= SONAR_RANGE
            if opens or abs(x - ahead) < DEEPER:
                place = across - state.origin + (y * ahead / x if opens else y)
                number = math.floor(place / BIN) + BINS
                if 0 <= number < 2 * BINS:
                    old = state.bins[number]
                    state.bins[number] = 0.6 * old + (0.4 if opens else -0.4)

    def _far(self, along: float) -> bool:
        """Return whether the wall is far enough away for a search of its gap."""
        return self.state.wall is not None and self.state.wall - along > CLOSE

    def _judge(self, along: float) -> None:
        """Set the stage: gap found, door closed, or robot through."""
        state = self.state
        if state.stage == "looking" and self._between():
            return
        if state.wall is None:
            if state.looks > 3 * LOOKS:
                state.stage = "closed"
            return
        if state.stage == "going" and not self._far(along):
            if along > state.wall + BEYOND - 0.05:
                state.stage = "through"
            return
        gap = self._gap()
        if gap is not None and state.looks >= LOOKS // 2:
            state.middle = state.origin + gap
            state.stage = "going"
        elif gap is None and state.looks >= LOOKS:
            state.stage = "closed"

    def _gap(self) -> float | None:
        """Return the middle of the gap, across the axis from the origin of the bins."""
        return gap_in(self.state.bins)

    def _look_aside(self, echoes: Sequence[Point], along: float, across: float) -> None:
        """Note the jambs if both sides have a jamb."""
        found = between_jambs(echoes)
        if found is not None:
            ahead, aside, wide = found
            self.state.jambs.append((along + ahead, across + aside, wide))

    def _between(self) -> bool:
        """Go on from between the jambs if most looks found jambs; return whether."""
        state = self.state
        if state.looks < LOOKS // 2 or 2 * len(state.jambs) <= state.looks:
            return False
        state.wall, state.middle, state.wide = (
            median(numbers) for numbers in zip(*state.jambs, strict=True)
        )
        state.stage = "between"
        return True

    def _hear(self, pose: Pose, ranges: Sequence[float]) -> None:
        """Keep the echoes on the way from between the jambs."""
        vote(self.state.votes, ranges, pose)
        self.state.rings.append(Ring(pose, tuple([round(r, 3) for r in ranges])))
        del self.state.rings[:-KEPT]

    def _look_back(self, along: float, heading: float) -> None:
        """Judge, after some way, whether a wall lies behind the robot."""
        state = self.state
        assert state.x is not None
        assert state.wall is not None
        assert state.middle is not None
        if along <= state.wall + BEYOND - 0.05:
            return
        x, y = turned_by(state.wall, state.middle, -heading)
        place = state.x + x, state.y + y
        square = square_to(state.votes, heading)
        walled = is_walled(state.rings, place, square, state.wide)
        state.stage = "through" if walled else "closed"


def plane_in(echoes: Sequence[Point]) -> float | None:
    """Return the distance of the plane with most echoes; None for fewer than three."""
    ahead = sorted(x for x, y in echoes if 0.3 < x < 2.5 and abs(y) < 1.6)
    best, found = 2, None
    for x in ahead:
        near = [other for other in ahead if x <= other < x + 0.15]
        if len(near) > best:
            best, found = len(near), sum(near) / len(near)
    return found


def _edges(echoes: Sequence[Point]) -> float | None:
    """Return the distance of a wall with room for an echo on each side of a gap.

    The end of a narrow hall may have too little wall for a plane.
    """
    low, high = EDGE
    near = [(x, y) for x, y in echoes if 0.3 < x < 2.5 and low < abs(y) < high]
    pairs = [
        (y - aside, (x + other) / 2)
        for x, y in near
        for other, aside in near
        if aside < 0 < y and abs(x - other) < FLAT
    ]
    return min(pairs)[1] if pairs else None


def is_before(wall: float | None) -> bool:
    """Return whether the wall's distance shows that the robot is before a doorway."""
    return wall is not None and AHEAD[0] < wall < AHEAD[1]


def gap_in(bins: Sequence[float]) -> float | None:
    """Return the middle of the gap nearest to the middle of the bins, in metres."""
    opened = [number for number, value in enumerate(bins) if value > 0]
    best: float | None = None
    for start in opened:
        if any(value > 0 for value in bins[max(0, start - 8) : start]) and not any(
            value < 0 for value in _before(bins, start)
        ):
            continue
        stop = start
        for number in range(start, len(bins)):
            if bins[number] < 0:
                break
            if bins[number] > 0:
                stop = number
        left, right = _edge(bins, start, -1), _edge(bins, stop, 1)
        middle = (left + right) / 2 * BIN - BINS * BIN
        wide = (right - left) * BIN
        if wide >= LEAST and abs(middle) <= OFF and abs(middle) < abs(best or OFF + 1):
            best = middle
    return best


def _before(bins: Sequence[float], start: int) -> Sequence[float]:
    """Return the bins between an open bin and the preceding open bin."""
    for number in range(start - 1, -1, -1):
        if bins[number] > 0:
            return bins[number + 1 : start]
    return bins[:start]


def _edge(bins: Sequence[float], last: int, step: int) -> float:
    """Return the end of a gap, in bins, beyond its last open bin."""
    number = last + step
    while 0 <= number < len(bins) and bins[number] == 0 and abs(number - last) < 8:
        number += step
    return (last + number) / 2 + 0.5
