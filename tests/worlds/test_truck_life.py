"""What goes on about the truck: production, consumption, orders (T 6.1.1 to 6.1.3)."""

from __future__ import annotations

import random

from rapc.base.values import Text
from rapc.world import Datum
from rapc.worlds.truck import TruckWorld

from .drive import Driver, rock, thing

LOAD = ("arm-move arm1 external", "arm-move arm1 rock-1", "arm-grasp arm1 rock-1")


def kinds_at(driver: Driver, place: str) -> list[str]:
    return [i.kind for i in driver.world.state.items.values() if i.place == place]


def test_stock_replaces_the_rocks_of_the_map() -> None:
    elsewhere = [rock("quarry-1"), rock("quarry-1"), rock("zone-1")]
    driver = Driver(elsewhere, quarry_rocks=8)
    assert kinds_at(driver, "quarry-1") == ["rock"] * 8
    assert kinds_at(driver, "zone-1") == ["rock"]
    assert kinds_at(Driver(elsewhere), "quarry-1") == ["rock"] * 2


def test_none_is_made_where_more_than_ten_lie() -> None:
    driver = Driver(quarry_interval=10, warehouse_interval=20, depot_interval=5)
    driver.world.advance(60)
    assert 3 <= kinds_at(driver, "quarry-1").count("rock") <= 9
    driver.world.advance(1000)
    assert kinds_at(driver, "quarry-1") == ["rock"] * 11
    assert kinds_at(driver, "warehouse") == ["ammo-box"] * 11
    assert kinds_at(driver, "depot") == ["fuel-drum"] * 11
    rocks = [i for i in driver.world.state.items.values() if i.kind == "rock"]
    assert {i.color for i in rocks} == {"red"}


def test_nothing_is_produced_where_an_option_says_so() -> None:
    driver = Driver()
    driver.world.advance(10_000)
    assert driver.world.state.items == {}


def test_a_depot_removes_empty_drums_but_none_on_the_truck() -> None:
    driver = Driver(
        [thing("fuel-drum", "zone-1"), thing("fuel-drum")], depot_interval=5
    )
    driver.do("arm-move arm1 external", "arm-move arm1 fuel-drum-2")
    driver.do("arm-grasp arm1 fuel-drum-2", "arm-pour arm1 fuel-drum-2")
    driver.world.advance(100)
    assert driver.place("fuel-drum-2") == "arm1"
    assert driver.place("fuel-drum-1") == "zone-1"
    driver.do("arm-ungrasp arm1 fuel-drum-2")
    driver.world.advance(200)
    assert "fuel-drum-2" not in driver.world.state.items


def deliver(driver: Driver) -> None:
    """Take rock-1 from outside `factory-1` to its yard."""
    driver.do("arm-move arm1 external", "arm-ungrasp arm1 rock-1")


def test_a_rock_put_down_at_a_factory_is_logged_each_time() -> None:
    driver = Driver([rock("factory-1")], start="factory-1")
    driver.do(*LOAD, "arm-ungrasp arm1 rock-1", "arm-grasp arm1 rock-1")
    assert [d.item for d in driver.world.deliveries] == ["rock-1"]
    assert driver.world.deliveries[0].time == 5
    assert driver.world.deliveries[0].color == "red"
    assert driver.world.deliveries[0].factory == "factory-1"
    driver.do("arm-ungrasp arm1 rock-1")
    assert [d.item for d in driver.world.deliveries] == ["rock-1", "rock-1"]


def test_other_things_and_other_places_are_no_deliveries() -> None:
    driver = Driver([rock(), thing("fuel-drum")])
    driver.do(*LOAD, "arm-ungrasp arm1 rock-1")
    assert driver.world.deliveries == ()


def test_a_factory_takes_rocks_in_out_of_sight_and_reach() -> None:
    driver = Driver([rock("factory-1")], start="factory-1", factory_interval=20)
    driver.do("eye-scan external", *LOAD, "arm-ungrasp arm1 rock-1")
    driver.world.advance(50)
    assert driver.data("eye-scan external") == (("road-seen", "east", "road-3"),)
    assert driver.do("arm-grasp arm1 rock-1") == "arm-not-at"
    assert driver.do("arm-move arm1 rock-1") == "arm-cant-find"


def test_a_factory_may_consume_rocks_as_they_arrive() -> None:
    order = Text('[[0, "red", 1, "factory-1"]]')
    rocks = [rock("factory-1")]
    driver = Driver(rocks, start="factory-1", factory_interval=0, orders=order)
    driver.do("eye-scan external", *LOAD)
    assert driver.do("arm-move arm1 external", "arm-ungrasp arm1 rock-1") == "okay"
    assert "rock-1" not in driver.world.state.items
    assert driver.world.state.truck.arms["arm1"].at is None
    assert driver.world.orders[0].filled == driver.world.deliveries[0].time
    assert driver.data("eye-scan external") == (("road-seen", "east", "road-3"),)


def test_an_order_counts_each_rock_once_and_from_its_time_on() -> None:
    orders = Text('[[0, "red", 1, "factory-1"], [0, "red", 2, "factory-1"]]')
    driver = Driver([rock("factory-1", count=3)], start="factory-1", orders=orders)
    for rocks in ("rock-1", "rock-1", "rock-2"):
        driver.do("arm-move arm1 external", f"arm-move arm1 {rocks}")
        driver.do(f"arm-grasp arm1 {rocks}", f"arm-ungrasp arm1 {rocks}")
    first, second = driver.world.orders
    assert (first.received, first.filled) == (1, driver.world.deliveries[0].time)
    assert (second.received, second.filled) == (1, None)
    driver.do(
        "arm-move arm1 rock-3", "arm-grasp arm1 rock-3", "arm-ungrasp arm1 rock-3"
    )
    assert driver.world.orders[1].filled == driver.world.now()


def test_orders_of_another_colour_or_of_later_get_nothing() -> None:
    orders = Text('[[0, "blue", 1, "factory-1"], [500, "red", 1, "factory-1"]]')
    driver = Driver([rock("factory-1")], start="factory-1", orders=orders)
    driver.do(*LOAD, "arm-ungrasp arm1 rock-1")
    assert [order.received for order in driver.world.orders] == [0, 0]


def test_time_of_a_primitive_is_time_in_the_world() -> None:
    driver = Driver(quarry_interval=10)
    assert driver.drive("north", "east") == "okay"
    assert len(driver.data("eye-scan external")) > 2


def test_the_first_messages_are_the_trucks_own_gauges() -> None:
    world = TruckWorld(random.Random(0), {"fuel": 20})
    assert world.next_time() == 0
    assert world.messages() == (
        Datum(("new-location", "depot")),
        Datum(("heading", "north")),
        Datum(("speed", "medium")),
        Datum(("fuel-level", 20)),
        Datum(("clock", 0)),
    )
    assert world.messages() == ()
    assert world.next_time() is None


def test_facts_give_the_map_and_no_items() -> None:
    facts = list(TruckWorld(random.Random(0), {}).facts())
    assert ("place", "quarry-2", "quarry") in facts
    assert ("quarry-color", "quarry-2", "blue") in facts
    assert ("road", "road-6", "quarry-2", "west", "zone-4") in facts
    assert ("road", "road-6", "road-6", "east", "quarry-2") in facts
    assert ("opposite", "northwest", "southeast") in facts
    assert ("arm-place", "arm2", "folded") in facts
    words = {str(part) for fact in facts for part in fact}
    assert not [word for word in words if word.startswith(("rock-", "gun-"))]
