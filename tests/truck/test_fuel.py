"""Fuel in the simulator: the truck does not run dry where it need not."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from rapc.base.values import Atom, Text
from tests.effort import first

from .runs import Run, map_with, order, task

Options = Mapping[str, Atom | bool]

SEEDS = first(2, range(8))
NO_OTHERS: Options = {"depot-interval": 0, "enemy-interval": 0}
"""Options with which no drum is made, and nobody disturbs the truck."""
WATCH = (
    task("watch-fuel", priority=4, background=True),
    task("watch-surroundings", priority=8, background=True),
)


def ground(*items: tuple[str, str, int, str | None]) -> Text:
    """The map of T 6.1 with four red rocks at their quarry, and these items."""
    return map_with(("rock", "quarry-1", 4, "red"), *items)


def drums_in_bay1(run: Run) -> int:
    """How many drums the truck has in reserve, in truth."""
    lying = run.world.state.items.values()
    return sum((each.kind, each.place) == ("fuel-drum", "bay1") for each in lying)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_reserve_is_taken_from_the_depot(seed: int) -> None:
    drums = ground(("fuel-drum", "depot", 2, None))
    run = Run(*WATCH, order("red", 1), seed=seed, options={"map": drums})
    assert run.outcomes == ["succeeded"]
    assert drums_in_bay1(run) == 1
    assert run.faults == []


@pytest.mark.parametrize("seed", SEEDS)
def test_an_empty_depot_is_waited_at(seed: int) -> None:
    options: Options = {"map": ground(), "fuel": 4, "enemy-interval": 0}
    run = Run(*WATCH, order("red"), seed=seed, options=options)
    assert run.world.ended() is None
    assert run.outcomes == ["succeeded"]
    assert run.delivered == {("red", "factory-1"): 4}
    assert run.faults == []


@pytest.mark.parametrize("seed", SEEDS)
def test_a_drum_on_the_road_is_used(seed: int) -> None:
    """The eye looks out for one on the way to the depot: the truck stops beside it."""
    roads = ("road-16", "road-17")
    drums = ground(*(("fuel-drum", road, 4, None) for road in roads))
    options: Options = {"map": drums, "fuel": 11, **NO_OTHERS}
    away = task("truck-travel-to", "zone-4", priority=5)
    run = Run(*WATCH, away, order("red", 1), seed=seed, options=options)
    assert run.outcomes == ["succeeded"] * 2
    items = run.world.state.items.values()
    assert sum(each.amount == 0 for each in items if each.place in roads) >= 1


@pytest.mark.parametrize("seed", SEEDS)
def test_the_reserve_is_used_where_there_is_no_other(seed: int) -> None:
    drums = ground(("fuel-drum", "depot", 1, None))
    options: Options = {"map": drums, "fuel": 6, **NO_OTHERS}
    stow = task("stow-fuel-reserve", priority=9)
    look = task("eye-scan-p", "external", priority=10)
    away = task("truck-travel-to", "zone-1", priority=5)
    run = Run(look, stow, away, *WATCH, seed=seed, options=options)
    assert run.outcomes == ["succeeded"] * 3
    assert drums_in_bay1(run) == 1
    run = Run(look, stow, away, *WATCH, order("red", 1), seed=seed, options=options)
    assert run.answers["arm-pour", "okay"] == 1
    assert drums_in_bay1(run) == 0
