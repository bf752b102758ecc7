"""Slips in real libraries are found; docs/slips.md tells how many of which kind."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import pytest

from bench.mutation import KINDS, LIBRARIES, NOT_SURE, Bench, Outcome, outcomes

PAGE = Path(__file__).parents[1] / "docs" / "slips.md"


@pytest.fixture(scope="module")
def benches() -> Sequence[Bench]:
    """The libraries, in which nothing is found as they are."""
    return [Bench(paths) for paths in LIBRARIES]


def test_there_are_many_kinds_of_slips_and_the_page_has_them_all() -> None:
    assert len(KINDS) - len(NOT_SURE) >= 40
    assert set(NOT_SURE) < set(KINDS)
    rows = re.findall(r"^\| \w+ \| (.*?) \| \d+ \|", PAGE.read_text("utf-8"), re.M)
    assert rows == list(KINDS)


@pytest.mark.slow
def test_slips_of_the_visible_kinds_are_found(benches: Sequence[Bench]) -> None:
    made: list[Outcome] = []
    missed = []
    for kind in KINDS:
        if kind not in NOT_SURE:
            there = [one for _, one in outcomes(kind, benches, 2, 1)]
            made += there
            missed += [kind for one in there if not one.found]
    assert len(missed) <= len(made) // 20, missed
    assert sum(one.named for one in made) >= 0.85 * len(made)
    assert sum(len(one.found) == 1 for one in made) >= 0.85 * len(made)


@pytest.mark.slow
def test_the_same_seed_makes_the_same_slips(benches: Sequence[Bench]) -> None:
    kind = "predicate misspelt"
    one, two = ([o.edit for _, o in outcomes(kind, benches, 5, 3)] for _ in range(2))
    assert one == two
    assert len(one) == 5
