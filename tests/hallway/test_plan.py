"""Rays and distances by the grid are those that a search of all walls finds."""

from __future__ import annotations

import math
from random import Random

import pytest

from rapc.worlds.hallway.map import openings
from rapc.worlds.hallway.map_text import named_map
from rapc.worlds.hallway.plan import Line, door_box, floor_plans, outlines

Walls = tuple[list[Line], list[Line]]


def _cast(walls: Walls, x: float, y: float, angle: float, limit: float) -> float:
    dx, dy = math.cos(angle), math.sin(angle)
    best = limit
    for lines, own, other, d_own, d_other in (
        (walls[0], x, y, dx, dy),
        (walls[1], y, x, dy, dx),
    ):
        for at, low, high in lines:
            if d_own:
                far = (at - own) / d_own
                if 0 <= far < best and low <= other + far * d_other <= high:
                    best = far
    return best


def _nearest(walls: Walls, x: float, y: float) -> float:
    found = math.inf
    for lines, own, other in ((walls[0], x, y), (walls[1], y, x)):
        for at, low, high in lines:
            along = min(max(other, low), high)
            found = min(found, math.hypot(at - own, along - other))
    return found


def test_a_grid_finds_what_a_search_of_all_walls_finds() -> None:
    map, rng = named_map("default"), Random(3)
    plan = floor_plans(map)[1]
    gaps = [gap for gap in openings(map) if gap.floor == 1]
    boxes = [space.box for space in map.space if 1 in space.floors]
    boxes += [gap.box for gap in gaps]
    closed = [door_box(gap) for gap in gaps[::2]]
    plan.close(closed)
    upright, level = outlines(boxes)
    for left, bottom, right, top in [b.box for b in map.obstacle] + closed:
        upright += [(left, bottom, top), (right, bottom, top)]
        level += [(bottom, left, right), (top, left, right)]
    for _ in range(2000):
        left, bottom, right, top = rng.choice(boxes)
        x, y = rng.uniform(left, right), rng.uniform(bottom, top)
        angle, limit = rng.uniform(-4, 4), rng.uniform(0.5, 7.5)
        dx, dy = math.cos(angle), math.sin(angle)
        wanted = _cast((upright, level), x, y, angle, limit)
        assert plan.cast(x, y, dx, dy, limit) == pytest.approx(wanted)
        wanted = min(0.8, _nearest((upright, level), x, y))
        far, px, py = plan.nearest(x, y, 0.8)
        assert far == pytest.approx(wanted)
        if far < 0.8:
            assert math.hypot(px - x, py - y) == pytest.approx(far)


def test_rectangles_that_touch_have_no_wall_between_them() -> None:
    upright, level = outlines([(0, 0, 2, 2), (2, 0.5, 2.2, 1.5), (2.2, 0, 4, 2)])
    assert (2, 0.5, 1.5) not in upright
    assert sorted(line for line in upright if line[0] == 2) == [
        (2, 0, 0.5),
        (2, 1.5, 2),
    ]
    assert (0.5, 2, 2.2) in level


def test_a_door_that_closes_stops_a_ray() -> None:
    map = named_map("default")
    plan = floor_plans(map)[1]
    gap = next(gap for gap in openings(map) if gap.doorway.name == "lab-door")
    assert plan.cast(5.0, 16.0, 0.0, -1.0, 4.0) == pytest.approx(3.0)
    plan.close([door_box(gap)])
    assert plan.cast(5.0, 16.0, 0.0, -1.0, 4.0) == pytest.approx(0.9)
    plan.close([])
    assert plan.cast(5.0, 16.0, 0.0, -1.0, 4.0) == pytest.approx(3.0)
