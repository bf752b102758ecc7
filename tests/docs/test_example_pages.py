"""The pages made of examples: each program of a folder stands on its page as it is.

Every folder is one library that the checker has nothing to say against, and its tests
hold whatever chance does.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import rapc
from rapc.console.testing.explain import failure_lines
from rapc.testing.discover import find
from rapc.testing.run import Case, Status, run_case

CHECKOUT = Path(__file__).parents[2]
EXAMPLES = CHECKOUT / "examples"
FOLDERS = ("cookbook", "idioms")
SEEDS = range(5)

_BLOCK = re.compile(r"^```rap (\S+)\n(.*?)^```$", re.M | re.S)


def _cases() -> list[Case]:
    """The tests of all folders."""
    return [case for folder in FOLDERS for case in find([EXAMPLES / folder]).cases]


def _name(case: Case) -> str:
    return case.test.name


@pytest.mark.parametrize("folder", FOLDERS)
def test_programs_stand_on_their_page_as_they_are(folder: str) -> None:
    page = (CHECKOUT / "docs" / f"{folder}.md").read_text(encoding="utf-8")
    shown = _BLOCK.findall(page)
    files = [
        (file.name, file.read_text(encoding="utf-8"))
        for file in (EXAMPLES / folder).glob("*.rap")
        if not file.name.endswith(".test.rap")
    ]
    assert sorted(shown) == sorted(files)


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
