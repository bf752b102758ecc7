"""Rain and darkness over sectors, and what they do to roads and eye (T 1.4.2)."""

from __future__ import annotations

import json
from typing import Any

import pytest

from rapc.base.values import Text

from .drive import Driver, map_text, rock

STEADY = {"time_spread": 0, "fuel_spread": 0}


def land(items: Any = (), dark: bool = False, **road: Any) -> Text:
    """The small map with one sector about the depot and the road out of it."""
    sector = {"name": "south", "spots": ["depot", "road-1"], "dark": dark}
    ground = {**json.loads(map_text(items, **road)), "sectors": [sector]}
    return Text(json.dumps(ground))


def items_seen(driver: Driver) -> set[Any]:
    """The items that a scan outside reports."""
    data = driver.data("eye-scan external")
    return {datum for datum in data if datum[0] == "object-seen"}


def trip(**options: Any) -> tuple[float, float]:
    """The time and fuel that the first trip takes."""
    driver = Driver(**{"map": land(), **STEADY, **options})
    assert driver.drive("north") == "okay"
    return driver.world.now() - 2, round(30 - driver.world.state.truck.fuel, 2)


def test_in_fair_weather_and_daylight_roads_are_as_the_map_has_them() -> None:
    assert trip() == (30, 1)
    assert trip(day_length=100) == (30, 1)


def test_rain_makes_trips_longer_and_thirstier() -> None:
    assert trip(rain=100) == (37.5, 1.1)
    assert trip(rain=100, rain_time=2, rain_fuel=3) == (60, 3)


def test_outside_the_sectors_it_never_rains() -> None:
    assert trip(rain=100, map=Text(map_text())) == (30, 1)


def test_it_rains_so_much_of_the_time() -> None:
    driver = Driver(map=land(), rain=30, weather_interval=50)
    wet = 0
    for time in range(1000, 41_000, 20):
        driver.world.advance(time)
        wet += driver.world.state.raining == ["south"]
    assert 0.25 <= wet / 2000 <= 0.35


def test_a_muddy_road_is_the_end_of_trips_in_the_rain_alone() -> None:
    muddy = land(mud=1)
    assert trip(map=muddy) == (30, 1)
    driver = Driver(map=muddy, rain=100)
    assert driver.drive("north") == "truck-mishap"
    assert driver.world.ended() == "mishap on road-1"


def test_weather_needs_time_to_change() -> None:
    with pytest.raises(ValueError, match="`weather-interval` must be at least 1"):
        Driver(rain=50, weather_interval=0)


def test_trips_in_the_dark_take_longer() -> None:
    assert trip(map=land(dark=True)) == (36, 1)
    assert trip(day_length=10, night=100, dark_time=3) == (90, 1)
    assert trip(rain=100, map=land(dark=True)) == (45, 1.1)


def test_night_falls_at_the_end_of_each_day() -> None:
    seen = {}
    for time in (50, 59, 60, 97, 100, 160):
        fresh = Driver([rock()], day_length=100, night=40, dark_misses=100)
        fresh.world.advance(time - 2)
        seen[time] = bool(items_seen(fresh))
    assert seen == {50: True, 59: True, 60: False, 97: False, 100: True, 160: False}


def test_eye_misses_things_in_the_dark_and_keeps_found_things() -> None:
    dark = land([rock(count=100)], dark=True)
    driver = Driver(map=dark)
    first = items_seen(driver)
    assert 50 <= len(first) <= 90
    assert first < items_seen(driver)
    assert "road-seen" in {datum[0] for datum in driver.data("eye-scan external")}


def test_the_dark_does_not_reach_inside_the_truck() -> None:
    driver = Driver(map=land([rock()], dark=True), dark_misses=100, lasting_names=True)
    driver.do("arm-move arm1 external", "arm-move arm1 rock-1", "arm-grasp arm1 rock-1")
    assert driver.data("eye-scan arm1") == (("object-seen", "arm1", "rock-1", "rock"),)


def test_a_look_outside_tells_of_the_weather_where_there_is_any() -> None:
    told = {"weather", "light"}
    fair = Driver(map=land())
    assert not {datum[0] for datum in fair.data("eye-scan external")} & told
    wet = Driver(map=land(), rain=100, day_length=100, night=100)
    seen = wet.data("eye-scan external")
    assert ("weather", "depot", "rain") in seen
    assert ("light", "depot", "night") in seen
    assert not {datum[0] for datum in wet.data("eye-scan bay1")} & told
    sombre = Driver(map=land(dark=True))
    assert ("light", "depot", "night") in sombre.data("eye-scan external")


def test_the_map_says_which_roads_are_dangerous() -> None:
    facts = list(Driver(map=land(mud=0.5, mishap=0.1)).world.facts())
    risks = {fact[2] for fact in facts if fact[:2] == ("road-risk", "road-1")}
    assert risks == {"speed", "mud"}
    plain = Driver(map=land()).world.facts()
    assert [fact for fact in plain if fact[0] == "road-risk"] == []
