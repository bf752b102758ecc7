"""docs/testing.md: its example runs as printed, and its tables leave nothing out."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rapc.language.heads import TEST_CLAUSES, rules_by_head
from rapc.parser.special import tests
from rapc.testing.coverage import COLUMNS

from ..cli.command import rapc

PAGE = (Path(__file__).parents[2] / "docs" / "testing.md").read_text(encoding="utf-8")


@pytest.fixture
def example(tmp_path: Path) -> Path:
    """A folder with the files of the page."""
    for block in re.findall(r"^```rap\n(.*?)^```$", PAGE, re.M | re.S):
        name = block.partition("\n")[0].removeprefix(";;; ")
        (tmp_path / name).write_text(block, encoding="utf-8")
    return tmp_path


def test_the_example_is_clean(example: Path) -> None:
    assert rapc("check", "arms.rap", cwd=example).returncode == 0


def test_the_example_prints_what_the_page_says(example: Path) -> None:
    [console] = re.findall(r"^```console\n\$ (.*?)^```$", PAGE, re.M | re.S)
    command, _, printed = console.partition("\n")
    done = rapc(*command.split()[1:], cwd=example)
    at = 0
    for part in printed.split("...\n"):
        assert part in done.stdout[at:]
        at = done.stdout.index(part, at) + len(part)
    assert done.returncode == 1


def _told(heading: str) -> set[str]:
    """The words in the first column of the table below a heading."""
    section = PAGE.partition(f"{heading}\n")[2].partition("\n#")[0]
    cells = re.findall(r"^\| (`.*?) \| ", section, re.M)
    return {word for cell in cells for word in re.findall(r"`[(]?([:a-z-]+)", cell)}


def test_tables_name_everything_and_nothing_else() -> None:
    assert _told("## What is given") == set(TEST_CLAUSES)
    assert _told("### The script") == set(rules_by_head("_once_row_option"))
    assert _told("### At a time") == set(tests.ACTIONS)
    assert _told("## What is expected") == {*rules_by_head("expectation")}


def test_the_columns_of_coverage_are_explained() -> None:
    told = re.findall(r"`([a-z ]+)`", PAGE.partition("## Coverage\n")[2])
    assert set(COLUMNS.values()) <= set(told)
