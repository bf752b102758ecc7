"""The examples of the how-to pages: each program is shown as it is, or named.

Every folder is one library that the checker has nothing to say against, and its tests
hold whatever chance does.
"""

from __future__ import annotations

import pytest

import rapc
from rapc.console.testing.explain import failure_lines
from rapc.testing.discover import find
from rapc.testing.run import Case, Status, run_case

from .pages import CHECKOUT, blocks

EXAMPLES = CHECKOUT / "examples"
HOW_TO = CHECKOUT / "docs" / "how-to"
FOLDERS = ("cookbook", "idioms")
SEEDS = range(5)


def _cases() -> list[Case]:
    """The tests of all folders."""
    return [case for folder in FOLDERS for case in find([EXAMPLES / folder]).cases]


def _name(case: Case) -> str:
    return case.test.name


@pytest.mark.parametrize("folder", FOLDERS)
def test_how_to_pages_show_or_name_each_program(folder: str) -> None:
    """A page shows the whole file, or names `examples/FOLDER/FILE`."""
    pages = [file.read_text(encoding="utf-8") for file in HOW_TO.glob("*.md")]
    shown = [block for page in pages for block in blocks(page, "rap")]
    for file in (EXAMPLES / folder).glob("*.rap"):
        if file.name.endswith(".test.rap"):
            continue
        texts = {block.text for block in shown if block.name == file.name}
        if not any(f"`examples/{folder}/{file.name}`" in page for page in pages):
            assert texts, file.name
        assert texts <= {file.read_text(encoding="utf-8")}, file.name


@pytest.mark.parametrize("folder", FOLDERS)
def test_the_checker_has_nothing_to_say(folder: str) -> None:
    assert rapc.check(EXAMPLES / folder).findings == ()


@pytest.mark.parametrize("folder", FOLDERS)
def test_every_program_has_its_tests(folder: str) -> None:
    names = {file.name for file in (EXAMPLES / folder).glob("*.rap")}
    programs = {name for name in names if not name.endswith(".test.rap")}
    assert programs
    assert {n.removesuffix(".test.rap") for n in names - programs} == {
        n.removesuffix(".rap") for n in programs
    }


@pytest.mark.parametrize("case", _cases(), ids=_name)
def test_tests_hold_whatever_chance_does(case: Case) -> None:
    for seed in SEEDS:
        outcome = run_case(case, seed)
        assert outcome.status is Status.PASSED, "\n".join(
            line.text for line in failure_lines(outcome)
        )
