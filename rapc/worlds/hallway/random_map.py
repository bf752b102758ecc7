"""A random building: a ring of hallways with rooms outside and inside of the ring.

For every seed, all spaces can be reached. Doorways and landmarks keep a distance from
corners, and obstacles from doorways, because the robot's skills need the room.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from random import Random
from typing import Literal

from rapc.worlds.hallway.map import (
    Box,
    Doorway,
    Landmark,
    Map,
    Obstacle,
    Person,
    Side,
    Space,
)

HALL = 2.0
"""The width of a hallway, in metres."""

THICK = 0.2
"""The thickness of walls, in metres."""

CORNER = 1.3
"""The minimum distance of a doorway's or landmark's middle from a corner, in metres."""


def random_map(seed: int) -> Map:
    """Return the building of a seed; equal seeds return equal buildings."""
    rng = Random(f"building {seed}")
    return _Builder(rng).build()


class _Builder:
    """A building under construction; tags are numbered in order."""

    def __init__(self, rng: Random) -> None:
        self.rng = rng
        self.spaces: list[Space] = []
        self.doorways: list[Doorway] = []
        self.landmarks: list[Landmark] = []
        self.obstacles: list[Obstacle] = []
        self.tags = 0

    def build(self) -> Map:
        """Return the building, from the ring inwards and outwards."""
        rng = self.rng
        wide, high = rng.uniform(18, 26), rng.uniform(12, 17)
        self._ring(wide, high)
        inner, below = (HALL + THICK, high - HALL - THICK), (-THICK - 5.0, -THICK)
        above = (high + THICK, high + THICK + 5.0)
        columns = (HALL + THICK, wide - HALL - THICK)
        for bottom, top, hall, wall in (
            (*below, "south-hall", "north"),
            (*above, "north-hall", "south"),
            (*inner, rng.choice(("south-hall", "north-hall")), ""),
        ):
            rooms = []
            for left, right in self._columns(*columns):
                rooms.append(self._room((left, bottom, right, top), hall, wall))
            self._join(rooms)
        start = self.landmarks[0]
        halls = ("south-hall", "north-hall", "east-hall")
        people = [Person(name, round(rng.uniform(0.5, 1.0), 2)) for name in halls]
        spaces, doorways = tuple(self.spaces), tuple(self.doorways)
        rest = tuple(self.landmarks), tuple(self.obstacles), tuple(people)
        return Map(spaces, doorways, start.name, *rest)

    def _ring(self, wide: float, high: float) -> None:
        """Add four hallways with a doorway at each corner."""
        west: Box = (0.0, 0.0, HALL, high)
        east: Box = (wide - HALL, 0.0, wide, high)
        left, right = HALL + THICK, wide - HALL - THICK
        for name, box in (
            ("west-hall", west),
            ("east-hall", east),
            ("south-hall", (left, 0.0, right, HALL)),
            ("north-hall", (left, high - HALL, right, high)),
        ):
            self.spaces.append(Space(name, box, "hall"))
        for across, at in (("south-hall", HALL / 2), ("north-hall", high - HALL / 2)):
            for along in ("west-hall", "east-hall"):
                self._doorway((across, along), at, door=False)

    def _columns(self, left: float, right: float) -> Iterator[tuple[float, float]]:
        """Cut a strip into rooms from four to seven metres wide."""
        while right - left > 8.4:
            cut = left + self.rng.uniform(4, min(7, right - left - 4.2))
            yield left, cut
            left = cut + THICK
        yield left, right

    def _room(self, box: Box, hall: str, side: str) -> Space:
        """Add a room with a door to its hallway and a landmark on another wall."""
        left, bottom, right, top = box
        wall = side or ("south" if hall == "south-hall" else "north")
        others: list[Side] = ["west", "east"]
        far: Literal["north", "south"] = "south" if wall == "north" else "north"
        room = Space(f"room-{len(self.spaces) - 3}", box)
        self.spaces.append(room)
        at = self.rng.uniform(left + CORNER, right - CORNER)
        self._doorway((room.name, hall), at, door=self.rng.random() < 0.4)
        hung: Side = self.rng.choice([far, *others]) if top - bottom < 6 else far
        low, high = (bottom, top) if hung in others else (left, right)
        place = self.rng.uniform(low + CORNER, high - CORNER)
        name, first = f"mark-{len(self.landmarks) + 1}", not self.landmarks
        at, tags = round(place, 2), self._pair()
        mark = Landmark(name, room.name, hung, at, tags, charger=first)
        self.landmarks.append(mark)
        if self.rng.random() < 0.4:
            half, x, y = self.rng.uniform(0.3, 0.5), left + right, bottom + top
            middle = (x / 2 - half, y / 2 - half, x / 2 + half, y / 2 + half)
            self.obstacles.append(Obstacle(middle))
        return room

    def _join(self, rooms: list[Space]) -> None:
        """Add random doors between neighbours, at places without a landmark."""
        for one, other in pairwise(rooms):
            hung = {(mark.space, mark.wall) for mark in self.landmarks}
            free = not hung & {(one.name, "east"), (other.name, "west")}
            if free and self.rng.random() < 0.4:
                middle = (one.box[1] + one.box[3]) / 2
                self._doorway((one.name, other.name), middle, door=True)

    def _doorway(self, joins: tuple[str, str], at: float, *, door: bool) -> None:
        name = f"door-{len(self.doorways) + 1}"
        made = Doorway(name, joins, round(at, 2), self._pair(), door=door)
        self.doorways.append(made)

    def _pair(self) -> tuple[int, int]:
        self.tags += 2
        return self.tags - 2, self.tags - 1
