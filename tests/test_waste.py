"""`bench.waste`: other rules save requests, and are gone when no longer meant."""

from __future__ import annotations

import pytest

from bench.waste import RULES, hopeless, rule


@pytest.mark.slow
def test_the_other_rules_give_up_sooner_and_leave_nothing_behind() -> None:
    before = list(hopeless())
    told = {row.split("|")[1].strip(): row.split("|")[2:] for row in before[2:]}
    assert set(told) == set(RULES)
    asked = {name: int(cells[0]) for name, cells in told.items()}
    assert asked["cause"] < asked["T"] / 5
    assert asked["family"] < asked["T"] / 5
    assert all(cells[3].strip() == "0" for cells in told.values())
    with rule("T"):
        assert next(row for row in hopeless() if "| T |" in row) == before[2]
