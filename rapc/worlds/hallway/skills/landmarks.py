"""Landmarks by laser: watching for a landmark, and going to it.

The laser gives only the bearings of a landmark's two tags. Their distance follows from
the angle between the bearings, the rough distance between the tags, and the direction
that the tags face. Tags hang on walls, and the sonars measure the direction of walls.
So the tags face one of the two directions that are square to the walls and towards the
robot. Both directions are kept as guesses. In every tick each guess gives a place for
the landmark. While the robot moves, the places of the right guess agree, and the places
of the wrong guess wander. The sonars should also find a wall where a guess has the
tags.

With the tags h to the left and the right of the middle, turned away from the line of
sight by w and seen under the angle a, the distance d solves

    tan a = 2 h d cos w / (d^2 - h^2);

a is more than a right angle if d is less than h.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import msgspec

from rapc.base.values import Atom
from rapc.worlds.hallway.channels import (
    FIX,
    LASER_RANGE,
    POSE,
    SIGHTING,
    SONAR,
    SONARS,
    TAGS,
    TRAJECTORY,
    TRAVEL,
    Pose,
    PositionFix,
    Sighting,
    Tag,
    Trajectory,
)
from rapc.worlds.hallway.skills.moving import FACING, SPEED, MovementComplete
from rapc.worlds.hallway.skills.sonar import (
    QUARTER,
    Votes,
    bearing_of,
    echo_points,
    square_to,
    turned,
    vote,
)
from rapc.worlds.hallway.skills.tags import between
from rapc.worlds.skills.declarations import Event, Parameter, Ports, Skill

LOST = 6.0
"""Seconds out of sight after which a landmark is lost."""

LEARNING = 0.15
"""The weight of each new place in the estimate."""

OPEN = 0.4
"""The distance beyond an expected wall at which an echo shows an opening, in metres."""

BESIDE = (0.2, 2.0)
"""The maximum distance of an echo of the wall beside a doorway: from the plane of the
wall and, along the wall, from the robot, in metres.
"""

AT = 0.12
"""The maximum distance from the place before the landmark, in metres."""

FITS = 0.15
"""The maximum error of a tag's bearing, in radians."""

MARK = (
    Parameter("mark", "symbol", "", "what the landmark is called"),
    Parameter("left", "number", "", "the code of its left tag"),
    Parameter("right", "number", "", "the code of its right tag"),
    Parameter("apart", "number", "m", "about how far the tags are apart", low=0.1),
)

SIGHT = (
    Parameter("mark", "symbol"),
    Parameter("distance", "number", "m", "roughly"),
    Parameter("heading", "number", "rad", "in the frame of dead reckoning"),
)


class InView(msgspec.Struct):
    """The state of `watch-for-landmark`."""

    #: Ticks with both tags in view.
    ticks: int = 0


class LandmarkVisible(Event):
    """The landmark has come into view."""

    name = "landmark-visible"
    inputs = (SIGHTING, POSE)
    carries = SIGHT

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return the rough place of the landmark if both tags are seen, else None."""
        seen = ports.get(SIGHTING)
        if seen is None:
            return None
        heading = math.remainder(seen.bearing + ports[POSE].heading, 2 * math.pi)
        return (self.arguments["mark"], round(seen.distance, 2), round(heading, 2))


class WatchForLandmark(Skill):
    """Watch for one landmark."""

    name = "watch-for-landmark"
    inputs = (TAGS,)
    outputs = (SIGHTING,)
    parameters = MARK
    events = (LandmarkVisible,)
    State = InView
    state: InView

    def step(self, now: float, ports: Ports) -> None:
        """Write the sighting once both tags have been seen twice in a row."""
        pair = both(ports[TAGS], self.arguments)
        self.state.ticks = self.state.ticks + 1 if pair else 0
        if pair is not None and self.state.ticks > 1:
            left, right = pair
            ports[SIGHTING] = sighting(left, right, float(self.arguments["apart"]))


class LandmarkLost(Event):
    """The landmark has not been seen for some time."""

    name = "lost-landmark"
    inputs = (FIX,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple if the last sighting is too old, else None."""
        return () if ports[FIX].age > LOST else None


class Guess(msgspec.Struct):
    """A landmark under the assumption of one of its possible directions."""

    normal: float
    x: float
    y: float
    #: The recent spread of the places, and their distance beyond the laser's reach, in
    #: metres.
    wander: float = 0.0


class Tracked(msgspec.Struct):
    """The state of `track-landmark`."""

    votes: Votes = msgspec.field(default_factory=Votes)
    guesses: list[Guess] = msgspec.field(default_factory=list)
    #: The time of the last sighting; None before the first tick.
    seen: float | None = None


class TrackLandmark(Skill):
    """Keep an estimate of where a landmark is and how it is turned."""

    name = "track-landmark"
    inputs = (TAGS, POSE, SONAR)
    outputs = (FIX, SIGHTING)
    parameters = MARK
    events = (LandmarkVisible, LandmarkLost)
    State = Tracked
    state: Tracked
    #: Whether the sonars hear each wall, so that silence shows that there is none.
    hears_walls: ClassVar[bool] = True

    def step(self, now: float, ports: Ports) -> None:
        """Update the estimate from the laser's view of the landmark."""
        state, pose = self.state, ports[POSE]
        vote(state.votes, ports[SONAR], pose)
        state.seen = now if state.seen is None else state.seen
        pair = both(ports[TAGS], self.arguments)
        if pair is not None:
            state.seen = now
            half = float(self.arguments["apart"]) / 2
            self._learn(pair, pose, half, ports[SONAR])
            ports[SIGHTING] = sighting(*pair, 2 * half)
        age = now - state.seen
        if not state.guesses:
            ports[FIX] = PositionFix(pose.x, pose.y, pose.heading, age, known=False)
            return
        best = min(state.guesses, key=lambda guess: guess.wander)
        half = float(self.arguments["apart"]) / 2
        in_view = pair is not None and _fits(best, half, pair, pose)
        ports[FIX] = PositionFix(best.x, best.y, best.normal, age, in_view=in_view)

    def _learn(
        self,
        pair: tuple[Tag, Tag],
        pose: Pose,
        half: float,
        ranges: Sequence[float],
    ) -> None:
        """Update both guesses with the implied places."""
        left, right = pair
        sight = pose.heading + between(left, right)
        facing = sight + math.pi
        nearest = square_to(self.state.votes, facing)
        off = math.remainder(nearest - facing, 2 * math.pi)
        other = nearest - math.copysign(QUARTER, off)
        angle = math.remainder(left.bearing - right.bearing, 2 * math.pi)
        places = []
        for normal in (nearest, other):
            cos = math.cos(normal - facing)
            far = distance(angle, half, cos)
            x, y = pose.x + far * math.cos(sight), pose.y + far * math.sin(sight)
            beyond = max(0.0, far - LASER_RANGE)
            ahead = normal + math.pi - pose.heading
            if self.hears_walls and open_to(ranges, ahead, far * cos):
                beyond += 1.0
            places.append(Guess(math.remainder(normal, 2 * math.pi), x, y, beyond))
        if not self.state.guesses:
            places[1].wander += 0.1
            self.state.guesses = places
            return
        for guess in self.state.guesses:
            self._improve(guess, places)

    def _improve(self, guess: Guess, places: Sequence[Guess]) -> None:
        """Move a guess towards the place with the same direction."""
        off, new = min(
            (abs(math.remainder(p.normal - guess.normal, 2 * math.pi)), n, p)
            for n, p in enumerate(places)
        )[::2]
        if off > QUARTER / 2:
            guess.wander += 0.01
            return
        dx, dy = new.x - guess.x, new.y - guess.y
        wander = math.hypot(dx, dy) + new.wander
        guess.wander += 0.05 * (wander - guess.wander)
        guess.x += LEARNING * dx
        guess.y += LEARNING * dy
        guess.normal = new.normal


class LandmarkApproach(msgspec.Struct):
    """The state of `approach-landmark`."""

    #: Whether the robot is at its place and only turns.
    turning: bool = False
    done: bool = False


class AtLandmark(Event):
    """The robot stands before the landmark, and faces it squarely."""

    name = "at-landmark"
    inputs = (TRAVEL, POSE)
    carries = (
        Parameter("x", "number", "m", "by dead reckoning"),
        Parameter("y", "number", "m"),
        Parameter("heading", "number", "rad"),
    )

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return the landmark's pose if the robot has arrived, else None."""
        pose = ports[POSE]
        here = round(pose.x, 2), round(pose.y, 2), round(pose.heading, 3)
        return here if ports[TRAVEL] else None


class ApproachLandmark(Skill):
    """Drive to a point straight in front of a landmark, and turn to the landmark."""

    name = "approach-landmark"
    inputs = (FIX, POSE)
    outputs = (TRAJECTORY, TRAVEL)
    parameters = (Parameter("standoff", "number", "m", low=0.4, high=3), SPEED)
    events = (AtLandmark, MovementComplete)
    State = LandmarkApproach
    state: LandmarkApproach

    def step(self, now: float, ports: Ports) -> None:
        """Write the trajectory to the place; wait until the landmark has been seen."""
        state, fix, pose = self.state, ports[FIX], ports[POSE]
        ports[TRAVEL] = False
        if not fix.known:
            ports[TRAJECTORY] = Trajectory(0.0, 0.0, turn=True)
            return
        standoff = float(self.arguments["standoff"])
        dx = fix.x + standoff * math.cos(fix.normal) - pose.x
        dy = fix.y + standoff * math.sin(fix.normal) - pose.y
        left = math.hypot(dx, dy)
        state.turning = left < (0.3 if state.turning else AT)
        if state.turning:
            bearing = bearing_of(fix.normal + math.pi, pose)
            ports[TRAVEL] = fix.in_view and abs(bearing) < FACING
            ports[TRAJECTORY] = Trajectory(bearing, 0.0, turn=True)
            return
        bearing = bearing_of(math.atan2(dy, dx), pose)
        ports[TRAJECTORY] = Trajectory(bearing, float(self.arguments["speed"]), left)


def open_to(ranges: Sequence[float], bearing: float, wall: float) -> bool:
    """Return whether no wall is square to a bearing at this distance.

    A gap in that wall is a doorway: there is wall on at least one side of it.
    """
    middle = round(bearing / (2 * math.pi) * SONARS)
    near = min(ranges[(middle + off) % SONARS] for off in (-1, 0, 1))
    if near <= wall + OPEN:
        return False
    echoes = turned(echo_points(ranges), bearing)
    return not any(abs(x - wall) < BESIDE[0] and abs(y) < BESIDE[1] for x, y in echoes)


def _fits(guess: Guess, half: float, pair: tuple[Tag, Tag], pose: Pose) -> bool:
    """Return whether both tags are seen at the bearings that a guess predicts."""
    aside_x, aside_y = math.sin(guess.normal) * half, -math.cos(guess.normal) * half
    for tag, side in zip(pair, (1, -1), strict=True):
        x, y = guess.x + side * aside_x - pose.x, guess.y + side * aside_y - pose.y
        off = math.remainder(bearing_of(math.atan2(y, x), pose) - tag.bearing, math.tau)
        if abs(off) > FITS:
            return False
    return True


def both(tags: Sequence[Tag], arguments: Mapping[str, Any]) -> tuple[Tag, Tag] | None:
    """Return the left and the right tag of a landmark, if both are in view."""
    seen = {tag.code: tag for tag in tags}
    left, right = seen.get(arguments["left"]), seen.get(arguments["right"])
    return (left, right) if left is not None and right is not None else None


def sighting(left: Tag, right: Tag, apart: float) -> Sighting:
    """Return the place of a landmark whose tags are not turned away."""
    angle = math.remainder(left.bearing - right.bearing, 2 * math.pi)
    far = min(LASER_RANGE, distance(angle, apart / 2, 1.0))
    return Sighting(far, between(left, right))


def distance(angle: float, half: float, cos: float) -> float:
    """Return the distance of two tags.

    Args:
        angle: the angle between the two bearings.
        half: half the distance between the tags.
        cos: the cosine of the angle by which the tags are turned away.
    """
    angle = max(0.01, min(angle, math.pi - 0.01))
    along, sin = cos * math.cos(angle), math.sin(angle)
    return half * (along + math.hypot(along, sin)) / sin
