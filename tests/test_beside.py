"""What is made of the results of a run of the peers' script."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from bench.beside import BEGIN, END, PANELS, Results, goals, main, put, tables


def row(workload: str, peer: str, size: int, **figures: Any) -> dict[str, Any]:
    """One result as the script writes it."""
    name = "d" if workload == "W4" else "n"
    return {
        "workload": workload,
        "peer": peer,
        "params": {name: size},
        "figures": figures,
    }


def median(seconds: float) -> dict[str, float]:
    """A figure with samples."""
    return {"median": seconds, "min": seconds / 2, "max": seconds * 2}


ROWS = [
    row("W2", "swipl", 10_000, first_sel=median(8e-7), all_sel=median(4e-6)),
    row("W2", "rapc", 1_000, first_sel=median(7e-7), all_sel=median(2e-6)),
    row("W2", "rapc", 10_000, first_sel=median(8e-7), all_sel=median(7e-6)),
    row("W4", "rapc", 8, task=median(4e-6), tasks_per_s=250_000.0),
    {"workload": "W2", "peer": "jason", "params": {"n": 10_000}, "error": "too slow"},
]
TEXT = json.dumps({"machine": {"cores": 2}, "results": ROWS})
GOALS = """\
| goal | bound | measured | |
|---|---:|---:|---|
| W2: first, time of `swipl` | at most 1.5 | 1 | reached |
| W2: all, time of `swipl` | at most 1.5 | 1.75 | not reached |
| W4: tasks a second | at least 300,000 | 250,000 | not reached |"""
TABLE = """\
| system | 1,000 | 10,000 |
|---|---:|---:|
| `rapc` | 2 | 7 |
| `swipl` |  | 4 |"""


def test_goals_are_told_as_far_as_both_sides_were_measured() -> None:
    assert "\n".join(goals(Results(TEXT.encode()))) == GOALS


def test_tables_have_ours_first_and_leave_out_what_nobody_measured() -> None:
    text = "\n".join(tables(Results(TEXT.encode())))
    assert TABLE in text
    assert [p.title in text for p in PANELS] == [False, True, True, False, True, False]
    assert "jason" not in text


def test_tables_go_between_the_marks_of_a_page(tmp_path: Path) -> None:
    results, page = tmp_path / "results.json", tmp_path / "page.md"
    results.write_text(TEXT)
    page.write_text(f"before\n{BEGIN}old\n{END}after\n")
    main([str(results), "--page", str(page)])
    text = page.read_text()
    assert text.startswith(f"before\n{BEGIN}Measured in one run; cores 2.\n\n{GOALS}")
    assert text.endswith(f"\n{END}after\n")
    assert "old" not in text
    with pytest.raises(ValueError, match="no marks"):
        put("a page", "a text")


def test_the_chart_is_the_same_for_the_same_results(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib", reason="the chart is an extra")
    results, chart = tmp_path / "results.json", tmp_path / "chart.svg"
    results.write_text(TEXT)
    drawn = []
    for _ in range(2):
        main([str(results), "--chart", str(chart)])
        drawn.append(chart.read_text())
    assert drawn[0] == drawn[1]
    assert drawn[0].count("swipl") >= 1
    assert "W4: tasks of a tree" in drawn[0]
