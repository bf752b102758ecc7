"""Recognising by sonar a doorway that the robot has passed, on any route.

A narrow place has near echoes on two sides. A person beside a box makes a narrow place,
too; so the skill judges a narrow place from behind, by the echoes before and behind it.
A doorway is a gap in a wall. On both sides of the way the echoes lie in one plane
across the way, unbroken from the edge of the gap for longer than a person or a post is
wide. No beam has gone through the plane there.

    wall wall wall ...|        |... wall wall wall     echoes near one plane
                   one     the other
                  edge     edge

Each ring of echoes is kept with its position in the frame of dead reckoning. Over a few
metres of way the drift is smaller than the noise of the echoes.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import msgspec

from rapc.base.values import Atom
from rapc.worlds.hallway.channels import DIRECTIONS, PASSED, POSE, SONAR, SONARS, Pose
from rapc.worlds.hallway.skills.jambs import WIDTH
from rapc.worlds.hallway.skills.sonar import Point, Votes, turned_by, vote
from rapc.worlds.skills.declarations import Event, Parameter, Ports, Skill

KEPT = 50
"""The number of rings of echoes kept."""

APART = 0.05
"""The way after which a ring is kept, in metres."""

TURNED = 0.3
"""The turn after which a ring is kept, in radians."""

TIGHT = WIDTH[1] + 0.05
"""The maximum distance between the two nearest points at a narrow place, in metres."""

OPPOSITE = range(9, 16)
"""Sonars that look roughly in the opposite direction, counted from a sonar."""

PAST = 0.75
"""The distance behind a narrow place at which the robot looks back, in metres."""

BEFORE, BEHIND = 0.25, 0.35
"""The minimum distances across the plane, before and behind, in metres."""

BIN = 0.05
"""The size of a bin of a plane, in metres."""

FLAT = 0.05
"""The maximum distance of a wall's echoes from its plane, in metres."""

THROUGH = 0.15
"""The distance beyond the plane at which a beam has gone through, in metres."""

AWAY = 9
"""The maximum distance of the plane from the narrow place, in bins."""

SIDE = (0.15, 1.3)
"""The range to the side in which the wall's echoes are searched, in metres."""

RUN = 8
"""The minimum length of the wall from the edge of the gap, in bins."""

PIECES = 5
"""The minimum number of bins with echoes, of the first dozen from the edge."""

NEARLY = 0.25
"""The maximum difference between the widths of wall gap and jambs, in metres."""

PLANES = 6
"""The number of planes tried, planes with most bins first."""


class Ring(msgspec.Struct, frozen=True, array_like=True):
    """The readings of all sonars at a position, to the millimetre."""

    pose: Pose
    ranges: tuple[float, ...]


class Trail(msgspec.Struct):
    """The state of `detect-doorway`."""

    votes: Votes = msgspec.field(default_factory=Votes)
    #: The last rings, oldest first.
    rings: list[Ring] = []
    #: Narrow places that are not judged yet, oldest first.
    narrow: list[Point] = []


class PassedDoorway(Event):
    """The robot has passed a gap in a wall, with or without intent."""

    name = "passed-doorway"
    inputs = (PASSED,)
    carries = (
        Parameter("x", "number", "m", "the middle of the gap"),
        Parameter("y", "number", "m"),
        Parameter("heading", "number", "rad", "of the passage, square to the wall"),
    )

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return a gap's pose if a doorway is close behind the robot, else None."""
        gap = ports.get(PASSED)
        if gap is None:
            return None
        return round(gap.x, 2), round(gap.y, 2), round(gap.heading, 2)


class DetectDoorway(Skill):
    """Notice by sonar that the robot has gone through a gap in a wall."""

    name = "detect-doorway"
    inputs = (SONAR, POSE)
    outputs = (PASSED,)
    events = (PassedDoorway,)
    State = Trail
    state: Trail

    def step(self, now: float, ports: Ports) -> None:
        """Keep the echoes, and judge the narrow places behind the robot."""
        state, pose, ranges = self.state, ports[POSE], ports[SONAR]
        vote(state.votes, ranges, pose)
        if state.rings and not _moved(state.rings[-1].pose, pose):
            return
        state.rings.append(Ring(pose, tuple([round(r, 3) for r in ranges])))
        del state.rings[:-KEPT]
        if is_narrow(ranges):
            state.narrow.append((pose.x, pose.y))
        while state.narrow and _far(state.narrow[0], pose) >= PAST:
            gap = find_gap(state.rings, state.narrow.pop(0), state.votes)
            if gap is not None:
                ports[PASSED] = gap
                state.narrow, state.rings = [], state.rings[-1:]


def is_narrow(ranges: Sequence[float]) -> bool:
    """Return whether two opposite sides have near echoes."""
    near = min(ranges)
    first = ranges.index(near)
    return near + min(ranges[(first + n) % SONARS] for n in OPPOSITE) < TIGHT


def find_gap(rings: Sequence[Ring], place: Point, votes: Votes) -> Pose | None:
    """Return the middle and heading of the gap that the robot passed.

    Args:
        rings: the rings of echoes, oldest first; the robot is at the last position.
        place: the narrow place, in the frame of dead reckoning.
        votes: the votes on the direction of the walls.
    """
    axis = math.atan2(votes.sin, votes.cos) / 4
    for quarter in range(4):
        heading = axis + quarter * math.pi / 2
        ways = [
            turned_by(ring.pose.x - place[0], ring.pose.y - place[1], heading)[0]
            for ring in rings
        ]
        if ways[-1] < BEHIND or min(ways) > -BEFORE:
            continue
        found = _gap_across(list(_beams(rings, place, heading)))
        if found is not None:
            ahead, aside = found
            cos, sin = math.cos(heading), math.sin(heading)
            x, y = place[0] + ahead * cos - aside * sin, ahead * sin + aside * cos
            return Pose(x, place[1] + y, math.remainder(heading, 2 * math.pi))
    return None


Beam = tuple[float, float, float, float]
"""A beam's start and end, each along and across the way through a narrow place."""


def _beams(rings: Sequence[Ring], place: Point, heading: float) -> Iterator[Beam]:
    """Yield all beams, the narrow place at (0, 0)."""
    for ring in rings:
        x, y = turned_by(ring.pose.x - place[0], ring.pose.y - place[1], heading)
        turn = ring.pose.heading - heading
        cos, sin = math.cos(turn), math.sin(turn)
        for far, (dx, dy) in zip(ring.ranges, DIRECTIONS, strict=True):
            yield x, y, x + far * (dx * cos - dy * sin), y + far * (dx * sin + dy * cos)


def is_walled(rings: Sequence[Ring], place: Point, heading: float, wide: float) -> bool:
    """Return whether a wall begins on both sides of the robot's way.

    Args:
        rings: the echoes on the way from the place.
        place: the middle between two jambs, in the frame of dead reckoning.
        heading: the heading of the way.
        wide: the distance between the jambs, in metres.
    """
    beams = list(_beams(rings, place, heading))
    for plane in range(-AWAY, AWAY + 1):
        left, right = (_edge(votes) for votes in _votes(beams, plane * BIN))
        if left is None or right is None:
            continue
        if abs((left + right) * BIN - wide) < NEARLY:
            return True
    return False


def _gap_across(beams: Sequence[Beam]) -> Point | None:
    """Return the middle of a gap between two runs of one wall across the way."""
    for plane in _planes(beams):
        left, right = (_edge(votes) for votes in _votes(beams, plane * BIN))
        if left is not None and right is not None:
            wide = (left + right) * BIN
            if WIDTH[0] <= wide <= WIDTH[1]:
                return plane * BIN, (left - right) / 2 * BIN
    return None


def _planes(beams: Sequence[Beam]) -> list[int]:
    """Return planes with echoes on both sides of the way, in bins along the way."""
    hit: dict[int, tuple[set[int], set[int]]] = {}
    low, high = SIDE
    for _, _, x, y in beams:
        if low < abs(y) < high and abs(x) < (AWAY + 1) * BIN:
            sides = hit.setdefault(round(x / BIN), (set(), set()))
            sides[y < 0].add(math.floor(abs(y) / BIN))
    rated = []
    for plane in range(-AWAY, AWAY + 1):
        near = [hit[p] for p in (plane - 1, plane, plane + 1) if p in hit]
        pieces = min(len(set().union(*(n[side] for n in near))) for side in (0, 1))
        if pieces >= PIECES:
            rated.append((pieces, plane))
    return [plane for _, plane in sorted(rated, reverse=True)[:PLANES]]


def _votes(
    beams: Sequence[Beam], plane: float
) -> tuple[dict[int, int], dict[int, int]]:
    """Return for the bins to the left and to the right the votes for a wall.

    A beam that went through a bin counts against a wall.
    """
    sides: tuple[dict[int, int], dict[int, int]] = ({}, {})
    for x, y, end, aside in beams:
        if abs(end - plane) <= FLAT:
            where, hit = aside, 1
        elif (x - plane) * (end - plane) < 0 and abs(end - plane) > THROUGH:
            where, hit = y + (aside - y) * (plane - x) / (end - x), -1
        else:
            continue
        votes, number = sides[where < 0], math.floor(abs(where) / BIN)
        votes[number] = votes.get(number, 0) + hit
    return sides


def _edge(votes: dict[int, int]) -> int | None:
    """Return the first bin of a run of wall; None without a run."""
    wall = sorted(number for number, hits in votes.items() if hits > 0)
    if not wall:
        return None
    edge = wall[0]
    run = [number for number in wall if number < edge + 12]
    pierced = sum(votes.get(number, 0) < 0 for number in range(edge, edge + RUN))
    whole = len(run) >= PIECES and run[-1] >= edge + RUN - 1 and pierced <= 1
    return edge if whole else None


def _moved(before: Pose, now: Pose) -> bool:
    turned = math.remainder(before.heading - now.heading, 2 * math.pi)
    return _far((before.x, before.y), now) >= APART or abs(turned) >= TURNED


def _far(place: Point, pose: Pose) -> float:
    return math.hypot(place[0] - pose.x, place[1] - pose.y)
