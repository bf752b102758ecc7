"""The facts about the building that the robot knows at the start [S 3.2].

Directions and distances have the precision of a hand-written list: a tenth of a metre,
a tenth of a radian.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rapc.base.values import Fact, Number, Text, number
from rapc.worlds.hallway.map import Map, Sign, openings, signs
from rapc.worlds.hallway.simulation import STANDOFF

SAME = 0.01
"""The distance below which two places have no direction, in metres."""


def map_facts(map: Map) -> Iterator[Fact]:
    """Yield the facts of a map.

    `(location-data mark left right apart "print name")` describes the tags of a
    landmark, `(connects mark space beyond)` gives the space beyond a doorway,
    `(relative-loc space mark other direction distance)` gives the way from one landmark
    of a space to another. The direction is counter-clockwise from the heading of a
    robot that faces the first landmark.
    """
    hung = signs(map)
    for sign in {sign.landmark: sign for sign in hung}.values():
        apart = number(round(sign.apart, 1))
        yield ("location-data", sign.landmark, *sign.tags, apart, Text(sign.says))
    for gap in openings(map):
        one, other = gap.doorway.joins
        yield ("connects", gap.doorway.name, one, other)
        yield ("connects", gap.doorway.name, other, one)
    for space in map.space:
        yield from _relations(space.name, [s for s in hung if s.space == space.name])
        if space.kind == "lift":
            yield from _lift_doors([sign for sign in hung if sign.space == space.name])
    for mark in map.landmark:
        if mark.charger:
            yield ("charger-at", mark.name, mark.space)
    start = next(sign for sign in hung if sign.landmark == map.start)
    yield ("current-space", "robot", start.space)
    yield ("current-location", "robot", start.landmark)
    x, y = start.front(STANDOFF)
    heading = math.remainder(start.normal + math.pi, math.tau)
    place = [number(round(v, 2)) for v in (x, y, heading)]
    yield ("orientation", "robot", *place)
    yield ("base", start.landmark, *place)


def relation(start: Sign, end: Sign) -> tuple[Number, Number]:
    """Return direction and distance between the robot's places before two landmarks.

    The directions from one place to the other and back tell how the landmarks are
    turned: so they are opposite even if the two places are the same.
    """
    (ax, ay), (bx, by) = start.front(STANDOFF), end.front(STANDOFF)
    heading, distance = math.atan2(by - ay, bx - ax), math.hypot(bx - ax, by - ay)
    if distance < SAME:
        first, _ = sorted((start, end), key=lambda sign: sign.landmark)
        heading = first.normal + (0.0 if first is start else math.pi)
    direction = heading - start.normal - math.pi
    return (
        number(round(math.remainder(direction, math.tau), 1)),
        number(round(distance, 1)),
    )


def _lift_doors(hung: Sequence[Sign]) -> Iterator[Fact]:
    for sign in hung:
        side = math.remainder(sign.normal - hung[0].normal, math.tau)
        turned = number(round(side, 1))
        yield ("lift-door", sign.space, sign.landmark, sign.floor, turned)


def _relations(space: str, hung: Sequence[Sign]) -> Iterator[Fact]:
    for one in hung:
        for other in hung:
            if one is not other and one.floor == other.floor:
                marks = one.landmark, other.landmark
                yield ("relative-loc", space, *marks, *relation(one, other))
