"""A save with one changed record is refused, or the run that it makes goes on."""

from __future__ import annotations

from collections import Counter

import pytest

from tests.runtime import changed_saves

RECORDS = {"truck": 25, "courier": 100, "hallway": 25}
"""How many changed saves are tried by default."""


@pytest.mark.parametrize("name", changed_saves.RUNS)
def test_changed_saves_are_refused_or_go_on(name: str) -> None:
    _try(name, RECORDS[name], seed=0)


@pytest.mark.slow
@pytest.mark.parametrize("name", changed_saves.RUNS)
def test_many_changed_saves_are_refused_or_go_on(name: str) -> None:
    _try(name, 8 * RECORDS[name], seed=1)


def _try(name: str, records: int, seed: int) -> None:
    outcomes = list(changed_saves.trials(name, records, seed))
    faults = [f"{words}: {one.said}" for words, one in outcomes if one.kind == "fault"]
    count = Counter(one.kind for _, one in outcomes)
    assert faults == []
    assert count["refused"] > records // 4
    assert count["went on"] > records // 4
