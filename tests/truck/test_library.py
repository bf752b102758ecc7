"""The tests that stand beside the files of the truck library: they pass and suffice."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rapc.analysis.driver import check_library
from rapc.analysis.facts.index import Index
from rapc.base.files import TEST_SUFFIX
from rapc.console.testing.explain import failure_lines
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.library.loader import load
from rapc.testing.coverage import Coverage
from rapc.testing.discover import find
from rapc.testing.run import Status, run_case

from .runs import STDLIB

LIBRARIES = (STDLIB / "truck", STDLIB / "truck-beyond")
TESTED = tuple(
    sorted(
        str(path.relative_to(STDLIB))
        for library in LIBRARIES
        for path in library.glob(f"*{TEST_SUFFIX}")
    )
)
SEEDS = range(3)


def covered(file: str) -> Coverage:
    """What the tests of one file exercise, under all seeds; they must pass."""
    found = find([STDLIB / file])
    assert found.reports == ()
    assert found.cases
    coverage = Coverage()
    for case in found.cases:
        for seed in SEEDS:
            outcome = run_case(case, seed, coverage=coverage)
            assert outcome.status is Status.PASSED, "\n".join(
                line.text for line in failure_lines(outcome)
            )
    return coverage


@pytest.mark.parametrize("file", TESTED)
def test_the_tests_of_a_file_pass_and_choose_every_method(file: str) -> None:
    """They pass whatever the seed."""
    own = Path(file.removesuffix(TEST_SUFFIX) + ".rap").name
    [mine] = [each for each in covered(file).files() if Path(each.file).name == own]
    chosen = {
        f"{rap.name} {method.name}": method.chosen
        for rap in mine.raps
        for method in rap.methods
    }
    never = [name for name, times in chosen.items() if not times]
    assert never == []


@pytest.mark.parametrize("library", LIBRARIES, ids=lambda path: path.name)
def test_nothing_is_found_wrong_with_library_and_tests(library: Path) -> None:
    assert check_library(load([library], tests=True)).findings == ()


def test_no_conjunction_of_four_parts_stands_twice() -> None:
    """Variables may be called otherwise; what is asked more than once has a name."""
    found: dict[tuple[str, ...], list[str]] = {}
    for asked in Index(load([STDLIB]).library).of(nodes.And):
        parts = asked.node.parts
        for first in range(len(parts) - 3):
            said = _nameless(parts[first : first + 4])
            found.setdefault(said, []).append(str(asked.node.span))
    assert found
    assert [places for places in found.values() if len(places) > 1] == []


def _nameless(parts: tuple[nodes.Formula, ...]) -> tuple[str, ...]:
    """Formulas as text, their variables numbered in the order of the text."""
    names: dict[str, str] = {}

    def numbered(found: re.Match[str]) -> str:
        return names.setdefault(found[0], f"?{len(names)}")

    return tuple(re.sub(r"\?[\w-]+", numbered, format_formula(p)) for p in parts)
