"""Frames: what they show of truth and belief, and that they fit on the screen."""

from __future__ import annotations

import random
import re
from collections import Counter
from pathlib import Path

import msgspec
import pytest

import rapc
from rapc.console.show.beliefs import believed_contents, contents_in_words
from rapc.console.show.canvas import folded
from rapc.console.show.frame import Activity, draw_frame
from rapc.library.loader import load_text
from rapc.world import Gauge, Picture, Spot, Thing
from rapc.worlds.truck.map import Map
from rapc.worlds.truck.map_text import read_map
from rapc.worlds.truck.picture import Layout, lay_out
from rapc.worlds.truck.world import TruckWorld
from tests.memory.bench import MemoryBench

EXAMPLE = Path(__file__).parents[2] / "examples" / "rock-order.rap"

WORDS = """
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property color (?item ?color) unknown)
(declare-memory-property class (?item ?class ?value) unknown)
(declare-memory-property fuel (?amount) unknown)
(declare-indistinct-class rock)
(declare-memory-proposition heading (?way))
"""

YARD = Picture(
    "yard",
    (
        Spot("yard", (Thing("rock", "red"), Thing("rock", "red")), (0, 0), "a troll"),
        Spot("pit", (Thing("box"),), (1, 0)),
        Spot("mill", (), (1, 1)),
        Spot("hand", (Thing("rock", "blue"),), note="outside"),
        Spot("bag"),
    ),
    (("yard", "pit"), ("pit", "mill"), ("yard", "mill")),
    "southeast",
    "color",
    (Gauge("fuel", 5, ("fuel",)), Gauge("heading", "southeast", ("heading",))),
)
DOINGS = Activity(
    12.5, "[1] (fetch red)", ("(look yard) - okay", "(grab item-1) - lost")
)


@pytest.fixture
def memory() -> MemoryBench:
    """The words of a yard, with nothing believed."""
    loaded = load_text(WORDS)
    assert loaded.diagnostics == ()
    return MemoryBench(loaded.library)


def _frame(memory: MemoryBench, width: int, height: int) -> list[str]:
    lines = draw_frame(YARD, memory.memory, DOINGS, width, height)
    return [line.plain.rstrip() for line in lines]


def test_nothing_is_believed_at_first(memory: MemoryBench) -> None:
    assert _frame(memory, 64, 15) == [
        "time 12.5   fuel 5 ≠ unknown   heading southeast ≠ unknown",
        "[↘yard] a troll ────────────────pit",
        "  2 red rock                    │ box",
        "  ≠ nothing     ·               │ ≠ nothing",
        "                        ·       │",
        "                                mill",
        "",
        "",
        "",
        "hand (outside): blue rock ≠ no… bag",
        "elsewhere",
        "task: [1] (fetch red)",
        "  (look yard) - okay",
        "  (grab item-1) - lost",
        "= as believed   ≠ what is believed instead",
    ]


def _look_about(memory: MemoryBench) -> None:
    """All in the yard and at hand is known, the pit taken for something else."""
    memory.assert_fact("fuel", 5)
    memory.assert_fact("heading", "north")
    with memory.batch():
        for sensor, color, place in (
            ("s1", "red", "yard"),
            ("s2", "red", "yard"),
            ("s3", "blue", "hand"),
            ("s4", "red", "pit"),
        ):
            name = memory.introduce(sensor, "rock", place)
            memory.assert_fact("color", name, color)
        memory.introduce("box-1", "box", "mill")
        memory.introduce("s5", "rock", "box-1")
        memory.introduce("lost-1", "lamp", "unknown")


def test_truth_and_belief_are_told_apart(memory: MemoryBench) -> None:
    _look_about(memory)
    assert _frame(memory, 64, 15) == [
        "time 12.5   fuel 5   heading southeast ≠ north",
        "[↘yard] a troll ────────────────pit",
        "  2 red rock                    │ box",
        "  =             ·               │ ≠ red rock",
        "                        ·       │",
        "                                mill",
        "                                  nothing",
        "                                  ≠ box, rock",
        "",
        "hand (outside): blue rock =     bag",
        "elsewhere: lamp at unknown",
        "task: [1] (fetch red)",
        "  (look yard) - okay",
        "  (grab item-1) - lost",
        "= as believed   ≠ what is believed instead",
    ]


def test_a_thing_in_a_thing_is_where_that_is(memory: MemoryBench) -> None:
    _look_about(memory)
    found = believed_contents(memory.memory, YARD)
    assert found["mill"] == Counter({("box", ""): 1, ("rock", ""): 1})
    assert "box-1" not in found


def test_what_goes_by_two_descriptions_is_counted_once(memory: MemoryBench) -> None:
    """Two rocks seen, left, and seen again without a closer look: they are two."""
    with memory.batch():
        memory.arrive("yard")
        for sensor, color in (("s1", "red"), ("s2", "blue")):
            memory.assert_fact("color", memory.introduce(sensor, "rock", "yard"), color)
        memory.fix_cardinality("yard")
    memory.expire()
    with memory.batch():
        memory.introduce("s3", "rock", "yard")
    assert len(memory.memory.query("location", None, "yard")) == 3
    found = believed_contents(memory.memory, YARD)
    assert found == {"yard": Counter({("rock", "red"): 1, ("rock", "blue"): 1})}


@pytest.mark.parametrize(
    ("contents", "said"),
    [
        ({}, "nothing"),
        ({("rock", ""): 1}, "rock"),
        ({("rock", "red"): 2, ("rock", "blue"): 1}, "blue+2 red rock"),
        (
            {("rock", "red"): 2, ("rock", ""): 3, ("gun", ""): 1},
            "gun, 3 rock, 2 red rock",
        ),
    ],
)
def test_contents_in_words(contents: dict[tuple[str, str], int], said: str) -> None:
    assert contents_in_words(Counter(contents)) == said


@pytest.mark.parametrize(
    ("width", "lines", "folds"),
    [
        (20, 1, ["gun-tool, blue+2 re…"]),
        (20, 2, ["gun-tool, blue+2 red", "rock"]),
        (10, 2, ["gun-tool,", "blue+2 re…"]),
        (0, 1, []),
    ],
)
def test_what_is_too_long_is_folded_then_cut(
    width: int, lines: int, folds: list[str]
) -> None:
    assert folded("gun-tool, blue+2 red rock", width, lines) == folds


def test_a_small_screen_gets_a_list_with_what_is_wrong_first(
    memory: MemoryBench,
) -> None:
    _look_about(memory)
    assert _frame(memory, 64, 11) == [
        "time 12.5   fuel 5   heading southeast ≠ north",
        "[↘yard] (a troll): 2 red rock =",
        "pit: box ≠ red rock",
        "mill: nothing ≠ box, rock",
        "hand (outside): blue rock =     bag",
        "elsewhere: lamp at unknown",
        "task: [1] (fetch red)",
        "  (look yard) - okay",
        "  (grab item-1) - lost",
        "= as believed   ≠ what is believed instead",
    ]
    assert _frame(memory, 24, 10) == [
        "time 12.5   fuel 5   he…",
        "[↘yard] (a troll): 2 re…",
        "pit: box ≠ red rock",
        "mill: nothing ≠ box, ro…",
        "hand (outs… bag",
        "elsewhere: lamp at unkn…",
        "task: [1] (fetch red)",
        "  (look yard) - okay",
        "  (grab item-1) - lost",
        "= as believed   ≠ what …",
    ]


KINDS = tuple(Thing(f"thing-{number}") for number in range(30))


@pytest.mark.parametrize("width", [24, 60, 120])
def test_where_there_is_no_screen_all_is_shown(width: int, memory: MemoryBench) -> None:
    hand = Spot("hand", (Thing("rock", "blue"),), note="all of it outside")
    full = msgspec.structs.replace(
        YARD, spots=(*YARD.spots[:2], Spot("mill", KINDS, (1, 1)), hand, Spot("bag"))
    )
    frame = draw_frame(full, memory.memory, DOINGS, width, 0)
    told = "\n".join(line.plain for line in frame)
    assert {f"thing-{number}" for number in range(30)} <= {
        *re.findall(r"thing-\d+", told)
    }
    assert "hand (all of it outside): blue rock ≠ nothing" in told
    assert not re.search(r"…|more places", told)
    assert "= as believed   ≠ what is believed instead" in told


def test_a_frame_fits_where_it_is_drawn() -> None:
    world = TruckWorld(random.Random(3), {})
    library = rapc.load(EXAMPLE).program
    run = rapc.Interpreter(library, world, 3)
    run.submit("(rock-order red 2)")
    run.run(until=90)
    for width, height in ((1, 1), (20, 4), (40, 12), (80, 24), (132, 43), (300, 100)):
        frame = draw_frame(world.picture(), run.memory, Activity(), width, height)
        assert 0 < len(frame) <= height
        assert max(line.cell_len for line in frame) <= width


def test_a_picture_changes_nothing() -> None:
    world = TruckWorld(random.Random(3), {})
    before = world.save()
    assert world.picture() == world.picture()
    assert world.save() == before


def test_map_is_laid_out_once_for_all_pictures(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    laid_out = []

    def counted(ground: Map) -> Layout:
        laid_out.append(ground)
        return lay_out(ground)

    monkeypatch.setattr("rapc.worlds.truck.world.lay_out", counted)
    world = TruckWorld(random.Random(3), {})
    assert laid_out == []
    first = world.picture()
    world.perform(1, ("truck-turn", "northeast"))
    assert world.picture().spots == first.spots
    assert len(laid_out) == 1


def test_the_map_lies_as_its_roads_lead() -> None:
    world = TruckWorld(random.Random(3), {})
    at = {s.name: s.at for s in world.picture().spots if s.at is not None}
    assert len(set(at.values())) == len(at) == 14
    assert at["warehouse"] == (1.5, 0)
    assert at["zone-4"] == (2, 2)
    assert at["depot"] == (1.5, 4)


def test_a_map_that_fits_on_no_plane_is_laid_out_all_the_same() -> None:
    ground = read_map(
        """{"start": "a", "places": [{"name": "a", "kind": "zone"},
        {"name": "b", "kind": "zone"}, {"name": "c", "kind": "zone"}],
        "roads": [{"name": "r", "from": "a", "direction": "north", "to": "b",
        "time": 1, "fuel": 1}, {"name": "s", "from": "b", "direction": "north",
        "to": "a", "time": 1, "fuel": 1}]}"""
    )
    assert set(lay_out(ground)) == {"a", "b", "c"}


def test_a_road_is_drawn_where_the_truck_stops_on_it() -> None:
    world = TruckWorld(random.Random(3), {"fuel": 0.1})
    for request in (("truck-turn", "northeast"), ("truck-move",)):
        world.perform(1, request)
    picture = world.picture()
    assert world.ended() == "out of fuel on road-17"
    [spot] = [s for s in picture.spots if s.name == picture.here]
    assert (spot.name, spot.at) == ("road-17", (1.75, 3.5))


def test_night_and_rain_are_told() -> None:
    world = TruckWorld(random.Random(3), {"rain": 100, "day-length": 100})
    world.advance(99)
    notes = {spot.name: spot.note for spot in world.picture().spots}
    assert (notes["zone-4"], notes["arm1"]) == ("dark rain", "folded")
    world.advance(110)
    assert "rain" in {spot.note for spot in world.picture().spots}
