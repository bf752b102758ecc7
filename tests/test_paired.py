"""Two checkouts measured in turn: what is made of the figures."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from bench.paired import BENCHES, Figures, ratio, read_rows, table
from bench.run import BENCHES as ALL

CHECKOUT = Path(__file__).parents[1]

PRINTED = """\
CPython 3.11.7, Linux x86_64, 2 cores

| bench | what | size | figure | unit |
|---|---|---|---:|---|
| order | CPU time of a run | 20 seeds, median | 1,026.5 | ms |
| queries | all of 3.0 answers, site bound | 100 items | 3.5e-05 | us |
"""


def test_every_bench_is_measured_but_that_of_what_older_checkouts_have_not() -> None:
    assert set(ALL) - set(BENCHES) == {"saving"}
    assert set(BENCHES) <= set(ALL)


def test_rows_are_read_as_they_are_printed() -> None:
    assert read_rows(PRINTED) == {
        ("order", "CPU time of a run", "20 seeds, median", "ms"): 1026.5,
        ("queries", "all of 3.0 answers, site bound", "100 items", "us"): 3.5e-05,
    }


@pytest.mark.parametrize(
    ("unit", "ours", "theirs", "expected"),
    [
        ("ms", [2, 3, 10], [1, 2, 10], 1.5),
        ("tasks/s", [50, 60], [100, 120], 2),
        ("MB", [0, 1], [1, 1], None),
    ],
)
def test_a_ratio_above_one_is_slower(
    unit: str, ours: list[float], theirs: list[float], expected: float | None
) -> None:
    assert ratio(unit, ours, theirs) == expected


def test_slower_rows_are_marked_and_rows_of_one_side_named() -> None:
    ours: Figures = {("a", "run", "1", "s"): [1.2], ("a", "walk", "1", "s"): [1.0]}
    theirs: Figures = {("a", "run", "1", "s"): [1.0], ("b", "ride", "", "s"): [1.0]}
    assert list(table(ours, theirs))[2:] == [
        "| a | run | 1 | 1 | 1.2 | s | 1.200 | slower |",
        "",
        "only ours: a, walk, 1, s",
        "only theirs: b, ride, s",
        "1 of 1 rows are above 1.05; median 1.200",
    ]


@pytest.mark.nightly
def test_a_checkout_is_measured_beside_itself() -> None:
    command = [sys.executable, "-m", "bench.paired", "--against", str(CHECKOUT)]
    done = subprocess.run(
        [*command, "--rounds", "1", "order", "W", "start"],
        cwd=CHECKOUT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    for row in ("| order | CPU time of a run |", "| W4 | a task |", "| start | rapc"):
        assert row in done.stdout
    assert "only " not in done.stdout
