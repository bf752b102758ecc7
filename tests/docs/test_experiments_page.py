"""docs/experiments.md: its example runs, and its tables name every key and measure."""

from __future__ import annotations

import re
import sqlite3
from pathlib import Path

import msgspec
import pytest

from rapc.experiments.definition import Experiment, Reference, Series
from rapc.experiments.measures import LABELS

from ..cli.command import rapc

CHECKOUT = Path(__file__).parents[2]
PAGE = (CHECKOUT / "docs" / "experiments.md").read_text(encoding="utf-8")
SECTIONS = dict(re.findall(r"^## ([^\n]*)\n(.*?)(?=^## |\Z)", PAGE, re.M | re.S))


def _keys(kind: type[msgspec.Struct]) -> list[str]:
    return [field.encode_name for field in msgspec.structs.fields(kind)]


def _told(text: str) -> list[str]:
    cells = re.findall(r"^\| (`[a-z-]+`(?:, `[a-z-]+`)*) \| ", text, re.M)
    return [name for cell in cells for name in re.findall(r"`([a-z-]+)`", cell)]


def test_tables_name_all_keys_and_no_others() -> None:
    of_file, _, of_part = SECTIONS["The file"].partition("A part is a series")
    assert sorted([*_told(of_file), "name"]) == sorted(_keys(Experiment))
    assert sorted(_told(of_part)) == sorted(_keys(Series))
    told = of_part.partition("A `reference` has")[2].partition("\n\n")[0]
    assert all(f"`{key}`" in told for key in _keys(Reference))


def test_table_names_all_measures_and_no_others() -> None:
    assert _told(SECTIONS["What is measured"]) == list(LABELS)


@pytest.fixture
def example(tmp_path: Path) -> Path:
    """A folder with the example, and with the examples of the checkout."""
    [toml] = re.findall(r"^```toml\n(.*?)^```$", PAGE, re.M | re.S)
    (tmp_path / "drops.toml").write_text(toml, encoding="utf-8")
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
