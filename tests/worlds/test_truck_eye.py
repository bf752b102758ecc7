"""The eye of the truck: what it sees, and what it cannot find (T B.1, B.2)."""

from __future__ import annotations

import pytest

from .drive import Driver, rock, thing


def test_a_scan_outside_sees_items_and_roads() -> None:
    driver = Driver([rock(), thing("gun"), rock("zone-1")])
    assert driver.data("eye-scan external") == (
        ("object-seen", "external", "rock-1", "rock"),
        ("object-seen", "external", "gun-1", "gun"),
        ("road-seen", "north", "road-1"),
    )


def test_scan_of_an_arm_or_bay_sees_its_contents() -> None:
    driver = Driver([rock(count=2)])
    driver.do("arm-move arm1 external", "arm-move arm1 rock-1", "arm-grasp arm1 rock-1")
    assert driver.data("eye-scan arm1") == (("object-seen", "arm1", "rock-1", "rock"),)
    driver.do("arm-move arm1 bay1", "arm-ungrasp arm1 rock-1")
    assert driver.data("eye-scan arm1") == ()
    assert driver.data("eye-scan bay1") == (("object-seen", "bay1", "rock-1", "rock"),)


@pytest.mark.parametrize("place", ["zone-1", "folded", "rock-1", "nowhere"])
def test_a_place_out_of_sight_cannot_be_scanned(place: str) -> None:
    assert Driver([rock()]).do(f"eye-scan {place}") == "eye-cant-find"


def test_examining_reports_visible_properties_of_each_kind() -> None:
    kinds = ("fuel-drum", "ammo-box", "gun", "gun-tool")
    driver = Driver([rock(color="blue"), *(thing(kind) for kind in kinds)])
    assert driver.data("eye-examine external rock-1") == (
        ("size", "rock-1", 7),
        ("color", "rock-1", "blue"),
    )
    assert driver.data("eye-examine depot fuel-drum-1") == (
        ("vessel", "fuel-drum-1", "fuel", 5),
        ("capacity", "fuel-drum-1", 5),
    )
    assert driver.data("eye-examine external ammo-box-1") == (
        ("vessel", "ammo-box-1", "ammo", 15),
        ("capacity", "ammo-box-1", 15),
    )
    assert driver.data("eye-examine external gun-1") == (("shots-left", "gun-1", 15),)
    assert driver.data("eye-examine external gun-tool-1") == ()


def test_an_item_is_not_found_at_another_place_than_its_own() -> None:
    driver = Driver([rock(), rock("zone-1")])
    assert driver.do("eye-examine bay1 rock-1") == "eye-cant-find"
    assert driver.do("eye-examine external rock-2") == "eye-cant-find"
    assert driver.do("eye-examine zone-1 rock-2") == "eye-cant-find"


def test_later_scan_reports_missing_items() -> None:
    drum = thing("fuel-drum")
    driver = Driver([drum, rock()], depot_interval=10)
    driver.do("eye-scan external")
    driver.do("arm-move arm1 external", "arm-move arm1 fuel-drum-1")
    driver.do("arm-grasp arm1 fuel-drum-1", "arm-pour arm1 fuel-drum-1")
    driver.do("arm-ungrasp arm1 fuel-drum-1")
    driver.world.advance(driver.world.now() + 20)  # the depot removes empty drums
    assert driver.data("eye-scan external")[0] == (
        "object-gone",
        "external",
        "fuel-drum-1",
    )
    assert driver.do("arm-grasp arm1 fuel-drum-1") == "arm-not-at"
    assert all(d[0] != "object-gone" for d in driver.data("eye-scan external"))


def test_a_drum_the_truck_took_itself_is_not_reported_gone() -> None:
    driver = Driver([rock()])
    driver.do("eye-scan external", "arm-move arm1 external", "arm-move arm1 rock-1")
    driver.do("arm-grasp arm1 rock-1")
    assert driver.data("eye-scan external") == (("road-seen", "north", "road-1"),)


def test_eye_reports_the_monitored_class() -> None:
    driver = Driver([rock("zone-1")], quarry_interval=0)
    assert driver.data("eye-monitor rock") == ()
    driver.do("truck-turn north")
    assert driver.data("truck-move")[-1] == (
        "object-seen",
        "external",
        "rock-1",
        "rock",
    )
    assert driver.data("truck-turn east") == (("heading", "east"),)
    driver.do("eye-unmonitor rock")
    assert driver.world.state.monitored == []


def test_truck_stops_on_the_road_at_the_monitored_class() -> None:
    driver = Driver([rock("road-1")], fuel_spread=0, time_spread=0)
    driver.do("eye-monitor rock")
    driver.do("truck-turn north")
    data = driver.data("truck-move")
    assert data == (
        ("new-location", "road-1"),
        ("fuel-level", 29.5),
        ("object-seen", "external", "rock-1", "rock"),
    )
    seen = driver.data("eye-scan external")
    assert ("road-seen", "south", "road-1") in seen
    assert driver.data("truck-move")[:2] == (
        ("new-location", "zone-1"),
        ("fuel-level", 29),
    )


def test_without_looking_out_the_truck_passes_by() -> None:
    driver = Driver([rock("road-1")])
    driver.do("truck-turn north")
    assert driver.data("truck-move")[0] == ("new-location", "zone-1")


def test_temporary_names_change_with_each_visit() -> None:
    driver = Driver([rock(), thing("gun")], lasting_names=False)
    assert driver.data("eye-scan external")[:2] == (
        ("object-seen", "external", "rock-s1", "rock"),
        ("object-seen", "external", "gun-1", "gun"),
    )
    assert (
        driver.do("arm-move arm1 external", "arm-move arm1 rock-1") == "arm-cant-find"
    )
    assert driver.do("arm-move arm1 rock-s1", "arm-move arm1 folded") == "okay"
    assert driver.drive("north", "south") == "okay"
    assert driver.do("eye-examine external rock-s1") == "eye-cant-find"
    assert ("object-seen", "external", "rock-s2", "rock") in driver.data(
        "eye-scan external"
    )
    assert driver.do("eye-examine external rock-s2") == "okay"
