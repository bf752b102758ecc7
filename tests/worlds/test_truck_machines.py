"""Items that act by themselves once they are switched on (T 1.4.2, B.1)."""

from __future__ import annotations

from typing import Any

from .drive import Driver, thing, workshop
from .robot import Robot, truck_words

AT_MACHINE = ("arm-move arm1 external", "arm-move arm1 ice-machine-1")
ICE = (
    "arm-move arm1 external",
    "arm-move arm1 jug-1",
    "arm-grasp arm1 jug-1",
    "arm-move arm1 tank-1",
    "arm-ladle arm1 jug-1",
    "arm-move arm1 ice-machine-1",
    "arm-pour arm1 jug-1",
    "arm-toggle arm1 ice-machine-1",
)
"""The way to ice of T B.1: from the tank with a jug into the machine."""


def icy(**options: Any) -> Driver:
    """A tank, a jug and an ice machine at the depot."""
    return workshop(thing("tank"), thing("jug"), thing("ice-machine"), **options)


def count(driver: Driver, kind: str) -> int:
    """How many items of a kind there are."""
    return sum(item.kind == kind for item in driver.world.state.items.values())


def looks(driver: Driver, item: str) -> tuple[Any, ...]:
    """What examining tells of a machine's doings."""
    data = driver.data(f"eye-examine external {item}")
    return next(datum for datum in data if datum[0] == "machine")


def test_a_machine_uses_up_its_liquid_and_makes_things_until_there_is_none() -> None:
    driver = icy()
    driver.do(*ICE)
    on = driver.world.now()
    items = driver.world.state.items
    assert (items["tank-1"].amount, items["jug-1"].amount) == (46, 0)
    assert looks(driver, "ice-machine-1") == ("machine", "ice-machine-1", "running")
    for after, made in ((11, 0), (12, 1), (24, 2), (500, 2)):
        driver.world.advance(on + after)
        assert count(driver, "ice") == made
    assert driver.world.state.items["ice-machine-1"].amount == 0
    assert looks(driver, "ice-machine-1") == ("machine", "ice-machine-1", "idle")
    assert driver.data("eye-scan external")[-2][2] == "ice-2"


def test_toggling_again_stops_it() -> None:
    driver = icy()
    driver.do(*ICE, "arm-toggle arm1 ice-machine-1")
    driver.world.advance(1000)
    assert count(driver, "ice") == 0
    assert driver.world.state.items["ice-machine-1"].amount == 4


def test_it_goes_on_while_the_truck_is_away() -> None:
    driver = icy()
    driver.do(*ICE, "arm-move arm1 folded")
    assert driver.drive("north", "south") == "okay"
    assert count(driver, "ice") == 2


def test_a_machine_takes_only_the_liquid_it_works_with() -> None:
    driver = workshop(thing("fuel-drum"), thing("ice-machine"))
    driver.do("arm-move arm1 external", "arm-move arm1 fuel-drum-1")
    driver.do("arm-grasp arm1 fuel-drum-1", "arm-move arm1 ice-machine-1")
    driver.do("arm-pour arm1 fuel-drum-1")
    items = driver.world.state.items
    assert (items["fuel-drum-1"].amount, items["ice-machine-1"].amount) == (0, 0)


def test_machine_consumes_inserted_items() -> None:
    driver = workshop(
        thing("assembler"), thing("bandage", "assembler-1", 5), thing("ice", count=2)
    )
    for ice in ("ice-1", "ice-2"):
        driver.do("arm-move arm1 external", f"arm-move arm1 {ice}")
        driver.do(f"arm-grasp arm1 {ice}", "arm-move arm1 assembler-1")
        driver.do(f"arm-ungrasp arm1 {ice}")
    driver.do("arm-move arm1 assembler-1", "arm-toggle arm1 assembler-1")
    driver.world.advance(driver.world.now() + 500)
    assert (count(driver, "kit"), count(driver, "ice")) == (2, 0)
    assert count(driver, "bandage") == 1
    assert driver.place("kit-1") == "depot"
    assert looks(driver, "assembler-1") == ("machine", "assembler-1", "idle")
    state = driver.world.state
    assert sum(state.made.values()) == len(state.items) + state.gone


def test_a_machine_stops_where_too_much_lies() -> None:
    driver = icy(item_limit=3)
    driver.do(*ICE)
    driver.world.advance(500)
    assert count(driver, "ice") == 2  # with tank and machine that makes four
    assert looks(driver, "ice-machine-1")[2] == "idle"


def test_a_machine_may_want_daylight() -> None:
    sunny = {"size": 200, "machine": {"makes": "ice", "every": 10, "daylight": True}}
    driver = workshop(
        thing("sunny"),
        kinds={"sunny": sunny},
        day_length=200,
        night=50,
        item_limit=100,
        arm_move_time=1,
    )
    driver.do(
        "arm-move arm1 external", "arm-move arm1 sunny-1", "arm-toggle arm1 sunny-1"
    )
    driver.world.advance(100)
    by_day = count(driver, "ice")
    assert by_day == 9
    driver.world.advance(199)
    assert count(driver, "ice") == by_day
    assert looks(driver, "sunny-1")[2] == "running"
    driver.world.advance(220)
    assert count(driver, "ice") > by_day


def test_memory_knows_whether_a_machine_runs_until_it_is_toggled() -> None:
    driver = icy()
    one = Robot(driver.world, truck_words())
    one.do("eye-scan external", "eye-examine external ice-machine-1")
    assert one.knows("machine-state ice-machine-1 idle")
    one.do(*AT_MACHINE, "arm-toggle arm1 ice-machine-1")
    assert not one.knows("machine-state ice-machine-1 ?")
    one.do("arm-examine arm1 ice-machine-1")
    assert one.knows("machine-state ice-machine-1 running")


MENDED = (
    "arm-move arm1 external",
    "arm-move arm1 wrench-1",
    "arm-grasp arm1 wrench-1",
    "arm-move arm1 ice-machine-1",
    "arm-toggle arm1 ice-machine-1",
)
"""With a wrench in hand a broken machine is made whole, and left switched off."""


def test_a_machine_wears_out_and_can_be_mended() -> None:
    driver = workshop(
        thing("tank"), thing("jug"), thing("ice-machine"), thing("wrench"), wear=100
    )
    driver.do(*ICE)
    driver.world.advance(500)
    assert count(driver, "ice") == 1
    assert looks(driver, "ice-machine-1")[2] == "broken"
    assert driver.do("arm-toggle arm1 ice-machine-1") == "arm-cant-toggle"
    driver.do("arm-move arm1 external", "arm-ungrasp arm1 jug-1")
    driver.do(*MENDED)
    assert looks(driver, "ice-machine-1")[2] == "idle"
    assert count(driver, "wrench") == 1
    driver.do("arm-toggle arm1 ice-machine-1")
    assert looks(driver, "ice-machine-1")[2] == "running"
    driver.world.advance(1000)
    assert count(driver, "ice") == 2
    assert looks(driver, "ice-machine-1")[2] == "broken"


def test_how_often_machines_break_is_chance_of_its_own() -> None:
    made = []
    for seed in range(8):
        driver = icy(wear=50, seed=seed, item_limit=100)
        luck = driver.world.save()
        driver.do(*ICE)
        driver.world.advance(500)
        made.append((count(driver, "ice"), looks(driver, "ice-machine-1")[2]))
        driver.world.restore(luck)
        driver.do(*ICE)
        driver.world.advance(500)
        assert made[-1][0] == count(driver, "ice")
    assert {state for _, state in made} == {"broken", "idle"}
    assert {ice for ice, _ in made} == {1, 2}


def test_broken_machine_needs_its_repair_tool() -> None:
    broken = {**thing("ice-machine"), "broken": True}
    driver = workshop(broken, thing("bandage"), thing("wrench"))
    one = Robot(driver.world, truck_words())
    one.do("eye-scan external", "eye-examine external ice-machine-1")
    assert one.knows("machine-state ice-machine-1 broken")
    bandaged = [request.replace("wrench", "bandage") for request in MENDED]
    assert one.do(*bandaged) == "arm-cant-toggle"
    one.do("arm-move arm1 external", "arm-ungrasp arm1 bandage-1", *MENDED)
    assert not one.knows("machine-state ice-machine-1 ?")
    one.do("eye-examine external ice-machine-1")
    assert one.knows("machine-state ice-machine-1 idle")
