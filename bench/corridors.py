"""Buildings of long corridors and narrow doorways, made at random for `bench.journeys`.

A corridor of 24 to 44 metres runs from west to east, with rooms on both sides and a
cross corridor at one end or at both. Doorways are 0.7 to 0.9 m wide by default.

    +------+--------+------+  +--+
    |      |        |      |  |  |
    +-  ---+---  ---+-  ---+--+  |
    |                            |    (doorways are gaps)
    +-  ------+----  ------+--+  |
    |         |            |  |  |
    +---------+------------+  +--+
"""

from __future__ import annotations

import json
from random import Random
from typing import Any, Literal

import msgspec

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

THICK = 0.2
"""The thickness of walls, in metres."""

CORNER = 1.0
"""Distance from a corner to the middle of a doorway or landmark, in metres, at least.
"""

LENGTHS = (24.0, 44.0)
WIDTHS = (1.6, 2.2)
"""Length and width of a corridor, in metres."""

DOORWAYS = (0.7, 0.9)
"""Width of a doorway, in metres, unless another is given."""


def corridors(seed: int, doorways: tuple[float, float] = DOORWAYS) -> Map:
    """Return the building of a seed.

    Args:
        seed: of all that is drawn.
        doorways: the narrowest and the widest doorway, in metres.
    """
    rng = Random(f"corridors {seed}")
    builder = _Builder(rng, doorways)
    length, wide = rng.uniform(*LENGTHS), rng.uniform(*WIDTHS)
    spine = builder.space("spine", (0, 0, length, wide), "hall")
    rows: tuple[tuple[float, float, Side], ...] = (
        (-6.0, -THICK, "north"),
        (wide + THICK, wide + 6.0, "south"),
    )
    for bottom, top, side in rows:
        left = 0.0
        while length - left > 3.5:
            right = min(length, left + rng.uniform(3.5, 7))
            deep = rng.uniform(0, 1.5)
            if side == "north":
                builder.room((left, bottom + deep, right, top), spine, side)
            else:
                builder.room((left, bottom, right, top - deep), spine, side)
            left = right + THICK
    east = (length + THICK, -7.0, length + THICK + rng.uniform(*WIDTHS), 8.0)
    builder.cross("east-hall", east, spine, wide / 2)
    if rng.random() < 0.5:
        west = (-THICK - rng.uniform(*WIDTHS), -7.0, -THICK, 8.0)
        builder.cross("west-hall", west, spine, wide / 2)
    return builder.build()


def toml_text(map: Map) -> str:
    """Return a map as TOML, for the option `map` of the world."""
    raw: dict[str, Any] = msgspec.to_builtins(map)
    lines = [f"start = {json.dumps(raw.pop('start'))}"]
    for kind, entries in raw.items():
        for entry in entries:
            lines.append(f"[[{kind}]]")
            lines += [f"{key} = {json.dumps(value)}" for key, value in entry.items()]
    return "\n".join(lines)


class _Builder:
    """A building under construction; it numbers tags in order."""

    def __init__(self, rng: Random, doorways: tuple[float, float]) -> None:
        self.rng = rng
        self.widths = doorways
        self.spaces: list[Space] = []
        self.doorways: list[Doorway] = []
        self.landmarks: list[Landmark] = []
        self.obstacles: list[Obstacle] = []
        self.tags = 0

    def build(self) -> Map:
        """Return the building with two or three people in its corridors."""
        halls = [space.name for space in self.spaces if space.kind == "hall"]
        people = [
            Person(self.rng.choice(halls), round(self.rng.uniform(0.5, 1.0), 2))
            for _ in range(self.rng.randint(2, 3))
        ]
        return Map(
            tuple(self.spaces),
            tuple(self.doorways),
            self.landmarks[0].name,
            tuple(self.landmarks),
            tuple(self.obstacles),
            tuple(people),
        )

    def space(
        self, name: str, box: Box, kind: Literal["room", "hall"] = "room"
    ) -> Space:
        """Add a space, its box rounded to a centimetre."""
        left, bottom, right, top = (round(edge, 2) for edge in box)
        self.spaces.append(Space(name, (left, bottom, right, top), kind))
        return self.spaces[-1]

    def room(self, box: Box, hall: Space, side: Side) -> None:
        """Add a room with a doorway to the hall and a landmark on another wall."""
        rng = self.rng
        room = self.space(f"room-{len(self.spaces)}", box)
        left, bottom, right, top = room.box
        at = rng.uniform(left + CORNER, right - CORNER)
        self.doorway(room, hall, at, door=rng.random() < 0.3)
        opposite: Side = "south" if side == "north" else "north"
        wall: Side = rng.choice([opposite, "west", "east"])
        low, high = (left, right) if wall == opposite else (bottom, top)
        self.landmark(room, wall, rng.uniform(low + CORNER, high - CORNER))
        if rng.random() < 0.3 and right - left > 5:
            x, y, half = (left + right) / 2, (bottom + top) / 2, 0.3
            box = (x - half, y - half, x + half, y + half)
            self.obstacles.append(Obstacle(box))

    def cross(self, name: str, box: Box, hall: Space, at: float) -> None:
        """Add a cross corridor with a landmark at each end."""
        made = self.space(name, box, "hall")
        self.doorway(made, hall, at, door=False)
        middle = (made.box[0] + made.box[2]) / 2
        for wall in ("north", "south"):
            self.landmark(made, wall, middle)

    def doorway(self, one: Space, other: Space, at: float, *, door: bool) -> None:
        """Add a doorway."""
        width = round(self.rng.uniform(*self.widths), 2)
        apart = round(self.rng.uniform(width + 0.1, 1.5), 2)
        name, joins = f"door-{len(self.doorways) + 1}", (one.name, other.name)
        tags = self._pair()
        self.doorways.append(
            Doorway(name, joins, round(at, 2), tags, width, apart, door)
        )

    def landmark(self, space: Space, wall: Side, at: float) -> None:
        """Add a landmark; the first is a charger."""
        name, first = f"mark-{len(self.landmarks) + 1}", not self.landmarks
        self.landmarks.append(
            Landmark(name, space.name, wall, round(at, 2), self._pair(), charger=first)
        )

    def _pair(self) -> tuple[int, int]:
        self.tags += 2
        return self.tags - 2, self.tags - 1
