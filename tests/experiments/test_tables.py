"""Averages, tables and plots in text, from measures made up for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
import pytest

from rapc.console.experiments import plots
from rapc.console.experiments.output import part_as_text
from rapc.console.experiments.tables import Grid, grid, markdown, remarks, rest, tasks
from rapc.experiments.definition import PlotMark, Reference, Series
from rapc.experiments.measures import Measures, TaskTold
from rapc.experiments.summary import PartSummary, summarize

from .small_experiment import session

PART = Series(
    "drops",
    title="Drops",
    vary="truck.arm1-drops",
    values=(0, 40),
    notes=("A note.",),
    mark=PlotMark(15, "usual"),
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


def summary(*found: Sequence[Measures], part: Series = PART) -> PartSummary:
    """A summary of runs for the points of a part."""
    points = session().points[: len(found)]
    by_hash: Mapping[str, Mapping[int, Measures]] = {
        point.digest: dict(enumerate(runs))
        for point, runs in zip(points, found, strict=True)
    }
    return summarize(part, "%", points, by_hash.__getitem__, 4)


STILL = [measures(300), measures(500), measures(600, 1), measures(90, 0, "no fuel")]
DONE = TaskTold("(go a)", 10, 50, "succeeded")
WILD = [msgspec.structs.replace(measures(100, 0), reason="until")]


@pytest.fixture
def drops() -> PartSummary:
    return summary(STILL, WILD)


def test_disasters_are_counted_and_left_out(drops: PartSummary) -> None:
    still, wild = drops.rows
    assert (still.runs, still.wanted, still.lost) == (4, 4, 1)
    assert still.disasters == {"no fuel": (3,)}
    assert still.figures["time"].mean == pytest.approx(1400 / 3)
    each = still.figures["time-each"]
    assert (each.low, each.high) == (150, 600)
    assert each.mean == 1400 / 5
    assert (each.tenth, each.ninetieth) == pytest.approx((170, 530))
    assert each.deviation == pytest.approx(236.29, abs=0.01)
    assert still.figures["given-up"].mean == pytest.approx(1 / 3)
    assert still.figures["percent-sensor"].mean == 25
    assert still.figures["percent-failed"].mean == 5
    assert still.figures["moves"].mean == 3
    assert (wild.runs, wild.lost, wild.figures["time"].mean) == (1, 0, 100)
    assert "time-each" not in wild.figures
    assert not drops.complete
    assert summary(STILL).complete


def told(made: Grid) -> list[dict[str, str]]:
    """The rows of a table by the heads of its columns."""
    return [dict(zip(made.head, cells, strict=True)) for cells in made.rows]


def test_figures_from_elsewhere_stand_behind_ours(drops: PartSummary) -> None:
    still, wild = told(grid(drops))
    assert (still["arm1-drops"], still["runs"], still["disasters"]) == ("0", "4", "1")
    assert still["time each"] == "280 ± 236 / 441"
    assert still["completed"] == "1.7 ± 0.6 / 9 !"
    assert still["moves"] == "3.0"
    assert (wild["runs"], wild["time each"], wild["effector"]) == ("1/4", "-", "30")
    more, none = told(rest(drops))
    assert (more["from-to"], none["from-to"]) == ("150-600", "-")
    assert (more["time"], none["time"]) == ("467 / 3966", "100")
    assert "missed deadlines" not in more
    assert list(remarks(drops)) == [
        "Ours with the standard deviation, T behind the stroke; ! where that lies more "
        "than two deviations from our mean.",
        "Not ended well at 0: no fuel (seed 3).",
        "Not ended well at 40: stopped at the time `until` (seed 0).",
        "A note.",
    ]


def test_errors_are_counted_and_reported() -> None:
    failed = TaskTold("(go b)", 5, 90, "failed", "interference: preconditions of `go`")
    one = msgspec.structs.replace(
        measures(300), missed_deadlines=2, query_faults=1, tasks=(DONE, failed)
    )
    two = msgspec.structs.replace(measures(300), tasks=(DONE, failed))
    made = summary([one, two])
    [row] = told(rest(made))
    assert (row["missed deadlines"], row["query faults"]) == ("1.0", "0.5")
    assert row["task time"] == "40"
    why = "Given up at 0: 2 by interference: preconditions of `go`."
    assert why in list(remarks(made))
    first, second = told(tasks(made.rows[0]))
    assert (first["task"], first["completed"], first["at"]) == ("(go a)", "2", "50 ± 0")
    assert (second["came"], second["at"], second["given up"]) == ("5", "-", "2")


def test_only_the_most_frequent_reasons_are_told() -> None:
    runs = [
        msgspec.structs.replace(
            measures(300), tasks=(TaskTold("(go a)", 0, 9, "failed", f"reason {n}"),)
        )
        for n in (1, 1, 2, 3, 4)
    ]
    [said] = [line for line in remarks(summary(runs)) if line.startswith("Given up")]
    assert said == (
        "Given up at 0: 2 by reason 1; 1 by reason 2; 1 by reason 3; 1 more."
    )


def test_few_of_many_equal_seeds_are_named() -> None:
    _, said, *_ = remarks(summary([measures(90, 0, "no fuel")] * 8))
    assert said == "Not ended well at 0: no fuel (seeds 0, 1, 2, 3, 4 and 3 more)."


@pytest.mark.parametrize("width", [120, 80, 40, 32])
def test_nothing_is_wider_than_the_terminal(drops: PartSummary, width: int) -> None:
    lines = list(part_as_text(drops, width))
    assert max(len(line.text) for line in lines) <= width
    words = {word for line in lines for word in line.text.split()}
    assert {"arm1-drops", "moves", "280", "441"} <= words


def test_a_plot_in_text() -> None:
    made = summary(STILL, [measures(400), measures(800)])
    head, still, wild = [line.text for line in part_as_text(made, 50)][-3:]
    assert head == "time each: |---| range, o average, x T"
    assert still == " 0           |-------o---------x---------|    280"
    assert wild == "40              |-----o------|                300"


def test_an_average_beyond_the_range_of_the_runs_stands_in_the_plot() -> None:
    """Runs that complete nothing take time, and have no time for each task."""
    runs = [measures(3000, 1), *[measures(3000, 0)] * 3]
    lost = [line.text for line in part_as_text(summary(runs, STILL), 60)][-2]
    assert lost.endswith("o  12000")
    assert lost.index("|") < lost.index("o")


def test_nothing_to_plot_is_no_plot() -> None:
    made = summary(WILD, part=Series("drops", vary="truck.arm1-drops", values=(0,)))
    assert not any(line.text.startswith("time each") for line in part_as_text(made, 80))


def test_a_table_as_markdown(drops: PartSummary) -> None:
    head, rule, still, _ = markdown(grid(drops))
    assert head.startswith("| arm1-drops | runs | disasters | time each | completed |")
    assert rule == "| --- |" + " ---: |" * (head.count("|") - 2)
    assert still.startswith(
        "| 0 | 4 | 1 | 280 ± 236 / 441 | 1.7 ± 0.6 / 9 ! | 30 ± 0 |"
    )


def test_plots_are_the_same_bytes_each_time(drops: PartSummary, tmp_path: Path) -> None:
    other = summary(STILL, WILD, part=Series("more", vary="truck.fuel", values=(0, 1)))
    drawn = []
    for name in ("one", "two"):
        files = plots.draw_plot([drops, other], tmp_path / name)
        assert [file.suffix for file in files] == [".svg", ".png"]
        drawn.append([file.read_bytes() for file in files])
    assert drawn[0] == drawn[1]
    svg = drawn[0][0].decode()
    assert all(word in svg for word in ("<svg", "arm1-drops (%)", "drops: T"))
    assert "dc:date" not in svg


def test_bounds_told_in_words_are_drawn_as_bars(tmp_path: Path) -> None:
    reference = msgspec.structs.replace(
        Reference("T", {}, (0,)), bounds={"completed": ((0, 1.0, 2.0),)}
    )
    part = msgspec.structs.replace(PART, reference=reference)
    svg, _ = plots.draw_plot([summary(STILL, WILD, part=part)], tmp_path / "bounds")
    assert "T, as told" in svg.read_text()


def test_lower_bound_is_drawn_without_comparison(tmp_path: Path) -> None:
    figures = {"completed": (9, 9), "time": (10, 10)}
    least = Reference("least", figures, (0, 40), least=True)
    drawn = summary(STILL, WILD, part=msgspec.structs.replace(PART, reference=least))
    svg, _ = plots.draw_plot([drawn], tmp_path / "least")
    assert "drops: least<" in svg.read_text().replace(" --", "<")
    assert "stroke-dasharray" in svg.read_text()
    told = [cell for row in grid(drawn).rows for cell in row]
    assert any(" / 9" in cell for cell in told)
    assert not any("!" in cell for cell in told)
    assert [line for line in remarks(drawn) if "!" in line] == []


def test_a_plot_of_nothing_with_an_odd_title(tmp_path: Path) -> None:
    part = msgspec.structs.replace(PART, title="$\\nothing_ \n " + "\u4eba" * 200)
    svg, png = plots.draw_plot([summary([], [], part=part)], tmp_path / "nothing")
    assert svg.read_text().startswith("<?xml")
    assert png.read_bytes().startswith(b"\x89PNG")


def _of_skills(name: str, folder: Path) -> str:
    """Draw runs without primitives, with what is counted or without; return the SVG."""
    made = msgspec.structs.replace
    runs = [made(one, effector=0, sensor=0, failed=0) for one in STILL]
    drawn = summary(runs, runs)
    if name == "nothing":
        drawn = made(drawn, told=(), counted=())
    svg, _ = plots.draw_plot([drawn], folder / name)
    return svg.read_text()


def test_counts_are_drawn_in_a_world_of_skills(tmp_path: Path) -> None:
    text = _of_skills("counted", tmp_path)
    assert "<!-- times that it happened -->" in text
    assert "<!-- drops: moves -->" in text
    assert "<!-- actions -->" not in text


def test_empty_panel_is_omitted(tmp_path: Path) -> None:
    text = _of_skills("nothing", tmp_path)
    assert "axes_2" in text
    assert "axes_3" not in text


def test_figures_of_the_world_have_a_panel_each(tmp_path: Path) -> None:
    """A count and two figures of the world are drawn below the actions."""
    made = msgspec.structs.replace
    runs = [
        made(one, figures={"right": n, "hood-open": 10 * n})
        for n, one in enumerate(STILL)
    ]
    drawn = made(summary(runs, runs), told=("moves", "right", "hood-open"))
    svg, _ = plots.draw_plot([drawn], tmp_path / "figures")
    text = svg.read_text()
    for name in ("actions", "times that it happened", "right", "hood-open"):
        assert f"<!-- {name} -->" in text
    assert "axes_6" in text
    assert "axes_7" not in text


def test_non_numeric_values_are_drawn_side_by_side(tmp_path: Path) -> None:
    part = Series("way", vary="truck.lasting-names", values=(False, True))
    points = session().points[:2]
    named = [point.__replace__(value=bool(n)) for n, point in enumerate(points)]
    found = {point.digest: dict(enumerate(STILL)) for point in named}
    made = summarize(part, "", named, found.__getitem__, 4)
    svg, _ = plots.draw_plot([made], tmp_path / "way")
    text = svg.read_text()
    assert "<!-- false -->" in text
    assert "<!-- true -->" in text
