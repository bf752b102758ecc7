"""Enemy troops and the gun: coming, going, being shot, capturing (T 6.1.1, B.2)."""

from __future__ import annotations

import json
import random
from typing import Any

import pytest

from rapc.base.values import Text
from rapc.worlds.truck import TruckWorld

from .drive import Driver, map_text, rock, thing

SECTORS = [
    {"name": "west", "spots": ["factory-1", "warehouse", "road-3"]},
    {"name": "middle", "spots": ["zone-1", "depot"]},
]


def enemies(driver: Driver) -> list[str]:
    """The places of all enemy units."""
    items = driver.world.state.items.values()
    return [item.place for item in items if item.kind == "enemy-unit"]


def with_sectors(start: str = "depot") -> Text:
    """The small map, divided into sectors."""
    return Text(json.dumps({**json.loads(map_text((), start)), "sectors": SECTORS}))


def armed(enemies: int, **options: Any) -> Driver:
    """A gun in the weapon bay, arm2 at it, and enemies outside."""
    lying = [thing("gun"), thing("gun-tool"), thing("enemy-unit", count=enemies)]
    driver = Driver(lying, **options)
    driver.do("arm-move arm2 external", "arm-move arm2 gun-tool-1")
    driver.do("arm-grasp arm2 gun-tool-1", "arm-move arm2 gun-1")
    driver.do("arm-grasp arm2 gun-1", "arm-move arm2 weapon-bay")
    driver.do("arm-ungrasp arm2 gun-1")
    return driver


def test_enemies_come_to_zones_alone_and_move_on() -> None:
    driver = Driver(enemy_interval=100, enemy_stay=60, enemy_units=4)
    bands = set()
    for time in range(0, 4000, 10):
        driver.world.advance(time)
        assert set(enemies(driver)) <= {"zone-1"}
        bands.add(len(enemies(driver)))
    assert bands == {0, 1, 2, 3, 4}


def test_enemies_come_to_the_sectors_named_but_not_to_warehouse_or_depot() -> None:
    seen = set()
    names = Text("west, middle")
    driver = Driver(map=with_sectors(), enemy_interval=20, enemy_sectors=names)
    for time in range(0, 2000, 10):
        driver.world.advance(time)
        seen.update(enemies(driver))
    assert seen == {"factory-1", "zone-1"}


def test_unknown_sector_is_refused() -> None:
    with pytest.raises(ValueError, match="no sector `wets`; did you mean `west`"):
        Driver(map=with_sectors(), enemy_sectors=Text("wets"))


def test_enemies_are_seen_like_anything_and_noticed_when_looked_out_for() -> None:
    driver = Driver([thing("enemy-unit", "zone-1")])
    assert driver.data("eye-monitor enemy-unit") == ()
    driver.do("truck-turn north")
    seen = ("object-seen", "external", "enemy-unit-1", "enemy-unit")
    assert driver.data("truck-move")[-1] == seen
    assert driver.data("eye-scan external")[0] == seen
    assert driver.data("eye-examine external enemy-unit-1") == ()


def test_no_arm_can_lift_an_enemy() -> None:
    driver = Driver([thing("enemy-unit")])
    driver.do("arm-move arm2 external", "arm-move arm2 enemy-unit-1")
    assert driver.do("arm-grasp arm2 enemy-unit-1") == "arm-too-full"


def test_enemies_stay_while_the_truck_does_and_are_gone_when_it_comes_back() -> None:
    driver = Driver(
        start="zone-1",
        enemy_interval=50,
        enemy_stay=5,
        capture_time=0,
        factory_interval=0,
    )
    while not enemies(driver):
        driver.world.advance(driver.world.now() + 1)
    found = len(enemies(driver))
    driver.world.advance(driver.world.now() + 20)
    assert len(enemies(driver)) >= found
    assert driver.drive("south") == "okay"
    driver.world.advance(driver.world.now() + 1)
    assert enemies(driver) == []


def test_a_burst_fires_at_enemies_until_none_are_left() -> None:
    driver = armed(2, gun_hits=100)
    assert driver.do("arm-toggle arm2 gun-1") == "okay"
    assert enemies(driver) == []
    assert driver.data("arm-examine arm2 gun-1")[0] == ("shots-left", "gun-1", 13)
    assert driver.do("arm-toggle arm2 gun-1") == "okay"
    assert driver.data("arm-examine arm2 gun-1")[0] == ("shots-left", "gun-1", 13)


def test_six_rounds_in_ten_hit() -> None:
    hits = 0
    for seed in range(60):
        driver = armed(20, seed=seed)
        for _ in range(6):
            driver.do("arm-toggle arm2 gun-1")
        assert driver.world.state.items["gun-1"].amount == 0
        hits += 20 - len(enemies(driver))
    assert 0.55 <= hits / (60 * 15) <= 0.65


def test_next_scan_omits_destroyed_enemies() -> None:
    driver = armed(1, gun_hits=100)
    driver.do("eye-scan external", "arm-toggle arm2 gun-1")
    assert driver.data("eye-scan external")[0] == (
        "object-gone",
        "external",
        "enemy-unit-1",
    )


def test_a_gun_starts_with_the_rounds_it_was_given() -> None:
    driver = Driver([thing("gun")], gun_rounds=4)
    assert driver.data("eye-examine external gun-1") == (("shots-left", "gun-1", 4),)


def captured(after: float, runs: int = 400) -> float:
    """The share of trucks captured by a time with enemies."""
    caught = 0
    for seed in range(runs):
        driver = Driver([thing("enemy-unit")], seed=seed, capture_time=100)
        driver.world.advance(after)
        caught += driver.world.ended() is not None
    return caught / runs


def test_capture_gets_likelier_with_time() -> None:
    assert 0.01 <= captured(25) <= 0.09
    assert 0.42 <= captured(100) <= 0.58
    assert captured(400) >= 0.99


def test_a_captured_truck_goes_nowhere() -> None:
    driver = Driver([thing("enemy-unit")], capture_time=0.01)
    driver.do("truck-turn north")
    assert driver.world.ended() == "captured at depot"
    assert driver.do("truck-move") == "truck-mishap"
    assert driver.world.state.truck.place == "depot"


def test_driving_off_or_shooting_all_prevents_capture() -> None:
    for seed in range(30):
        driver = Driver([thing("enemy-unit")], seed=seed, capture_time=60)
        driver.drive("north")
        fighter = armed(1, seed=seed, gun_hits=100, capture_time=300)
        fighter.do("arm-toggle arm2 gun-1")
        for each in (driver, fighter):
            safe = each.world.ended() is None
            each.world.advance(10_000)
            assert safe == (each.world.ended() is None)


def test_the_world_notes_how_each_encounter_ended() -> None:
    leaver = Driver([thing("enemy-unit", count=2)])
    leaver.world.advance(5)
    leaver.drive("north")
    fighter = armed(1, gun_hits=100, capture_time=0)
    fighter.do("arm-toggle arm2 gun-1")
    victim = Driver([thing("enemy-unit")], capture_time=0.01)
    victim.world.advance(9)
    for driver, how in ((leaver, "left"), (fighter, "shot"), (victim, "captured")):
        [met] = driver.world.encounters
        assert (met.time, met.place, met.how) == (0, "depot", how)
    assert [e.units for d in (leaver, fighter) for e in d.world.encounters] == [2, 1]
    assert fighter.world.encounters[0].until == fighter.world.now()
    assert Driver().world.encounters == ()


def test_switching_enemies_on_leaves_the_rest_of_the_luck_as_it_was() -> None:
    walks = []
    for interval in (0, 30):
        options = {"enemy-interval": interval, "capture-time": 0}
        world = TruckWorld(random.Random(4), options)
        for turn in ("northwest", "north", "north", "northeast"):
            world.perform(0, ("truck-turn", turn))
            world.perform(0, ("truck-move",))
        items = world.state.items.values()
        rest = [item for item in items if item.kind != "enemy-unit"]
        walks.append((world.now(), world.state.truck.fuel, rest))
    assert walks[0] == walks[1]


def test_enemies_do_not_keep_a_quarry_from_working() -> None:
    driver = Driver(
        [thing("enemy-unit", "quarry-1", count=10), rock()],
        quarry_interval=10,
        capture_time=0,
    )
    driver.world.advance(100)
    kinds = [i.kind for i in driver.world.state.items.values() if i.place == "quarry-1"]
    assert kinds.count("rock") >= 5


def test_enemies_bar_roads_where_they_may_come_to_them() -> None:
    driver = Driver(enemy_interval=20, road_troops=True)
    seen = set()
    for time in range(0, 2000, 10):
        driver.world.advance(time)
        seen.update(enemies(driver))
    roads = {road["name"] for road in json.loads(map_text())["roads"]}
    assert seen == {"zone-1", *roads}


def test_a_truck_stops_half_way_where_they_are_and_can_leave() -> None:
    driver = Driver([thing("enemy-unit", "road-1")], enemy_interval=0)
    assert driver.drive("north") == "okay"
    assert driver.world.state.truck.place == "road-1"
    [met] = driver.world.encounters
    assert (met.place, met.how) == ("road-1", None)
    assert driver.drive("north") == "okay"
    assert driver.world.state.truck.place == "zone-1"
    assert [met.how for met in driver.world.encounters] == ["left"]


def test_no_enemies_come_to_the_road_of_the_truck() -> None:
    driver = Driver(map=with_sectors(), enemy_interval=1, road_troops=True)
    for _ in range(40):
        driver.drive("north")
        driver.drive("south")
        log = driver.world.encounters
        assert all(met.until is not None for met in log[:-1])
