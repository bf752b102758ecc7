"""The building as data: what a map may say, and what the default map has."""

from __future__ import annotations

import math

import pytest

from bench.corridors import corridors, toml_text
from rapc.worlds.hallway.facts import relation
from rapc.worlds.hallway.map import Map, signs
from rapc.worlds.hallway.map_checks import check_map
from rapc.worlds.hallway.map_text import named_map, read_map
from rapc.worlds.hallway.random_map import random_map
from rapc.worlds.maps import MapError
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
        ('start = "clock"', "", "^`start`: missing$"),
        ('kind = "hall"', 'kind = "attic"', "`kind` of the space `hall`: invalid enum"),
        (
            'kind = "hall"',
            'colour = "red"',
            "^`colour` of the space `hall`: unknown key$",
        ),
        ('name = "hall"\n', "", "^`name` of space 2: missing$"),
        ('name = "hall"', 'name = "A hall"', "`name` of the space `A hall`: expected"),
        ("at = 2.5", "at = nan", "`at` of the doorway `door`: expected"),
        ("tags = [2, 3]", "tags = [-2, 3]", "`tags` of the doorway `door`: expected"),
        ("at = 2.5", "width = 0", "`width` of the doorway `door`: expected .* >= 0.7"),
        ("at = 2.0", "apart = -1", "`apart` of the landmark `clock`: expected"),
        ("[[doorway]]", "[[person]]\nspeed = -1\n[[doorway]]", "`speed` of person 1"),
        (
            'kind = "hall"',
            'kind = "lift"\nfloors = [1, 1]',
            "`floors` of the space `hall`: dupl",
        ),
        (
            '"hall"]',
            '"cellar"]',
            "`joins` of the doorway `door`: unknown space `cellar`",
        ),
        ('space = "lab"', 'space = "loft"', "`space` of the landmark `clock`: unknown"),
        (
            'start = "clock"',
            'start = "door"',
            "`start`: expected a landmark, not `door`",
        ),
        ("at = 2.5", "at = 4.8", "`at` of the doorway `door`: not in a wall of 0.1"),
        (
            "box = [6.2,",
            "box = [7,",
            "`at` of the doorway `door`: not in a wall of 0.1",
        ),
        (
            "box = [6.2,",
            "box = [5,",
            "`box` of the space `hall`: overlaps the space `lab`",
        ),
        (
            "box = [0, 0, 6, 5]",
            "box = [6, 0, 6, 5]",
            "`box` of the space `lab`: no area",
        ),
        ("at = 2.0", "at = 4.8", "`at` of the landmark `clock`: a tag is beyond"),
        (
            '"west"',
            '"east"',
            "`at` of the landmark `clock`: overlaps the doorway `door`",
        ),
        (
            "[[doorway]]",
            "[[obstacle]]\nbox = [3, 3, 3, 4]\n[[doorway]]",
            "`box` of obstacle 1: no area",
        ),
        (
            "[[doorway]]",
            "[[obstacle]]\nfloor = 2\nbox = [3, 3, 4, 4]\n[[doorway]]",
            "`box` of obstacle 1: in no space of floor 2",
        ),
        (
            "tags = [2, 3]",
            "tags = [2, 1]",
            "`tags` of the doorway `door`: expected an even",
        ),
        (
            "tags = [2, 3]",
            "tags = [3, 4]",
            r"an even code and the next one, not `\[3, 4\]`",
        ),
        (
            "tags = [2, 3]",
            "tags = [0, 1]",
            "`tags` of the landmark `clock`: the doorway `door` has the same tags",
        ),
        (
            "at = 2.5",
            "at = 2.5\nwidth = 1.4",
            "`width` of the doorway `door`: .* <= 1.3",
        ),
        (
            "at = 2.5",
            "at = 2.5\napart = 0.9",
            "`apart` of the doorway `door`: expected at least its width 1.0, not `0.9`",
        ),
        (
            "tags = [0, 1]",
            'tags = [0, 1]\n[[landmark]]\nname = "chart"\nspace = "lab"\n'
            'wall = "west"\nat = 2.9\ntags = [4, 5]',
            "`at` of the landmark `chart`: overlaps the landmark `clock` on .* `lab`",
        ),
        (
            '"west"\nat = 2.0',
            '"east"\nat = 3.5',
            "`at` of the landmark `clock`: overlaps the doorway `door` on .* `lab`",
        ),
        (
            "at = 2.0",
            "apart = 0.4\nat = 0.3",
            "`at` of the landmark `clock`: less than 0.4 m from a corner of the space",
        ),
        (
            "[6.2, 0, 8.2, 12]",
            "[6.2, 0, 7.5, 12]",
            "`box` of the space `hall`: less than 1.4 m before the doorway `door`",
        ),
        (
            "[[doorway]]",
            '[[space]]\nname = "attic"\nbox = [20, 0, 30, 9]\n[[doorway]]',
            "the space `attic`: no doorways lead there from `start`",
        ),
        (
            'name = "door"',
            'name = "clock"',
            "`name` of the landmark `clock`: duplicate",
        ),
        ('name = "hall"', 'name = "lab"', "`name` of the space `lab`: duplicate"),
        (
            'kind = "hall"',
            "floors = [1, 2]",
            "`floors` of the space `hall`: only a lift",
        ),
        (
            'kind = "hall"',
            "floors = [2]",
            "`joins` of the doorway `door`: .* no single floor",
        ),
        (
            "[[doorway]]",
            "[[person]]\nspace = 'sky'\n[[doorway]]",
            "`space` of person 1: unknown",
        ),
        (
            "[[doorway]]",
            "[[obstacle]]\nbox = [0.5, 1.5, 1, 2]\n[[doorway]]",
            "`box` of obstacle 1: less than 0.4 m from `clock` in `lab`",
        ),
        (
            "[[doorway]]",
            "[[person]]\nspace='lab'\n[[obstacle]]\nbox=[2, 2, 3, 3]\n[[doorway]]",
            "`box` of obstacle 1: less than 0.4 m from somebody in `lab`",
        ),
    ],
)
def test_map_is_refused_with_its_key_and_fault(old: str, new: str, fault: str) -> None:
    assert old in SMALL
    read_map(SMALL)
    with pytest.raises(MapError, match=fault) as raised:
        read_map(SMALL.replace(old, new, 1))
    assert "\n" not in str(raised.value)


def test_map_without_spaces_is_refused() -> None:
    with pytest.raises(MapError, match=r"^`space`: missing$"):
        read_map('start = "clock"')
    with pytest.raises(MapError, match=r"^`space`: expected .* length >= 1$"):
        read_map('start = "clock"\nspace = []\ndoorway = []')


def test_maps_made_at_random_pass_the_checks() -> None:
    for seed in range(100):
        check_map(random_map(seed))


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


@pytest.mark.parametrize("seed", [3, 50, 106, 187])
def test_relations_tell_how_landmarks_are_turned(seed: int) -> None:
    """Opposite doorways of a hall can have one place before them, as in 50 and 106."""
    hung = signs(random_map(seed))
    pairs = [
        (one, other)
        for one in hung
        for other in hung
        if one is not other and (one.space, one.floor) == (other.space, other.floor)
    ]
    for one, other in pairs:
        turned = relation(one, other)[0] - relation(other, one)[0] + math.pi
        off = math.remainder(turned - (other.normal - one.normal), math.tau)
        assert abs(off) <= 0.11
