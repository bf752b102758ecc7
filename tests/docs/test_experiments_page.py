"""docs/how-to/experiments.md: its example runs, and its query finds the results."""

from __future__ import annotations

import re
import sqlite3
from pathlib import Path

import pytest

from ..cli.command import rapc
from .pages import CHECKOUT, blocks, page

PAGE = page("how-to/experiments")


@pytest.fixture
def example(tmp_path: Path) -> Path:
    """A folder with the example, and with the examples of the checkout."""
    [toml] = [block for block in blocks(PAGE, "toml") if block.name]
    (tmp_path / toml.name).write_text(toml.text, encoding="utf-8")
    (tmp_path / "examples").symlink_to(CHECKOUT / "examples")
    return tmp_path


def test_the_example_and_the_query_work(example: Path) -> None:
    done = rapc("experiment", "drops.toml", "--jobs", "1", cwd=example)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.search(r"^30 +6 +0 +\d+ ± \d+ +1\.0 ± 0\.0 ", done.stdout, re.M)
    assert re.search(r"^30 .* 2\.0$", done.stdout, re.M)
    [query] = re.findall(r"^```sql\n(.*?)^```$", PAGE, re.M | re.S)
    base = sqlite3.connect(example / "drops-results" / "results.sqlite")
    rows = base.execute(query).fetchall()
    base.close()
    assert [drops for drops, _ in rows] == [0, 30, 60]
    assert all(0 < time < 3000 for _, time in rows)
