"""Plans in frames: truth to scale, and what is believed laid over it."""

from __future__ import annotations

import math
import re

import msgspec
import pytest

from rapc.console.show.canvas import Dots
from rapc.console.show.frame import Activity, draw_frame
from rapc.console.show.plan import Drawing, believed_pose, draw_plan, legend
from rapc.library.loader import load_text
from rapc.world import Area, Door, Gauge, Mark, Picture, Plan, Reckoning, Spot, Stand
from tests.memory.bench import MemoryBench

WORDS = """
(declare-memory-proposition place (?x ?y ?heading))
(declare-memory-proposition counted (?mark ?x ?y ?heading))
(declare-memory-property room (?who ?room) unknown)
(declare-memory-proposition known (?mark))
(declare-memory-proposition shut (?door))
"""

FLAT = Plan(
    (Area("hall", (0, 0, 20, 4)), Area("passage", (16, 4, 20, 16))),
    (
        ((0, 0), (20, 0)),
        ((20, 0), (20, 16)),
        ((20, 16), (16, 16)),
        ((16, 16), (16, 4)),
        ((16, 4), (0, 4)),
        ((0, 4), (0, 0)),
    ),
    blocks=((8, 0, 9, 1),),
    doors=(Door("gate", (18, 4), True, ("shut", "gate"), 60),),
    marks=(Mark("clock", (0, 2), ("known", "clock")), Mark("desk", (18, 16))),
    others=((18, 6),),
    robot=(2, 2, math.pi / 2),
    echoes=((2, 4), (6, 2)),
    reckoning=Reckoning(
        ("place",),
        ("counted",),
        ("room", "robot"),
        (Stand("clock", "hall", (1, 2, math.pi)),),
    ),
)
PICTURE = Picture(
    "hall",
    (Spot("hall", at=(0, 1)), Spot("passage", at=(1, 0))),
    gauges=(Gauge("in", "hall", ("room", "robot")),),
    plan=FLAT,
)


@pytest.fixture
def memory() -> MemoryBench:
    """The words of a flat, with nothing believed."""
    loaded = load_text(WORDS)
    assert loaded.diagnostics == ()
    return MemoryBench(loaded.library)


def _drawn(memory: MemoryBench, width: int = 44, height: int = 18) -> list[str]:
    return [row.plain for row in _drawing(FLAT, memory, width, height).rows]


def _drawing(plan: Plan, memory: MemoryBench, width: int, height: int) -> Drawing:
    drawn = draw_plan(plan, memory.memory, width, height)
    assert drawn is not None
    return drawn


def test_what_is_true_is_drawn_to_scale(memory: MemoryBench) -> None:
    rows = _drawn(memory)
    assert all(len(row) <= 44 for row in rows)
    text = "\n".join(rows)
    assert [text.count(sign) for sign in "↑o■□x⇒◆"] == [1, 1, 1, 1, 1, 0, 0]
    assert "hall" in text
    [(column, row)] = [(r.index("↑"), n) for n, r in enumerate(rows) if "↑" in r]
    assert column == pytest.approx(2 / 20 * 44, abs=1)
    assert row == pytest.approx(14 / 16 * len(rows), abs=1)
    [at] = [r.index("o") for r in rows if "o" in r]
    assert at == pytest.approx(18 / 20 * 44, abs=1)


def test_a_narrow_space_has_its_name_downwards(memory: MemoryBench) -> None:
    rows = _drawn(memory, 24, 18)
    columns = ["".join(row[at : at + 1] for row in rows) for at in range(24)]
    assert any(re.search("pass", column) for column in columns)


@pytest.mark.parametrize("x", [8.0, 9.5, 10.0, 10.5, 11.0, 12.0])
def test_name_of_a_space_is_beside_a_person_in_its_middle(
    memory: MemoryBench, x: float
) -> None:
    memory.assert_fact("room", "robot", "hall")
    plan = msgspec.structs.replace(FLAT, others=((x, 2), (x, 1)), robot=(x, 3, 0))
    rows = [row.plain for row in _drawing(plan, memory, 44, 18).rows]
    [row] = [row for row in rows if "[hall]" in row]
    assert not re.search(r"o\[|\]o", row)
    assert "".join(rows).count("o") == 2
    assert "".join(rows).count("→") == 1


def test_person_in_a_narrow_space_moves_its_name(memory: MemoryBench) -> None:
    plan = msgspec.structs.replace(FLAT, others=((18, 9), (18, 12)))
    rows = [row.plain for row in _drawing(plan, memory, 60, 24).rows]
    columns = ["".join(row[at : at + 1] or " " for row in rows) for at in range(60)]
    assert any("passage" in column + row for column in columns for row in rows)


def test_long_name_is_broken_at_its_hyphens(memory: MemoryBench) -> None:
    plan = msgspec.structs.replace(
        FLAT, areas=(Area("stationery-store", (16, 4, 20, 9)),)
    )
    rows = [row.plain for row in _drawing(plan, memory, 60, 24).rows]
    [first] = [n for n, row in enumerate(rows) if "stationery-" in row]
    assert "store" in rows[first + 1]


def test_number_stands_for_the_name_of_a_tiny_space(memory: MemoryBench) -> None:
    plan = msgspec.structs.replace(
        FLAT, areas=(*FLAT.areas, Area("cupboard", (0, 4, 2, 6)))
    )
    drawn = _drawing(plan, memory, 40, 18)
    assert drawn.numbers == [("1", "cupboard")]
    assert "1" in "".join(row.plain for row in drawn.rows)
    picture = msgspec.structs.replace(PICTURE, plan=plan)
    lines = draw_frame(picture, memory.memory, Activity(3), 40, 24)
    assert "1 cupboard" in lines[-1].plain
    assert len(lines) <= 24


def test_what_is_believed_lies_over_it(memory: MemoryBench) -> None:
    memory.assert_fact("room", "robot", "hall")
    memory.assert_fact("known", "clock")
    memory.assert_fact("shut", "gate")
    memory.assert_fact("counted", "clock", 100, 100, 0)
    memory.assert_fact("place", 96, 100, 0)
    text = "\n".join(_drawn(memory))
    assert [text.count(sign) for sign in "◆■□X⇐"] == [1, 1, 0, 1, 1]
    assert "[hall]" in text
    pose = believed_pose(FLAT.reckoning, memory.memory)
    assert pose == pytest.approx((5, 2, math.pi))


def test_a_belief_about_a_door_counts_for_its_time(memory: MemoryBench) -> None:
    memory.assert_fact("shut", "gate")
    assert "X" in "".join(_drawn(memory))
    memory.time = 61
    assert "x" in "".join(_drawn(memory))


@pytest.mark.parametrize("missing", ["room", "counted", "place"])
def test_a_place_that_cannot_be_said_is_not_drawn(
    memory: MemoryBench, missing: str
) -> None:
    facts = {
        "room": ("robot", "hall"),
        "counted": ("clock", 0, 0, 0),
        "place": (0, 0, 0),
    }
    for name, rest in facts.items():
        if name != missing:
            memory.assert_fact(name, *rest)
    assert believed_pose(FLAT.reckoning, memory.memory) is None
    assert "⇐" not in "".join(_drawn(memory))


@pytest.mark.parametrize("width", [40, 120])
def test_where_there_is_no_screen_a_plan_is_as_high_as_wide(
    width: int, memory: MemoryBench
) -> None:
    doings = Activity(3, "[1] (go)", skills=("drive", "look-about"))
    whole = [t.plain for t in draw_frame(PICTURE, memory.memory, doings, width, 0)]
    screen = [t.plain for t in draw_frame(PICTURE, memory.memory, doings, width, 999)]
    assert whole == screen
    assert "skills: drive, look-about" in whole
    assert "[ ] space believed" in whole[-1]


@pytest.mark.parametrize("width", [30, 40, 80, 200])
def test_a_frame_with_a_plan_fits(memory: MemoryBench, width: int) -> None:
    doings = Activity(3, "[1] (go)", skills=("drive", "look-about"))
    lines = [
        line.plain for line in draw_frame(PICTURE, memory.memory, doings, width, 24)
    ]
    assert lines[0].startswith("time 3   in hall ≠ ")
    assert len(lines) <= 24
    assert max(map(len, lines)) <= width
    assert "skills: drive, look-about" in lines
    assert "".join(lines).count("somebody") == 1


def test_where_there_is_no_room_for_a_plan_there_is_a_list(
    memory: MemoryBench,
) -> None:
    lines = draw_frame(PICTURE, memory.memory, Activity(3), 20, 8)
    assert [line.plain for line in lines][1] == "[hall]"


def test_the_legend_breaks_between_entries() -> None:
    whole = [line.plain for line in legend(300)]
    assert len(whole) == 1
    narrow = [line.plain for line in legend(30)]
    assert "   ".join(narrow) == whole[0]


def test_dots_are_in_their_cells_and_nowhere_else() -> None:
    dots = Dots(2, 1)
    dots.line((0, 0), (3, 3), "a")
    dots.dot(4, 0, "b")
    dots.dot(-1, 0, "b")
    assert list(dots.cells()) == [(0, 0, "⠑", "a"), (1, 0, "⢄", "a")]
