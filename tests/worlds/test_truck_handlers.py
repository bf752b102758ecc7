"""What the truck's handlers make of results and data (T 3.3.2)."""

from __future__ import annotations

import pytest

from rapc.compiler.program import Program
from rapc.errors import RefusedError
from rapc.library.loader import load_text
from rapc.runtime.interpreter import Interpreter
from rapc.worlds.truck.handlers import HANDLERS
from rapc.worlds.truck.primitives import OFFER

from .drive import Driver, rock, thing
from .robot import Robot, truck_words

SEE = ("eye-scan external",)
PICK = (*SEE, "arm-move arm1 external", "arm-move arm1 rock-1", "arm-grasp arm1 rock-1")


def robot(*items: object, **options: object) -> Robot:
    return Robot(Driver(items, **options).world, truck_words())  # type: ignore[arg-type]


def test_declarations_equal_the_offer_of_the_world() -> None:
    words = truck_words()
    declared = {n: (len(p.args), set(p.results)) for n, p in words.primitives.items()}
    offered = {
        n: (arity, set(results)) for n, (arity, results) in OFFER.primitives.items()
    }
    assert declared == offered
    assert {name: len(d.args) for name, d in words.data.items()} == dict(OFFER.data)
    assert set(HANDLERS.data) == set(OFFER.data)
    assert set(HANDLERS.results) <= set(OFFER.primitives)


def test_every_fact_of_the_map_is_declared() -> None:
    assert robot().knows("road road-1 depot north zone-1")


def test_the_first_messages_tell_where_the_truck_is() -> None:
    one = robot(fuel=20)
    assert one.memory.place == "depot"
    assert one.knows("truck-location depot")
    assert one.knows("truck-fuel 20")
    assert one.knows("truck-heading north")
    assert one.knows("truck-speed medium")
    assert one.knows("time-arrived 0")


def test_a_trip_takes_all_names_but_those_of_guns_and_tools_on_board() -> None:
    one = robot(rock(), thing("gun"), thing("gun-tool"))
    one.do(*SEE, "arm-move arm1 external", "arm-move arm1 gun-tool-1")
    one.do("arm-grasp arm1 gun-tool-1", "arm-move arm1 bay1")
    one.do("arm-ungrasp arm1 gun-tool-1", "truck-turn north", "truck-move")
    assert one.reaches("gun-tool-1")
    assert one.where("gun-tool-1") == "bay1"
    assert not one.reaches("gun-1")
    assert one.where("gun-1") == "depot"
    assert not one.reaches("rock-1")


def test_a_scan_introduces_items_at_their_true_place() -> None:
    one = robot(rock(), thing("gun"))
    one.do(*SEE)
    assert one.where("rock-1") == "depot"
    assert one.knows("class gun-1 gun true")
    assert one.knows("eye-scanned external")
    assert one.knows("scanned-since-move external")
    assert one.knows("direction external road-1 north")
    assert one.knows("truck-time 2")
    assert one.reaches("rock-1")


def test_a_grasped_item_is_in_the_arm() -> None:
    one = robot(rock())
    assert one.do(*PICK[:3]) == "okay"
    assert one.knows("arm-at arm1 rock-1")
    assert one.knows("arm-place arm1 external")
    assert one.do(PICK[3]) == "okay"
    assert one.where("rock-1") == "arm1"
    assert one.knows("arm-holding arm1 rock-1")
    assert not one.knows("arm-at arm1 ?")


def test_an_item_put_down_outside_is_where_the_truck_is() -> None:
    one = robot(rock())
    assert one.do(*PICK, "arm-ungrasp arm1 rock-1") == "okay"
    assert one.where("rock-1") == "depot"
    assert one.knows("arm-at arm1 rock-1")
    assert not one.knows("arm-holding ? ?")
    assert one.do("arm-grasp arm1 rock-1", "arm-move arm1 bay2") == "okay"
    assert one.do("arm-ungrasp arm1 rock-1") == "okay"
    assert one.where("rock-1") == "bay2"


def test_too_small_empty_arm_is_remembered() -> None:
    one = robot(rock(), thing("gun-tool"), arm1_capacity=6)
    assert one.do(*PICK) == "arm-too-full"
    assert one.knows("too-small-for arm1 rock-1")
    one.do("arm-move arm1 gun-tool-1", "arm-grasp arm1 gun-tool-1")
    one.do("arm-ungrasp arm1 gun-tool-1")
    assert one.knows("too-small-for arm1 rock-1")


def test_a_full_arm_is_too_full_until_it_puts_something_down() -> None:
    one = robot(rock(count=2))
    one.do(*PICK, "arm-move arm1 rock-2")
    assert one.do("arm-grasp arm1 rock-2") == "arm-too-full"
    assert one.knows("too-full-for arm1 rock-2")
    assert not one.knows("too-small-for ? ?")
    one.do("arm-ungrasp arm1 rock-1")
    assert not one.knows("too-full-for ? ?")


def test_a_full_bay_is_too_full_until_something_is_taken_out() -> None:
    one = robot(rock(count=2), bay1_capacity=7)
    one.do(*PICK, "arm-move arm1 bay1", "arm-ungrasp arm1 rock-1")
    one.do("arm-move arm1 external", "arm-move arm1 rock-2", "arm-grasp arm1 rock-2")
    assert one.do("arm-move arm1 bay1", "arm-ungrasp arm1 rock-2") == "container-full"
    assert one.knows("too-full-for bay1 rock-2")
    assert one.where("rock-2") == "arm1"
    one.do("arm-move arm2 bay1", "arm-move arm2 rock-1")
    assert one.do("arm-grasp arm2 rock-1") == "okay"
    assert not one.knows("too-full-for bay1 ?")


def test_interference_lasts_until_an_arm_moves() -> None:
    one = robot(rock())
    one.do(*PICK[:3], "arm-move arm2 external", "arm-move arm2 rock-1")
    assert one.do("arm-grasp arm1 rock-1") == "arm-interference"
    assert one.knows("arm-interference rock-1")
    one.do("arm-move arm2 folded")
    assert not one.knows("arm-interference ?")
    assert one.knows("arm-at arm1 rock-1")


def test_need_of_a_tool_is_remembered() -> None:
    one = robot(thing("gun"), thing("gun-tool"))
    one.do(*SEE, "arm-move arm1 external", "arm-move arm1 gun-1")
    assert one.do("arm-grasp arm1 gun-1") == "arm-cant-grasp"
    assert one.knows("tool-needed gun-1 gun-tool")


def test_an_item_snatched_away_is_lost() -> None:
    one = robot(rock("factory-1"), start="factory-1", factory_interval=20)
    one.do(*SEE, "arm-move arm1 external")
    assert one.where("rock-1") == "factory-1"
    one.world.advance(40)
    assert one.do("arm-move arm1 rock-1") == "arm-cant-find"
    assert one.where("rock-1") == "unknown"
    assert not one.reaches("rock-1")


def test_an_item_is_not_lost_by_looking_for_it_in_the_wrong_place() -> None:
    one = robot(rock())
    one.do(*SEE)
    assert one.do("arm-move arm1 rock-1") == "arm-cant-find"  # the arm is folded
    assert one.do("eye-examine bay1 rock-1") == "eye-cant-find"
    assert one.where("rock-1") == "depot"


def test_scan_without_a_known_item_loses_the_item() -> None:
    one = robot(thing("fuel-drum"), rock(), depot_interval=10)
    one.do(*SEE, "arm-move arm1 external", "arm-move arm1 fuel-drum-1")
    one.do("arm-grasp arm1 fuel-drum-1", "arm-pour arm1 fuel-drum-1")
    one.do("arm-ungrasp arm1 fuel-drum-1")
    one.world.advance(60)
    one.do(*SEE)
    assert one.where("fuel-drum-1") == "unknown"
    assert one.where("rock-1") == "depot"


def test_the_last_place_of_a_delivered_rock_stays_the_factory() -> None:
    one = robot(rock("factory-1"), start="factory-1", factory_interval=20)
    one.do(*PICK, "arm-ungrasp arm1 rock-1", "arm-move arm1 folded")
    one.world.advance(50)
    one.do(*SEE)
    assert one.where("rock-1") == "factory-1"
    one.do("truck-turn east", "truck-move", "truck-turn west", "truck-move", *SEE)
    assert one.where("rock-1") == "factory-1"


def test_scan_after_a_return_reports_missing_items() -> None:
    one = robot(thing("fuel-drum"), depot_interval=5)
    one.do(*SEE, "arm-move arm1 external", "arm-move arm1 fuel-drum-1")
    one.do("arm-grasp arm1 fuel-drum-1", "arm-pour arm1 fuel-drum-1")
    one.do("arm-ungrasp arm1 fuel-drum-1", "arm-move arm1 folded")
    assert one.where("fuel-drum-1") == "depot"
    one.do("truck-move", "truck-turn south", "truck-move", *SEE)
    assert one.where("fuel-drum-1") == "unknown"


def test_after_a_trip_all_must_be_sensed_again() -> None:
    one = robot(rock())
    one.do(
        *PICK, "arm-move arm1 bay2", "arm-ungrasp arm1 rock-1", "arm-move arm1 folded"
    )
    one.do("eye-scan bay2", "eye-examine bay2 rock-1", "truck-move")
    assert one.memory.place == "zone-1"
    assert one.knows("truck-location zone-1")
    assert one.where("rock-1") == "bay2"
    assert not one.reaches("rock-1")
    assert not one.knows("scanned-since-move ?")
    assert not one.knows("examined-since-move ?")
    assert not one.knows("direction ? ? ?")
    assert one.knows("eye-scanned bay2")
    assert one.knows("eye-examined rock-1")
    one.do("eye-scan bay2")
    assert one.reaches("rock-1")


def test_scan_of_an_arm_reports_the_held_item() -> None:
    one = robot(rock())
    one.do(*PICK, "arm-move arm1 folded", "truck-move", "eye-scan arm1")
    assert one.knows("arm-holding arm1 rock-1")
    assert one.where("rock-1") == "arm1"
    one.access.assert_fact("arm-holding", "arm2", "rock-1")
    one.do("eye-scan arm2")
    assert not one.knows("arm-holding arm2 ?")


def test_examining_tells_properties() -> None:
    one = robot(rock(color="blue"), thing("fuel-drum"), thing("gun"))
    one.do(*SEE, "eye-examine external rock-1", "eye-examine external fuel-drum-1")
    one.do("eye-examine external gun-1")
    for fact in (
        "color rock-1 blue",
        "size rock-1 7",
        "class fuel-drum-1 vessel true",
        "liquid-held fuel-drum-1 fuel",
        "quantity-held fuel-drum-1 5",
        "capacity fuel-drum-1 5",
        "class gun-1 weapon true",
        "quantity-held gun-1 15",
        "tool-needed gun-1 gun-tool",
        "eye-examined rock-1",
        "examined-since-move rock-1",
        "examined-since-toggle rock-1",
        "examined-since-pour rock-1",
    ):
        assert one.knows(fact), fact


def test_amount_is_unknown_after_pouring() -> None:
    one = robot(thing("fuel-drum", count=2), fuel=29)
    one.do(*SEE, "eye-examine external fuel-drum-1", "eye-examine external fuel-drum-2")
    one.do("arm-move arm1 external", "arm-move arm1 fuel-drum-1")
    one.do("arm-grasp arm1 fuel-drum-1", "arm-move arm1 fuel-drum-2")
    one.do("arm-pour arm1 fuel-drum-1")
    for drum in ("fuel-drum-1", "fuel-drum-2"):
        assert one.knows(f"quantity-held {drum} unknown")
        assert not one.knows(f"examined-since-pour {drum}")
    one.do("arm-move arm1 fuel-bay", "arm-pour arm1 fuel-drum-1")
    assert one.knows("truck-fuel 30")
    one.do("arm-examine arm1 fuel-drum-1")
    assert one.knows("quantity-held fuel-drum-1 4")
    assert one.knows("arm-examined fuel-drum-1")


def test_toggling_leaves_the_rounds_to_be_counted() -> None:
    one = robot(thing("gun"))
    one.do(*SEE, "eye-examine external gun-1")
    one.digest(("arm-toggle", "arm1", "gun-1"), "okay")
    assert one.knows("quantity-held gun-1 unknown")
    assert not one.knows("examined-since-toggle gun-1")


def test_wrong_belief_about_a_held_item_is_corrected() -> None:
    one = robot(rock())
    one.do(*SEE)
    one.digest(("arm-grasp", "arm1", "rock-1"), "okay")
    assert one.do("arm-ungrasp arm1 rock-1") == "arm-not-holding"
    assert not one.knows("arm-holding ? ?")
    assert one.where("rock-1") == "unknown"


@pytest.mark.parametrize("primitive", ["arm-grasp", "arm-toggle", "arm-examine"])
def test_an_arm_believed_at_an_item_is_put_right(primitive: str) -> None:
    one = robot(rock(), thing("gun"))
    one.do(*SEE)
    one.digest(("arm-move", "arm1", "gun-1"), "okay")
    assert one.do(f"{primitive} arm1 gun-1") == "arm-not-at"
    assert not one.knows("arm-at ? ?")


def test_monitoring_is_noted_while_it_lasts() -> None:
    one = robot(rock("zone-1"))
    one.do("eye-monitor rock", "truck-move")
    assert one.knows("monitoring rock")
    assert one.where("rock-1") == "zone-1"
    one.do("eye-unmonitor rock")
    assert not one.knows("monitoring ?")


def test_a_mishap_is_noted() -> None:
    one = robot(fuel=0.2)
    assert one.do("truck-move") == "truck-mishap"
    assert one.knows("truck-status mishap")
    assert not one.knows("truck-status ready")


def test_memory_and_world_agree_after_a_long_journey() -> None:
    one = robot(rock("zone-1", 2), rock("quarry-1"), thing("fuel-drum"))
    one.do("truck-move", *SEE, "arm-move arm2 external")
    for number in (1, 2):
        one.do(f"arm-move arm2 rock-{number}", f"arm-grasp arm2 rock-{number}")
    one.do(
        "arm-move arm2 folded", "truck-turn west", "truck-move", *SEE, "eye-scan arm2"
    )
    one.do("arm-move arm2 external", "arm-ungrasp arm2 rock-1", "arm-move arm2 bay2")
    assert one.do("arm-ungrasp arm2 rock-2") == "okay"
    assert [one.where(f"rock-{n}") for n in (1, 2)] == ["factory-1", "bay2"]


def test_a_library_without_the_trucks_words_is_refused_beforehand() -> None:
    library = load_text("(define-rap (idle) (succeed t))").library
    told = "the world `truck` has initial facts of `place`, `produces`"
    with pytest.raises(RefusedError, match=told):
        Interpreter(Program(library, "idle"), Driver().world)
