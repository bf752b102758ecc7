"""The building as data: what a map may say, and what the default map has."""

from __future__ import annotations

import math

import pytest

from bench.corridors import corridors, toml_text
from rapc.worlds.hallway.map import Map, MapError, signs
from rapc.worlds.hallway.map_text import named_map, read_map
from rapc.worlds.hallway.random_map import random_map
from tests.hallway.journey import route

SMALL = """
start = "clock"
[[space]]
name = "lab"
box = [0, 0, 6, 5]
[[space]]
name = "hall"
box = [6.2, 0, 8.2, 12]
kind = "hall"
[[doorway]]
name = "door"
joins = ["lab", "hall"]
at = 2.5
tags = [2, 3]
[[landmark]]
name = "clock"
space = "lab"
wall = "west"
at = 2.0
tags = [0, 1]
"""


def _reachable(map: Map) -> bool:
    start = map.space[0].name
    return all(route(map, start, s.name, set()) is not None for s in map.space)


def test_the_default_map_is_a_ring_with_branches_and_a_second_floor() -> None:
    map = named_map("default")
    assert len(map.space) >= 12
    assert _reachable(map)
    floors = {floor for space in map.space for floor in space.floors}
    assert floors == {1, 2}
    halls = ["north-hall", "east-hall", "south-hall", "west-hall"]
    for doorway in map.doorway:
        one, other = doorway.joins
        if {one, other} <= set(halls):
            others = {d.name for d in map.doorway} - {doorway.name}
            assert route(map, one, other, {doorway.name}) is not None, others
    assert sum(doorway.door for doorway in map.doorway) >= 5
    assert map.person
    assert map.obstacle
    assert any(mark.charger for mark in map.landmark)


def test_a_doorway_is_a_landmark_on_both_sides() -> None:
    door = {s.space: s for s in signs(read_map(SMALL)) if s.landmark == "door"}
    assert (door["lab"].x, door["lab"].y) == (6, 2.5)
    assert (door["hall"].x, door["hall"].y) == (6.2, 2.5)
    assert math.cos(door["lab"].normal) == pytest.approx(-1)
    assert math.cos(door["hall"].normal) == pytest.approx(1)


def test_the_left_tag_is_to_the_left_of_who_faces_it() -> None:
    clock = next(s for s in signs(read_map(SMALL)) if s.landmark == "clock")
    (left, right), (x, y) = clock.tag_points(), clock.front(1.0)
    assert (x, y) == pytest.approx((1.0, 2.0))
    bearings = [math.atan2(ty - y, tx - x) for tx, ty in (left, right)]
    turn = math.remainder(bearings[0] - bearings[1], math.tau)
    assert turn == pytest.approx(2 * math.atan(0.5))


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("[[space]]", "[[", "no TOML: .* line 3"),
        ("[0, 0, 6, 5]", "[" * 100_000, "no TOML: "),
        ('start = "clock"', "", "missing required field `start`"),
        ('kind = "hall"', 'kind = "attic"', "`kind` of the space `hall`: invalid enum"),
        ('kind = "hall"', 'colour = "red"', "the space `hall`: .*unknown field `colo"),
        ('name = "hall"\n', "", "^space 2: object missing required field `name`"),
        ('name = "hall"', 'name = "A hall"', "`name` of the space `A hall`: expected"),
        ("at = 2.5", "at = nan", "`at` of the doorway `door`: expected"),
        ("tags = [2, 3]", "tags = [-2, 3]", "`tags` of the doorway `door`: expected"),
        ("at = 2.5", "width = 0", "`width` of the doorway `door`: expected .* >= 0.7"),
        ("at = 2.0", "apart = -1", "`apart` of the landmark `clock`: expected"),
        ("[[doorway]]", "[[person]]\nspeed = -1\n[[doorway]]", "`speed` of person 1"),
        ('kind = "hall"', 'kind = "lift"\nfloors = [1, 1]', "twice on one floor"),
        ('"hall"]', '"cellar"]', "`door` names the space `cellar`"),
        ('space = "lab"', 'space = "loft"', "`clock` names the space `loft`"),
        ('start = "clock"', 'start = "door"', "`start` is no landmark on a wall"),
        ("at = 2.5", "at = 4.8", "`door` does not lie in a wall between"),
        ("box = [6.2,", "box = [7,", "`door` does not lie in a wall between"),
        ("box = [6.2,", "box = [5,", "`lab` and `hall` overlap"),
        ("box = [0, 0, 6, 5]", "box = [6, 0, 6, 5]", "`lab` has no area"),
        ("at = 2.0", "at = 4.8", "`clock` does not hang on the west wall of `lab`"),
        ('"west"', '"east"', "`clock` hangs in the doorway `door`"),
        (
            "[[doorway]]",
            "[[obstacle]]\nbox = [3, 3, 3, 4]\n[[doorway]]",
            "the obstacle .* has no area",
        ),
        (
            "[[doorway]]",
            "[[obstacle]]\nfloor = 2\nbox = [3, 3, 4, 4]\n[[doorway]]",
            "is in no space of floor 2",
        ),
        ("tags = [2, 3]", "tags = [2, 1]", "tag 1 is used twice"),
        ('name = "door"', 'name = "clock"', "two landmarks are named `clock`"),
        ('name = "hall"', 'name = "lab"', "two spaces are named `lab`"),
        ('kind = "hall"', "floors = [1, 2]", "on several floors and is no lift"),
        ('kind = "hall"', "floors = [2]", "share no single floor"),
        ("[[doorway]]", "[[person]]\nspace = 'sky'\n[[doorway]]", "a person names"),
        (
            "[[doorway]]",
            "[[obstacle]]\nbox = [0.5, 1.5, 1, 2]\n[[doorway]]",
            "too near to `clock` in `lab`",
        ),
        (
            "[[doorway]]",
            "[[person]]\nspace='lab'\n[[obstacle]]\nbox=[2, 2, 3, 3]\n[[doorway]]",
            "too near to somebody in `lab`",
        ),
    ],
)
def test_a_map_that_contradicts_itself_is_refused(
    old: str, new: str, fault: str
) -> None:
    assert old in SMALL
    read_map(SMALL)
    with pytest.raises(MapError, match=fault):
        read_map(SMALL.replace(old, new, 1))


def test_a_map_made_at_random_is_one_building_and_the_same_for_a_seed() -> None:
    made = [random_map(seed) for seed in range(40)]
    assert all(_reachable(map) for map in made)
    assert all(len(signs(map)) > 15 for map in made)
    assert len({len(map.doorway) for map in made}) > 3
    assert random_map(7) == made[7]


def test_corridors_of_the_bench_are_maps_of_the_world() -> None:
    made = [corridors(seed) for seed in range(40)]
    assert [read_map(toml_text(map)) for map in made] == made
    assert all(_reachable(map) for map in made)
    assert max(doorway.width for map in made for doorway in map.doorway) <= 0.9
    assert min(map.space[0].box[2] for map in made) >= 24
