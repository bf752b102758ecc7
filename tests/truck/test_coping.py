"""What can go wrong in an order, and that the library copes with it."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import pytest

from rapc.base.values import Atom, Text
from rapc.errors import RefusedError
from tests.effort import first

from .runs import FACTORIES, PLENTY, Run, map_with, order, task

SEEDS = first(2, range(8))


@pytest.mark.parametrize("seed", SEEDS)
def test_the_stronger_arm_takes_what_is_too_big_for_the_other(seed: int) -> None:
    run = Run(order("red"), seed=seed, options={"arm1-capacity": 5})
    assert run.outcomes == ["succeeded"]
    assert run.answers["arm-grasp", "okay"] == 8
    assert not any(r.startswith("(arm-ungrasp arm1") for r in run.requests)
    assert run.answers["arm-grasp", "arm-too-full"] == 4, "once for each rock"
    run.assert_honest()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_other_arm_is_tried_when_one_drops_everything(seed: int) -> None:
    run = Run(order("red", 2), seed=seed, options={"arm1-drops": 100})
    assert run.outcomes == ["succeeded"]
    assert not any(r.startswith("(arm-ungrasp arm1") for r in run.requests)
    run.assert_honest()


def test_hands_that_drop_everything_give_the_order_up() -> None:
    run = Run(order("red"), options={"arm1-drops": 100, "arm2-drops": 100})
    assert (run.reason, run.outcomes) == ("done", ["failed"])
    assert run.interpreter.results()[0].result == "arm-dropped"
    run.assert_honest()


@pytest.mark.parametrize("seed", SEEDS)
def test_small_bay_makes_several_trips(seed: int) -> None:
    run = Run(order("red", 5), seed=seed, options={"bay2-capacity": 20})
    assert run.outcomes == ["succeeded"]
    assert run.delivered == {("red", "factory-1"): 5}
    times = [each.time for each in run.world.deliveries]
    pauses = [b - a for a, b in pairwise(times) if b - a > 100]
    assert len(pauses) == 2, "two rocks a trip"
    run.assert_honest()


@pytest.mark.parametrize("seed", SEEDS)
def test_waits_for_rocks_that_are_still_to_be_made(seed: int) -> None:
    empty = map_with(("fuel-drum", "depot", 1, None))
    run = Run(order("blue"), seed=seed, options={**PLENTY, "map": empty})
    assert run.outcomes == ["succeeded"]
    assert run.interpreter.now > 250
    run.assert_honest()


@pytest.mark.parametrize("seed", SEEDS)
def test_only_rocks_of_the_colour_are_taken(seed: int) -> None:
    mixed = map_with(
        ("rock", "quarry-1", 2, "blue"),
        ("rock", "quarry-1", 3, "red"),
        ("rock", "depot", 2, "yellow"),
        ("rock", "depot", 1, "red"),
        ("rock", "factory-1", 3, "red"),
    )
    run = Run(
        order("red"), seed=seed, options={"map": mixed, "factory-interval": 1_000_000}
    )
    assert run.outcomes == ["succeeded"]
    assert run.delivered == {("red", "factory-1"): 4}
    assert run.answers["arm-ungrasp", "okay"] == 8, "nothing else was moved"
    run.assert_honest()


def test_a_known_place_is_visited_before_the_quarry() -> None:
    near = map_with(("rock", "depot", 2, "red"), ("rock", "quarry-1", 4, "red"))
    look = task("examine-surroundings", priority=2)
    away = task("truck-travel-to", "zone-5", priority=1)
    run = Run(look, away, order("red", 2), options={"map": near})
    assert run.outcomes == ["succeeded"] * 3
    assert {each.item for each in run.world.deliveries} == {"rock-1", "rock-2"}
    run.assert_honest()


@pytest.mark.parametrize("seed", SEEDS)
def test_orders_of_one_colour_share_no_rock(seed: int) -> None:
    run = Run(order("red"), order("red"), seed=seed, options=PLENTY)
    assert run.outcomes == ["succeeded"] * 2
    assert run.delivered == {("red", "factory-1"): 8}
    run.assert_honest()


@pytest.mark.parametrize("seed", SEEDS)
def test_nine_orders_while_somebody_watches(seed: int) -> None:
    orders = [
        order(color, at=120 + 180 * turn + 60 * place)
        for turn in range(3)
        for place, color in enumerate(FACTORIES)
    ]
    watch = task("watch-surroundings", priority=8, background=True)
    run = Run(watch, *orders, seed=seed, options=PLENTY)
    assert run.outcomes == ["succeeded"] * 9
    assert run.delivered == dict.fromkeys(FACTORIES.items(), 12)
    run.assert_honest()


@pytest.mark.parametrize("seed", SEEDS)
def test_orders_wait_for_room_that_others_take_up(seed: int) -> None:
    options = {**PLENTY, "bay2-capacity": 15}
    run = Run(*(order(color) for color in FACTORIES), seed=seed, options=options)
    assert run.outcomes == ["succeeded"] * 3
    assert run.delivered == dict.fromkeys(FACTORIES.items(), 4)
    run.assert_honest()


@pytest.mark.parametrize("at", first(2, range(130, 330, 4)))
def test_an_arm_emptied_by_another_task_is_no_delivery(at: int) -> None:
    empty = task("arm-empty", "arm1", at=at, priority=5)
    run = Run(order("red"), empty, options={"arm1-drops": 0})
    assert run.outcomes == ["succeeded"] * 2
    assert run.delivered == {("red", "factory-1"): 4}
    run.assert_honest()


@pytest.mark.parametrize("at", first(2, range(10, 330, 10)))
def test_a_truck_taken_away_comes_back(at: int) -> None:
    away = task("truck-travel-to", "warehouse", at=at, priority=5)
    run = Run(order("red"), away, options=PLENTY)
    assert run.outcomes == ["succeeded"] * 2
    assert run.delivered == {("red", "factory-1"): 4}
    run.assert_honest()


@pytest.mark.parametrize("seed", SEEDS)
def test_urgent_orders_go_first_and_none_is_lost(seed: int) -> None:
    run = Run(
        order("red", priority=2),
        order("red", factory="factory-2", at=40, priority=3),
        order("yellow", at=80, priority=4),
        seed=seed,
        options=PLENTY,
    )
    assert run.outcomes == ["succeeded"] * 3
    wanted = {
        ("red", "factory-1"): 4,
        ("red", "factory-2"): 4,
        ("yellow", "factory-3"): 4,
    }
    assert run.delivered == wanted
    assert run.world.deliveries[0].color == "yellow"
    run.assert_honest()


def test_a_color_that_is_none_is_refused() -> None:
    with pytest.raises(RefusedError, match="`green` is not a value of kind color"):
        Run(order("green"))


def test_what_cannot_be_is_given_up_at_once() -> None:
    run = Run(order("red", factory="factory-9"))
    assert (run.reason, run.outcomes) == ("done", ["failed"])
    assert run.delivered == Counter()
    assert run.interpreter.now < 10


def test_a_quarry_that_makes_nothing_is_given_up() -> None:
    full = map_with(("fuel-drum", "quarry-1", 11, None))
    watch = task("watch-surroundings", priority=8, background=True)
    run = Run(watch, order("red"), options={"map": full})
    assert (run.reason, run.outcomes) == ("done", ["failed"])
    assert 500 < run.interpreter.now < 1500
    run.assert_honest()


ISLAND = """\
{"start": "pit", "places": [{"name": "pit", "kind": "quarry", "color": "red"},
  {"name": "works", "kind": "factory"}, {"name": "island", "kind": "factory"}],
 "roads": [{"name": "lane", "from": "pit", "direction": "west", "to": "works",
   "time": 20, "fuel": 0}],
 "items": [{"kind": "rock", "color": "red", "place": "pit", "count": 4}]}
"""


def test_rocks_of_an_order_given_up_make_room_for_another() -> None:
    options: dict[str, Atom | bool] = {"map": Text(ISLAND), "bay2-capacity": 15}
    lost = order("red", 2, factory="island", priority=2)
    run = Run(lost, order("red", 2, factory="works"), options=options)
    assert run.outcomes == ["failed", "succeeded"]
    assert run.delivered == {("red", "works"): 2}
    run.assert_honest()
