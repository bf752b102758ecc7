"""The two situations of T 6.2 in the simulator: a weapon to mount, troops on the way.

Each run readies the weapon, fills a small order and drives to a place of its own, while
troops come to the zones ten times as often as by default.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import pytest

from .runs import STDLIB, Run, library, order, task

pytestmark = [pytest.mark.slow, pytest.mark.xdist_group("situations")]

SEEDS = range(80)
OPTIONS = {"enemy-interval": 60, "fuel": 1000, "fuel-capacity": 1000}


@pytest.fixture(scope="module")
def runs() -> Sequence[Run]:
    """A run for each seed; about four seconds in all."""
    compiled = library(STDLIB / "truck")
    return [
        Run(
            task("watch-surroundings", priority=8, background=True),
            task("handle-enemy-troops", priority=6, background=True),
            task("ready-weapon", priority=5),
            order("blue", 2, priority=3),
            task("truck-travel-to", "quarry-3", priority=2),
            seed=seed,
            options=OPTIONS,
            compiled=compiled,
        )
        for seed in SEEDS
    ]


def captured(run: Run) -> bool:
    """Whether troops had the truck in the end."""
    return any(met.how == "captured" for met in run.world.encounters)


def test_the_weapon_is_mounted_in_every_run(runs: Sequence[Run]) -> None:
    for seed, run in zip(SEEDS, runs, strict=True):
        assert run.places["gun-1"] == "weapon-bay", f"seed {seed}"
        assert run.outcomes[0] == "succeeded", f"seed {seed}"


def test_troops_are_gone_or_left_within_forty_units(runs: Sequence[Run]) -> None:
    for seed, run in zip(SEEDS, runs, strict=True):
        for met in run.world.encounters:
            lasted = (met.until or run.interpreter.now) - met.time
            assert lasted <= 40 or met.how == "captured", f"seed {seed}: {met}"


def test_both_ways_of_getting_rid_of_them_are_gone(runs: Sequence[Run]) -> None:
    ways = Counter(met.how for run in runs for met in run.world.encounters)
    assert ways["shot"] > 40
    assert ways["left"] > 40
    assert sum(map(captured, runs)) <= 4


def test_the_journey_ends_where_it_was_meant_to(runs: Sequence[Run]) -> None:
    for seed, run in zip(SEEDS, runs, strict=True):
        if not captured(run):
            assert run.outcomes == ["succeeded"] * 3, f"seed {seed}"
            assert run.world.state.truck.place == "quarry-3", f"seed {seed}"
            assert run.delivered == {("blue", "factory-2"): 2}, f"seed {seed}"
            run.assert_honest()


def test_the_standing_tasks_stand_to_the_end(runs: Sequence[Run]) -> None:
    for seed, run in zip(SEEDS, runs, strict=True):
        standing = [r for r in run.interpreter.results() if r.background]
        assert [r.outcome for r in standing] == ["unfinished"] * 2, f"seed {seed}"
