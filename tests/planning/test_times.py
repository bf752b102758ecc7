"""The times of searches, as `python -m bench.plans --search` prints them."""

from __future__ import annotations

import re

import pytest

from bench.plans import searches, timed


@pytest.mark.slow
def test_timed_searches_find_plans() -> None:
    lines = [timed(one, 1) for one in searches()]
    steps = [re.search(r"solved, (\d+) steps", line) for line in lines]
    assert [int(one[1]) for one in steps if one] == [8, 7, 42, 22]
    assert "ground steps" in lines[3]


@pytest.mark.nightly
def test_searches_keep_their_times() -> None:
    for one in searches():
        line = timed(one, 9)
        found = re.match(r".*: (\d+) ms of (\d+) ", line)
        assert found is not None
        assert int(found[1]) <= int(found[2]), line
