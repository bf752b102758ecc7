"""The benchmarks run; what they measure is in docs/developers/performance.md."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from bench import growth
from bench.run import BENCHES
from rapc.analysis.driver import check_library
from rapc.library.loader import load_text

CHECKOUT = Path(__file__).parents[1]
PAGE = (CHECKOUT / "docs" / "developers" / "performance.md").read_text(encoding="utf-8")


def _rows(text: str) -> list[tuple[str, str, str]]:
    """Bench, what and unit of each row of a table of figures, sizes left out."""
    rows = re.findall(r"^\| (\w+) \| (.*) \| .* \| [\d.,]+ \| (.*) \|$", text, re.M)
    return [
        (bench, re.sub(r"[\d.]+ answers", "answers", what), unit)
        for bench, what, unit in rows
    ]


def test_every_construct_is_one_that_can_be_checked() -> None:
    found = dict(growth.rows(share=100))
    assert len(found) == len(growth.CONSTRUCTS) * len(growth.WORKS)
    reports = {
        name: check_library(load_text(make(3)))
        for name, (make, _) in growth.CONSTRUCTS.items()
    }
    clean = [name for name, report in reports.items() if not report.findings]
    assert "unknown predicates" not in clean
    assert {"RAPs", "steps in a chain", "methods of one RAP"} <= set(clean)


@pytest.mark.long
@pytest.mark.slow
def test_benchmarks_run_and_the_page_has_their_figures() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "bench.run", "--quick"],
        cwd=CHECKOUT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    rows = _rows(done.stdout)
    assert {bench for bench, _, _ in rows} == set(BENCHES)
    assert set(rows) == set(_rows(PAGE))
