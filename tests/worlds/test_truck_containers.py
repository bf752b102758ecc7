"""Containers: what is put in, taken out, seen inside, and goes with them (T 1.4.2)."""

from __future__ import annotations

import pytest

from .drive import Driver, rock, thing, workshop
from .robot import Robot, truck_words

PICK = ("arm-move arm1 external", "arm-move arm1 rock-1", "arm-grasp arm1 rock-1")
IN_CRATE = (*PICK, "arm-move arm1 crate-1", "arm-ungrasp arm1 rock-1")


def robot(driver: Driver) -> Robot:
    """A memory beside a driver's world."""
    return Robot(driver.world, truck_words())


def test_an_arm_at_a_container_puts_things_into_it() -> None:
    driver = workshop(rock(), thing("crate"))
    driver.do(*PICK, "arm-move arm1 crate-1")
    assert driver.data("arm-ungrasp arm1 rock-1") == (
        ("object-seen", "crate-1", "rock-1", "rock"),
    )
    assert driver.place("rock-1") == "crate-1"
    assert driver.data("eye-scan external")[:-1] == (
        ("object-seen", "external", "crate-1", "crate"),
    )
    assert driver.data("eye-scan crate-1") == (
        ("object-seen", "crate-1", "rock-1", "rock"),
    )


def test_contents_are_reached_only_through_the_container() -> None:
    driver = workshop(rock(), thing("crate"), thing("fuel-drum"))
    driver.do(*IN_CRATE, "arm-move arm1 folded", "arm-move arm1 external")
    assert driver.do("arm-move arm1 rock-1") == "arm-cant-find"
    assert driver.do("arm-move arm1 crate-1", "arm-move arm1 rock-1") == "okay"
    assert driver.do("arm-move arm1 fuel-drum-1") == "okay"  # out again
    driver.do("arm-move arm1 crate-1", "arm-move arm1 rock-1")
    assert driver.do("arm-grasp arm1 rock-1") == "okay"
    assert driver.world.state.truck.arms["arm1"].at == "crate-1"
    assert driver.do("arm-ungrasp arm1 rock-1") == "okay"
    assert driver.place("rock-1") == "crate-1"


def test_examining_goes_by_the_container_too() -> None:
    driver = workshop(thing("crate"), rock("crate-1", color="blue"))
    assert driver.do("eye-examine external rock-1") == "eye-cant-find"
    assert driver.data("eye-examine crate-1 rock-1")[-1] == ("color", "rock-1", "blue")
    assert driver.data("eye-examine external crate-1") == (("holds", "crate-1", 14),)
    assert driver.do("eye-scan rock-1") == "eye-cant-find"


def test_a_container_holds_so_much_and_no_more() -> None:
    driver = workshop(thing("crate"), rock("crate-1", count=1), rock(count=2))
    assert driver.place("rock-1") == "crate-1"
    for number, result in ((2, "okay"), (3, "container-full")):
        driver.do("arm-move arm1 external", f"arm-move arm1 rock-{number}")
        driver.do(f"arm-grasp arm1 rock-{number}", "arm-move arm1 crate-1")
        assert driver.do(f"arm-ungrasp arm1 rock-{number}") == result
    assert driver.place("rock-3") == "arm1"


def test_containers_lie_in_containers() -> None:
    driver = workshop(
        thing("crate"), thing("tool-box", "crate-1"), thing("gun-tool", "tool-box-1")
    )
    driver.do("arm-move arm1 external", "arm-move arm1 crate-1")
    assert driver.do("arm-move arm1 gun-tool-1") == "arm-cant-find"
    assert driver.do("arm-move arm1 tool-box-1", "arm-move arm1 gun-tool-1") == "okay"
    driver.do("arm-grasp arm1 gun-tool-1", "arm-move arm1 crate-1")
    assert driver.do("arm-ungrasp arm1 gun-tool-1") == "container-full"
    driver.do("arm-move arm1 tool-box-1", "arm-ungrasp arm1 gun-tool-1")
    assert driver.place("gun-tool-1") == "tool-box-1"


def test_contents_move_with_their_container() -> None:
    driver = workshop(thing("crate"), rock("crate-1"))
    driver.do(
        "arm-move arm2 external", "arm-move arm2 crate-1", "arm-grasp arm2 crate-1"
    )
    driver.do("arm-move arm2 bay2", "arm-ungrasp arm2 crate-1", "arm-move arm2 folded")
    assert driver.drive("north") == "okay"
    assert driver.data("eye-scan crate-1")[0][2] == "rock-1"
    driver.do("arm-move arm1 bay2", "arm-move arm1 crate-1", "arm-move arm1 rock-1")
    assert driver.do("arm-grasp arm1 rock-1") == "okay"


def test_abandoned_container_keeps_its_contents() -> None:
    driver = workshop(thing("crate"), rock("crate-1"))
    driver.drive("north")
    assert driver.do("eye-scan crate-1") == "eye-cant-find"
    assert driver.do("eye-examine crate-1 rock-1") == "eye-cant-find"
    driver.drive("south")
    assert driver.data("eye-scan crate-1")[0][2] == "rock-1"


def test_arm_in_a_container_blocks_its_lifting() -> None:
    driver = workshop(thing("crate"), rock("crate-1"))
    driver.do("arm-move arm1 external", "arm-move arm1 crate-1", "arm-move arm1 rock-1")
    driver.do("arm-move arm2 external", "arm-move arm2 crate-1")
    assert driver.do("arm-grasp arm2 crate-1") == "arm-interference"
    driver.do("arm-move arm1 folded")
    assert driver.do("arm-grasp arm2 crate-1") == "okay"


def test_shuffle_moves_containers_with_their_contents() -> None:
    driver = workshop(
        thing("crate"),
        rock("crate-1"),
        thing("tank"),
        shuffle_interval=10,
        shuffle_efficiency=100,
    )
    driver.do("arm-move arm1 external", "arm-move arm1 crate-1", "arm-move arm1 rock-1")
    driver.world.advance(10)
    assert driver.place("crate-1") != "depot"
    assert driver.place("rock-1") == "crate-1"
    assert driver.place("tank-1") == "depot"
    assert driver.world.state.truck.arms["arm1"].at is None


def test_rocks_in_a_crate_are_no_delivery() -> None:
    driver = workshop(
        rock("factory-1"),
        thing("crate", "factory-1"),
        start="factory-1",
        factory_interval=10,
    )
    driver.do(*IN_CRATE)
    driver.world.advance(50)
    assert driver.world.deliveries == ()
    assert driver.place("rock-1") == "crate-1"


def test_sensor_names_stand_for_containers_in_requests_and_data() -> None:
    driver = workshop(thing("crate"), rock("crate-1"), lasting_names=False)
    assert driver.data("eye-scan external")[0] == (
        "object-seen",
        "external",
        "crate-s1",
        "crate",
    )
    assert driver.data("eye-scan crate-s1") == (
        ("object-seen", "crate-s1", "rock-s2", "rock"),
    )
    driver.do("arm-move arm1 external", "arm-move arm1 crate-s1")
    driver.do("arm-move arm1 rock-s2", "arm-grasp arm1 rock-s2")
    driver.do("arm-move arm1 bay1", "arm-ungrasp arm1 rock-s2")
    assert driver.data("eye-scan crate-s1") == ()


def test_memory_has_things_in_the_container() -> None:
    one = robot(workshop(rock(), thing("crate")))
    one.do("eye-scan external", *IN_CRATE)
    assert one.where("rock-1") == "crate-1"
    assert one.knows("arm-at arm1 rock-1")
    one.do("eye-examine external crate-1", "arm-grasp arm1 rock-1")
    assert one.knows("holds crate-1 14")
    assert one.where("rock-1") == "arm1"
    assert one.knows("arm-at arm1 crate-1")
    one.do("arm-ungrasp arm1 rock-1", "eye-scan crate-1")
    assert one.where("rock-1") == "crate-1"
    assert one.knows("scanned-since-move crate-1")


@pytest.mark.parametrize("examined", [True, False])
def test_memory_knows_which_container_was_too_full(examined: bool) -> None:
    driver = workshop(thing("crate"), rock("crate-1", count=2), rock())
    one = robot(driver)
    one.do("eye-scan external", "eye-scan crate-1", "arm-move arm1 external")
    one.do("arm-move arm1 rock-3", "arm-grasp arm1 rock-3")
    if examined:
        one.do("eye-examine external crate-1", "arm-move arm1 crate-1")
    else:
        one.do("arm-move arm1 crate-1", "arm-move arm1 rock-1")
    assert one.do("arm-ungrasp arm1 rock-3") == "container-full"
    assert one.knows("too-full-for crate-1 rock-3")
    one.do("arm-move arm2 external", "arm-move arm2 crate-1", "arm-move arm2 rock-2")
    assert one.do("arm-grasp arm2 rock-2") == "okay"
    assert not one.knows("too-full-for ? ?")


def test_memory_loses_items_absent_from_the_container() -> None:
    driver = workshop(thing("crate"), rock("crate-1"), thing("tool-box"))
    one = robot(driver)
    one.do("eye-scan external", "eye-scan crate-1")
    one.do("arm-move arm1 external", "arm-move arm1 crate-1", "arm-move arm1 rock-1")
    one.do(
        "arm-grasp arm1 rock-1", "arm-move arm1 tool-box-1", "arm-ungrasp arm1 rock-1"
    )
    assert one.where("rock-1") == "tool-box-1"
    one.do("eye-scan tool-box-1", "eye-scan crate-1")
    assert one.where("rock-1") == "tool-box-1"
    assert one.where("crate-1") == "depot"


def test_picture_shows_contents_at_the_container() -> None:
    driver = workshop(
        thing("crate"), thing("tool-box", "crate-1"), thing("gun-tool", "tool-box-1")
    )
    driver.do("arm-move arm2 external", "arm-move arm2 crate-1")
    driver.do("arm-grasp arm2 crate-1")
    spots = {spot.name: spot for spot in driver.world.picture().spots}
    kinds = [seen.kind for seen in spots["arm2"].things]
    assert kinds == ["crate", "tool-box", "gun-tool"]
    assert spots["depot"].things == ()
