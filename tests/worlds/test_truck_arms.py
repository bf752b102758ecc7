"""The arms of the truck: what each primitive does, and each way it can fail (T B.1)."""

from __future__ import annotations

import pytest

from .drive import Driver, rock, thing

PICK_ONE = ("arm-move arm1 external", "arm-move arm1 rock-1", "arm-grasp arm1 rock-1")
TO_BAY = ("arm-move arm1 bay2", "arm-ungrasp arm1 rock-1")
TOOL_IN_ARM2 = (
    "arm-move arm2 external",
    "arm-move arm2 gun-tool-1",
    "arm-grasp arm2 gun-tool-1",
)


def test_a_rock_goes_from_the_ground_into_a_bay() -> None:
    driver = Driver([rock()])
    assert driver.do(*PICK_ONE) == "okay"
    assert driver.place("rock-1") == "arm1"
    assert driver.do(*TO_BAY) == "okay"
    assert driver.place("rock-1") == "bay2"


@pytest.mark.parametrize("place", ["nowhere", "arm2", "arm1", "zone-1", "rock-9"])
def test_arm_does_not_find_a_foreign_place(place: str) -> None:
    assert Driver([rock()]).do(f"arm-move arm1 {place}") == "arm-cant-find"


def test_an_arm_finds_only_items_where_it_is() -> None:
    driver = Driver([rock(), rock("zone-1")])
    assert driver.do("arm-move arm1 rock-1") == "arm-cant-find"  # folded
    assert driver.do("arm-move arm1 bay1", "arm-move arm1 rock-1") == "arm-cant-find"
    assert driver.do("arm-move arm1 external", "arm-move arm1 rock-1") == "okay"
    assert driver.do("arm-move arm1 rock-2") == "arm-cant-find"  # elsewhere


def test_the_name_of_the_place_means_outside() -> None:
    assert Driver([rock()]).do("arm-move arm1 depot", "arm-move arm1 rock-1") == "okay"


def test_unknown_arm_fails() -> None:
    driver = Driver([rock(), thing("fuel-drum")])
    assert driver.do("arm-move arm3 external") == "arm-cant-find"
    assert driver.do("arm-grasp arm3 rock-1") == "arm-not-at"
    assert driver.do("arm-ungrasp arm3 rock-1") == "arm-not-holding"
    assert driver.do("arm-pour depot fuel-drum-1") == "arm-not-holding"
    assert driver.do("arm-examine depot rock-1") == "arm-not-at"


def test_grasping_needs_an_arm_at_the_item() -> None:
    driver = Driver([rock(count=2)])
    assert driver.do("arm-move arm1 external", "arm-grasp arm1 rock-1") == "arm-not-at"
    assert driver.do("arm-move arm1 rock-2", "arm-grasp arm1 rock-1") == "arm-not-at"


def test_both_arms_at_an_item_are_in_each_others_way() -> None:
    driver = Driver([rock()])
    driver.do(*PICK_ONE[:2])
    driver.do("arm-move arm2 external", "arm-move arm2 rock-1")
    assert driver.do("arm-grasp arm1 rock-1") == "arm-interference"
    assert driver.do("arm-grasp arm2 rock-1") == "arm-interference"
    assert driver.do("arm-move arm2 folded", "arm-grasp arm1 rock-1") == "okay"


def test_arm_stays_at_the_item_it_put_down() -> None:
    driver = Driver([rock()])
    driver.do(*PICK_ONE, *TO_BAY)
    driver.do("arm-move arm2 bay2", "arm-move arm2 rock-1")
    assert driver.do("arm-grasp arm2 rock-1") == "arm-interference"


def test_arm1_holds_one_rock_and_arm2_two() -> None:
    driver = Driver([rock(count=3)])
    driver.do("arm-move arm1 external", "arm-move arm2 external")
    assert driver.do("arm-move arm1 rock-1", "arm-grasp arm1 rock-1") == "okay"
    assert driver.do("arm-move arm1 rock-2", "arm-grasp arm1 rock-2") == "arm-too-full"
    driver.do("arm-move arm1 external")
    assert driver.do("arm-move arm2 rock-2", "arm-grasp arm2 rock-2") == "okay"
    assert driver.do("arm-move arm2 rock-3", "arm-grasp arm2 rock-3") == "okay"


def test_a_gun_wants_the_tool_in_a_strong_enough_arm() -> None:
    driver = Driver([thing("gun"), thing("gun-tool")])
    driver.do("arm-move arm1 external", "arm-move arm1 gun-1")
    assert driver.do("arm-grasp arm1 gun-1") == "arm-cant-grasp"
    driver.do("arm-move arm1 gun-tool-1", "arm-grasp arm1 gun-tool-1")
    driver.do("arm-move arm1 gun-1")
    assert driver.do("arm-grasp arm1 gun-1") == "arm-too-full"
    driver.do("arm-move arm1 bay1", "arm-ungrasp arm1 gun-tool-1")
    driver.do("arm-move arm1 folded", "arm-move arm2 bay1")
    driver.do("arm-move arm2 gun-tool-1", "arm-grasp arm2 gun-tool-1")
    driver.do("arm-move arm2 external", "arm-move arm2 gun-1")
    assert driver.do("arm-grasp arm2 gun-1") == "okay"
    assert driver.do("arm-move arm2 weapon-bay", "arm-ungrasp arm2 gun-1") == "okay"
    assert driver.place("gun-1") == "weapon-bay"


def test_a_dropped_item_stays_where_it_is_and_the_arm_at_it() -> None:
    driver = Driver([rock()], arm1_drops=100)
    assert driver.do(*PICK_ONE) == "arm-dropped"
    assert driver.place("rock-1") == "depot"
    assert driver.do("arm-grasp arm1 rock-1") == "arm-dropped"


@pytest.mark.parametrize(("arm", "per_cent"), [("arm1", 15), ("arm2", 50)])
def test_arms_drop_as_often_as_the_thesis_says(arm: str, per_cent: int) -> None:
    driver = Driver([rock()], arm1_drops=15, arm2_drops=50)
    driver.do(f"arm-move {arm} external")
    drops = 0
    for _ in range(1000):
        driver.do(f"arm-move {arm} rock-1")
        if driver.do(f"arm-grasp {arm} rock-1") == "arm-dropped":
            drops += 1
        else:
            driver.do(f"arm-ungrasp {arm} rock-1")
    assert abs(drops / 10 - per_cent) < 5


def test_putting_down_requires_the_item_in_the_arm() -> None:
    driver = Driver([rock()])
    assert driver.do("arm-ungrasp arm1 rock-1") == "arm-not-holding"
    driver.do(*PICK_ONE)
    assert driver.do("arm-ungrasp arm2 rock-1") == "arm-not-holding"


def test_places_on_the_truck_fill_up() -> None:
    driver = Driver([rock(count=3)])
    for number in (1, 2, 3):
        driver.do("arm-move arm1 external", f"arm-move arm1 rock-{number}")
        driver.do(f"arm-grasp arm1 rock-{number}", "arm-move arm1 bay1")
        result = driver.do(f"arm-ungrasp arm1 rock-{number}")
        assert result == ("container-full" if number == 3 else "okay")
    assert driver.place("rock-3") == "arm1"


@pytest.mark.parametrize("place", ["folded", "fuel-bay", "weapon-bay"])
def test_a_rock_has_no_business_in_some_places(place: str) -> None:
    driver = Driver([rock()])
    driver.do(*PICK_ONE, f"arm-move arm1 {place}")
    assert driver.do("arm-ungrasp arm1 rock-1") == "container-full"


def test_a_drum_poured_into_the_fuel_bay_fills_it() -> None:
    driver = Driver([thing("fuel-drum")], fuel=27)
    driver.do("arm-move arm1 external", "arm-move arm1 fuel-drum-1")
    driver.do("arm-grasp arm1 fuel-drum-1", "arm-move arm1 fuel-bay")
    assert driver.data("arm-pour arm1 fuel-drum-1") == (("fuel-level", 30),)
    assert driver.world.state.items["fuel-drum-1"].amount == 2


def test_liquid_without_a_vessel_is_spilt() -> None:
    driver = Driver([thing("fuel-drum"), thing("gun")])
    driver.do("arm-move arm1 external", "arm-move arm1 fuel-drum-1")
    driver.do("arm-grasp arm1 fuel-drum-1", "arm-move arm1 gun-1")
    assert driver.do("arm-pour arm1 fuel-drum-1") == "okay"
    assert driver.world.state.items["fuel-drum-1"].amount == 0
    assert driver.world.state.items["gun-1"].amount == 15


def test_pouring_needs_a_vessel_in_the_arm() -> None:
    driver = Driver([rock(), thing("fuel-drum")])
    driver.do(*PICK_ONE)
    assert driver.do("arm-pour arm1 fuel-drum-1") == "arm-not-holding"
    assert driver.do("arm-pour arm1 rock-1") == "arm-not-holding"
    assert driver.do("arm-ladle arm1 rock-1") == "arm-not-holding"


def mounted(driver: Driver) -> Driver:
    """The gun in the weapon bay, and arm2 at it."""
    driver.do(*TOOL_IN_ARM2, "arm-move arm2 gun-1")
    assert driver.do("arm-toggle arm2 gun-1") == "arm-cant-toggle"  # not mounted
    driver.do("arm-grasp arm2 gun-1", "arm-move arm2 weapon-bay")
    driver.do("arm-ungrasp arm2 gun-1")
    return driver


def test_a_mounted_gun_fires_three_rounds_a_time_and_is_refilled() -> None:
    armed = [thing("gun"), thing("gun-tool"), thing("ammo-box")]
    driver = mounted(Driver([*armed, thing("enemy-unit", count=20)], gun_hits=0))
    for left in (12, 9, 6, 3, 0, 0):
        assert driver.do("arm-toggle arm2 gun-1") == "okay"
        assert driver.data("arm-examine arm2 gun-1")[0] == ("shots-left", "gun-1", left)
    driver.do("arm-move arm1 external", "arm-move arm1 ammo-box-1")
    driver.do("arm-grasp arm1 ammo-box-1", "arm-move arm1 weapon-bay")
    driver.do("arm-move arm1 gun-1", "arm-pour arm1 ammo-box-1")
    assert driver.world.state.items["gun-1"].amount == 15
    assert driver.world.state.items["ammo-box-1"].amount == 0


def test_toggling_needs_an_arm_at_something_active() -> None:
    driver = Driver([rock()])
    assert driver.do("arm-toggle arm1 rock-1") == "arm-not-at"
    driver.do(*PICK_ONE[:2])
    assert driver.do("arm-toggle arm1 rock-1") == "arm-cant-toggle"


def test_ladling_fills_an_empty_drum_from_another_and_from_the_fuel_bay() -> None:
    driver = Driver([thing("fuel-drum", count=2), thing("ammo-box")])
    driver.do("arm-move arm1 external", "arm-move arm1 fuel-drum-1")
    driver.do("arm-grasp arm1 fuel-drum-1", "arm-pour arm1 fuel-drum-1")
    assert driver.do("arm-ladle arm1 fuel-drum-1") == "arm-not-at"
    driver.do("arm-move arm1 fuel-drum-2")
    assert driver.do("arm-ladle arm1 fuel-drum-1") == "okay"
    items = driver.world.state.items
    assert (items["fuel-drum-1"].amount, items["fuel-drum-2"].amount) == (5, 0)
    assert driver.do("arm-ladle arm1 fuel-drum-1") == "arm-not-at"  # source is empty
    driver.do("arm-move arm1 ammo-box-1")
    assert driver.do("arm-ladle arm1 fuel-drum-1") == "arm-not-at"  # would not mix
    driver.do("arm-pour arm1 fuel-drum-1", "arm-move arm1 fuel-bay")
    assert driver.data("arm-ladle arm1 fuel-drum-1") == (("fuel-level", 25),)


def test_arm_examines_the_item_at_it_or_in_it() -> None:
    driver = Driver([rock(), thing("fuel-drum")])
    assert driver.do("arm-examine arm1 rock-1") == "arm-not-at"
    driver.do("arm-move arm1 external", "arm-move arm1 fuel-drum-1")
    felt = (
        ("vessel", "fuel-drum-1", "fuel", 5),
        ("capacity", "fuel-drum-1", 5),
        ("size", "fuel-drum-1", 5),
    )
    assert driver.data("arm-examine arm1 fuel-drum-1") == felt
    driver.do("arm-grasp arm1 fuel-drum-1")
    assert driver.data("arm-examine arm1 fuel-drum-1") == felt


def test_item_out_of_reach_cannot_be_handled() -> None:
    driver = Driver([rock()])
    driver.do(*PICK_ONE, "arm-ungrasp arm1 rock-1", "arm-move arm1 folded")
    assert driver.drive("north") == "okay"
    assert (
        driver.do("arm-move arm1 external", "arm-move arm1 rock-1") == "arm-cant-find"
    )
    assert driver.do("arm-grasp arm1 rock-1") == "arm-not-at"
    assert driver.do("eye-examine external rock-1") == "eye-cant-find"
