"""Walls of a floor for rays and collisions, found by a grid over the walls.

All walls are parallel to the axes. For a square metre of floor, four lists keep the
walls within reach: the walls to the right by rising x, the walls to the left by falling
x, and correspondingly for up and down. A ray to the upper right searches the list of
the right and the list of the top. The search of a list stops at the first wall beyond
the nearest hit: in a hallway after two or three walls, whatever the size of the
building. The lists of a square are made at its first use.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from rapc.worlds.hallway.map import Box, Map, Opening, openings

Line = tuple[float, float, float]
"""A wall: its x (or y), and the lower and upper end of the other coordinate."""

Lists = tuple[list[Line], list[Line], list[Line], list[Line]]
"""The walls around a square: to the right, to the left, above, below."""

REACH = 8.0
"""The maximum distance of walls from their square, in metres."""

_PARALLEL = 1e-9


class FloorPlan:
    """The walls of one floor, closed doors included."""

    def __init__(self, boxes: Iterable[Box], obstacles: Iterable[Box]) -> None:
        self._upright, self._level = outlines(list(boxes))
        for left, bottom, right, top in obstacles:
            self._upright += [(left, bottom, top), (right, bottom, top)]
            self._level += [(bottom, left, right), (top, left, right)]
        self._closed: list[Box] = []
        self._squares: dict[tuple[int, int], Lists] = {}

    def close(self, doors: Sequence[Box]) -> None:
        """Close the given doors (flat boxes) and open all other doors."""
        self._closed = list(doors)
        self._squares.clear()

    def cast(self, x: float, y: float, dx: float, dy: float, limit: float) -> float:
        """Return the distance along a ray to the nearest wall, at most `limit` metres.

        Args:
            x: the start of the ray.
            y: the start of the ray.
            dx: the direction, of length 1.
            dy: the direction, of length 1.
            limit: at most `REACH`.
        """
        return self.hit(x, y, dx, dy, limit)[0]

    def hit(
        self, x: float, y: float, dx: float, dy: float, limit: float
    ) -> tuple[float, float]:
        """Return the result of `cast`, and the cosine of the angle of incidence.

        The cosine is 1 if no wall is nearer than `limit`.
        """
        right, left, above, below = self._around(x, y)
        best, cosine = limit, 1.0
        for walls, at, step, aside, drift in (
            (right if dx > 0 else left, x, dx, y, dy),
            (above if dy > 0 else below, y, dy, x, dx),
        ):
            if step > _PARALLEL or step < -_PARALLEL:
                inverse = 1 / step
                for wall, low, high in walls:
                    far = (wall - at) * inverse
                    if far >= best:
                        break
                    if far >= 0 and low <= aside + far * drift <= high:
                        best, cosine = far, abs(step)
                        break
        return best, cosine

    def nearest(self, x: float, y: float, limit: float) -> tuple[float, float, float]:
        """Return the nearest point of a wall within `limit`: distance, x, y.

        The distance is `limit` if no wall is nearer.
        """
        found = (limit, x, y)
        right, left, above, below = self._around(x, y)
        for lists, across in (((right, left), False), ((above, below), True)):
            own, other = (y, x) if across else (x, y)
            for walls in lists:
                for wall, low, high in walls:
                    away = wall - own
                    if (away > limit) if walls is lists[0] else (away < -limit):
                        break
                    along = min(max(other, low), high)
                    far = math.hypot(away, along - other)
                    if far < found[0]:
                        found = (far, along, wall) if across else (far, wall, along)
        return found

    def _around(self, x: float, y: float) -> Lists:
        square = (math.floor(x), math.floor(y))
        lists = self._squares.get(square)
        if lists is None:
            lists = self._squares[square] = self._lists(*square)
        return lists

    def _lists(self, column: int, row: int) -> Lists:
        upright, level = list(self._upright), list(self._level)
        for left, bottom, right, top in self._closed:
            if left == right:
                upright.append((left, bottom, top))
            else:
                level.append((bottom, left, right))
        near_upright = _near(upright, column, row)
        near_level = _near(level, row, column)
        return (
            [line for line in near_upright if line[0] >= column],
            [line for line in reversed(near_upright) if line[0] <= column + 1],
            [line for line in near_level if line[0] >= row],
            [line for line in reversed(near_level) if line[0] <= row + 1],
        )


def _near(lines: Iterable[Line], own: int, other: int) -> list[Line]:
    """Return the walls within reach of a square, by rising coordinate."""
    return sorted(
        line
        for line in lines
        if own - REACH <= line[0] <= own + 1 + REACH
        and line[1] <= other + 1 + REACH
        and line[2] >= other - REACH
    )


def outlines(boxes: Sequence[Box]) -> tuple[list[Line], list[Line]]:
    """Return the outline of a union of rectangles that touch, but do not overlap.

    Returns:
        Upright and level walls. Touching rectangles have no wall between them.
    """
    upright: list[Line] = []
    level: list[Line] = []
    for left, bottom, right, top in boxes:
        upright += _sides(left, bottom, top, [(b[2], b[1], b[3]) for b in boxes])
        upright += _sides(right, bottom, top, [(b[0], b[1], b[3]) for b in boxes])
        level += _sides(bottom, left, right, [(b[3], b[0], b[2]) for b in boxes])
        level += _sides(top, left, right, [(b[1], b[0], b[2]) for b in boxes])
    return upright, level


def _sides(at: float, low: float, high: float, touching: Iterable[Line]) -> list[Line]:
    """Return a side of a rectangle without the parts where other rectangles touch."""
    parts = [(low, high)]
    for wall, start, stop in touching:
        if wall == at:
            parts = [
                piece
                for a, b in parts
                for piece in ((a, min(b, start)), (max(a, stop), b))
                if piece[0] < piece[1]
            ]
    return [(at, a, b) for a, b in parts]


def door_box(opening: Opening) -> Box:
    """Return the closed door of an opening, flat, in the middle of the wall."""
    left, bottom, right, top = opening.box
    if opening.side in {"east", "west"}:
        middle = (left + right) / 2
        return (middle, bottom, middle, top)
    middle = (bottom + top) / 2
    return (left, middle, right, middle)


def floor_plans(map: Map) -> dict[int, FloorPlan]:
    """Return the plan of each floor of a map, with all doors open."""
    floors = sorted({floor for space in map.space for floor in space.floors})
    gaps = openings(map)
    return {
        floor: FloorPlan(
            [space.box for space in map.space if floor in space.floors]
            + [gap.box for gap in gaps if gap.floor == floor],
            [box.box for box in map.obstacle if box.floor == floor],
        )
        for floor in floors
    }
