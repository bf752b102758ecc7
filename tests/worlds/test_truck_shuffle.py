"""The shuffling demon (T 6.1.1, 6.1.2, 6.3.1)."""

from __future__ import annotations

import random
from collections import Counter

from rapc.worlds.truck import TruckWorld

from .drive import Driver, rock, thing

EVERYWHERE = ["depot", "quarry-1", "warehouse", "zone-1"]
"""The places of the small map that see the demon."""


def places(driver: Driver, kind: str = "rock") -> Counter[str]:
    """How many items of a kind are where."""
    items = driver.world.state.items.values()
    return Counter(item.place for item in items if item.kind == kind)


def test_nothing_moves_by_itself_unless_an_interval_is_given() -> None:
    driver = Driver([rock(count=5)])
    driver.world.advance(1000)
    assert places(driver) == {"depot": 5}


def test_the_demon_comes_at_regular_times() -> None:
    driver = Driver(
        [rock(count=10)], shuffle_interval=20, shuffle_efficiency=100, item_limit=20
    )
    for time in range(20, 400, 20):
        before = dict(driver.world.state.items)
        driver.world.advance(time - 0.5)
        assert driver.world.state.items == before
        driver.world.advance(time)
        after = driver.world.state.items
        assert all(after[name].place != before[name].place for name in after)


def test_efficiency_is_the_chance_to_move_an_item() -> None:
    moved = 0
    for seed in range(100):
        driver = Driver(
            [rock(count=10)], shuffle_interval=15, shuffle_efficiency=40, seed=seed
        )
        driver.world.advance(15)
        moved += 10 - places(driver)["depot"]
    assert 0.35 <= moved / 1000 <= 0.45


def test_an_efficiency_of_nothing_moves_nothing() -> None:
    driver = Driver([rock(count=5)], shuffle_interval=5, shuffle_efficiency=0)
    driver.world.advance(1000)
    assert places(driver) == {"depot": 5}


def test_items_go_to_all_places_but_factories() -> None:
    driver = Driver(
        [rock(count=8), rock("factory-1", count=2)],
        shuffle_interval=5,
        shuffle_efficiency=100,
    )
    seen: Counter[str] = Counter()
    for time in range(5, 2000, 5):
        driver.world.advance(time)
        seen.update(places(driver))
        assert places(driver)["factory-1"] == 2
    assert sorted(seen) == sorted([*EVERYWHERE, "factory-1"])


def test_no_place_gets_more_than_the_limit() -> None:
    driver = Driver(
        [rock(place, count=10) for place in EVERYWHERE[:3]] + [rock("zone-1", count=6)],
        shuffle_interval=5,
        shuffle_efficiency=70,
    )
    for time in range(5, 1000, 5):
        driver.world.advance(time)
        assert max(places(driver).values()) <= 10
        assert places(driver).total() == 36
    crowded = Driver([rock(count=14)], shuffle_interval=5, item_limit=0)
    crowded.world.advance(100)
    assert places(crowded) == {"depot": 14}


def test_the_demon_stops_for_good() -> None:
    driver = Driver(
        [rock(count=5)], shuffle_interval=10, shuffle_efficiency=100, shuffle_until=50
    )
    driver.world.advance(40)
    last = driver.world.state.items
    driver.world.advance(2000)
    assert driver.world.state.items == last


def test_items_on_the_truck_are_not_shuffled() -> None:
    driver = Driver(
        [rock(count=2)], start="depot", shuffle_interval=30, shuffle_efficiency=100
    )
    driver.do("arm-move arm1 external", "arm-move arm1 rock-1", "arm-grasp arm1 rock-1")
    driver.do("arm-move arm1 bay2", "arm-ungrasp arm1 rock-1", "arm-move arm1 external")
    driver.do("arm-move arm1 rock-2", "arm-grasp arm1 rock-2")
    driver.world.advance(500)
    assert (driver.place("rock-1"), driver.place("rock-2")) == ("bay2", "arm1")


def test_arm_at_a_moved_item_is_at_no_item() -> None:
    driver = Driver([rock()], shuffle_interval=10, shuffle_efficiency=100)
    driver.do("eye-scan external", "arm-move arm1 external", "arm-move arm1 rock-1")
    driver.world.advance(10)
    assert driver.do("arm-grasp arm1 rock-1") == "arm-not-at"
    assert driver.do("arm-move arm1 rock-1") == "arm-cant-find"
    assert driver.data("eye-scan external")[0] == ("object-gone", "external", "rock-1")


def test_tools_are_left_alone_unless_an_option_says_otherwise() -> None:
    for tools, moves in ((False, False), (True, True)):
        driver = Driver(
            [thing("gun"), thing("gun-tool"), thing("enemy-unit")],
            shuffle_interval=5,
            shuffle_efficiency=100,
            shuffle_tools=tools,
            capture_time=0,
        )
        driver.world.advance(5)
        assert (driver.place("gun-1") != "depot") == moves
        assert (driver.place("gun-tool-1") != "depot") == moves
        assert driver.place("enemy-unit-1") == "depot"


def test_shuffling_leaves_the_luck_of_the_rest_as_it_was() -> None:
    clocks = []
    for interval in (0, 8):
        options = {"shuffle-interval": interval, "enemy-interval": 0}
        world = TruckWorld(random.Random(4), options)
        for turn in ("northwest", "north", "north", "northeast"):
            world.perform(0, ("truck-turn", turn))
            world.perform(0, ("truck-move",))
        clocks.append((world.now(), world.state.truck.fuel))
    assert clocks[0] == clocks[1]
