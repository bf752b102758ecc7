"""Averages, tables and plots in text, from measures made up for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
import pytest

from rapc.console.experiments import plots
from rapc.console.experiments.output import as_text
from rapc.console.experiments.tables import grid, markdown, remarks
from rapc.experiments.definition import Mark, Part, Reference
from rapc.experiments.measures import Measures
from rapc.experiments.summary import Summary, summarize

from .small_experiment import session

PART = Part(
    "drops",
    title="Drops",
    vary="truck.arm1-drops",
    values=(0, 40),
    notes=("A note.",),
    mark=Mark(15, "usual"),
    reference=Reference("T", {"completed": (9,), "time": (3966,)}, (0,)),
)


def measures(time: float, completed: int = 2, disaster: str | None = None) -> Measures:
    """A run of 30 effector and 10 sensor primitives, of which 2 failed."""
    return Measures(
        reason="world" if disaster else "done",
        disaster=disaster,
        time=time,
        completed=completed,
        given_up=2 - completed,
        pending=0,
        effector=30,
        sensor=10,
        failed=2,
        counts={"moves": 3},
    )


def summary(*found: Sequence[Measures], part: Part = PART) -> Summary:
    """A summary of runs for the points of a part."""
    points = session().points[: len(found)]
    by_hash: Mapping[str, Mapping[int, Measures]] = {
        point.digest: dict(enumerate(runs))
        for point, runs in zip(points, found, strict=True)
    }
    return summarize(part, "%", points, by_hash.__getitem__, 4)


STILL = [measures(300), measures(500), measures(600, 1), measures(90, 0, "no fuel")]
WILD = [msgspec.structs.replace(measures(100, 0), reason="until")]


@pytest.fixture
def drops() -> Summary:
    return summary(STILL, WILD)


def test_disasters_are_counted_and_left_out(drops: Summary) -> None:
    still, wild = drops.rows
    assert (still.runs, still.wanted, still.lost) == (4, 4, 1)
    assert still.disasters == {"no fuel": (3,)}
    assert still.figures["time"].mean == pytest.approx(1400 / 3)
    each = still.figures["time-each"]
    assert (each.low, each.high) == (150, 600)
    assert each.mean == pytest.approx(1000 / 3)
    assert still.figures["given-up"].mean == pytest.approx(1 / 3)
    assert still.figures["percent-sensor"].mean == 25
    assert still.figures["percent-failed"].mean == 5
    assert still.figures["moves"].mean == 3
    assert (wild.runs, wild.lost, wild.figures["time"].mean) == (1, 0, 100)
    assert "time-each" not in wild.figures
    assert not drops.complete
    assert summary(STILL).complete


def test_figures_from_elsewhere_stand_below_ours(drops: Summary) -> None:
    head, *rows = grid(drops).head, *grid(drops).rows
    told = [dict(zip(head, cells, strict=True)) for _, cells in rows]
    assert [kind for kind, _ in rows] == ["ours", "theirs", "ours"]
    ours, theirs, wild = told
    assert (ours["arm1-drops"], theirs["arm1-drops"]) == ("0", "T")
    assert (ours["time each"], theirs["time each"]) == ("333", "441")
    assert (ours["from-to"], theirs["from-to"]) == ("150-600", "")
    assert (wild["runs"], wild["time each"], wild["from-to"]) == ("1/4", "-", "-")
    assert list(remarks(drops)) == [
        "Not ended well at 0: no fuel (seed 3).",
        "Not ended well at 40: stopped at the time `until` (seed 0).",
        "A note.",
    ]


def test_only_some_of_many_seeds_that_ended_alike_are_named() -> None:
    told = next(remarks(summary([measures(90, 0, "no fuel")] * 8)))
    assert told == "Not ended well at 0: no fuel (seeds 0, 1, 2, 3, 4 and 3 more)."


@pytest.mark.parametrize("width", [120, 80, 40, 24])
def test_nothing_is_wider_than_the_terminal(drops: Summary, width: int) -> None:
    lines = list(as_text(drops, width))
    assert max(len(line.text) for line in lines) <= width
    words = {word for line in lines for word in line.text.split()}
    assert {"arm1-drops", "moves", "3966", "150-600"} <= words


def test_a_plot_in_text() -> None:
    made = summary(STILL, [measures(400), measures(800)])
    head, still, wild = [line.text for line in as_text(made, 50)][-3:]
    assert head == "time each: |---| range, o average, x T"
    assert still == " 0           |-----------o-----x---------|    333"
    assert wild == "40              |-----o------|                300"


def test_nothing_to_plot_is_no_plot() -> None:
    made = summary(WILD, part=Part("drops", vary="truck.arm1-drops", values=(0,)))
    assert not any(line.text.startswith("time each") for line in as_text(made, 80))


def test_a_table_as_markdown(drops: Summary) -> None:
    head, rule, ours, theirs, _ = markdown(grid(drops))
    assert head.startswith("| arm1-drops | runs | disasters | completed |")
    assert rule == "| --- |" + " ---: |" * (head.count("|") - 2)
    assert ours.startswith("| 0 | 4 | 1 | 1.7 | 0.3 | 0.0 | 467 | 333 | 150-600 |")
    assert theirs.startswith("| *T* |  |  | *9* | *-* | *-* | *3966* | *441* |  |")


def test_plots_are_the_same_bytes_each_time(drops: Summary, tmp_path: Path) -> None:
    other = summary(STILL, WILD, part=Part("more", vary="truck.fuel", values=(0, 1)))
    drawn = []
    for name in ("one", "two"):
        files = plots.draw([drops, other], tmp_path / name)
        assert [file.suffix for file in files] == [".svg", ".png"]
        drawn.append([file.read_bytes() for file in files])
    assert drawn[0] == drawn[1]
    svg = drawn[0][0].decode()
    assert all(word in svg for word in ("<svg", "arm1-drops (%)", "drops: T"))
    assert "dc:date" not in svg


def test_a_plot_of_nothing_with_an_odd_title(tmp_path: Path) -> None:
    part = msgspec.structs.replace(PART, title="$\\nothing_ \n " + "\u4eba" * 200)
    svg, png = plots.draw([summary([], [], part=part)], tmp_path / "nothing")
    assert svg.read_text().startswith("<?xml")
    assert png.read_bytes().startswith(b"\x89PNG")


def test_values_that_are_no_numbers_stand_side_by_side(tmp_path: Path) -> None:
    part = Part("way", vary="truck.lasting-names", values=(False, True))
    points = session().points[:2]
    named = [point.__replace__(value=bool(n)) for n, point in enumerate(points)]
    found = {point.digest: dict(enumerate(STILL)) for point in named}
    made = summarize(part, "", named, found.__getitem__, 4)
    svg, _ = plots.draw([made], tmp_path / "way")
    text = svg.read_text()
    assert "<!-- false -->" in text
    assert "<!-- true -->" in text
