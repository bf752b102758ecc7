"""The courier's world: it keeps to the port, and does what its page says."""

from __future__ import annotations

import random
from collections.abc import Mapping
from pathlib import Path

import pytest

from rapc.base.values import Atom, Fact
from rapc.compiler.program import Program
from rapc.library.loader import load
from rapc.testing.contract.trials import try_world
from rapc.world import Finished, Reply, Signal
from rapc.worlds.courier import CourierWorld
from rapc.worlds.courier.building import ROOMS, passed, way_to_room
from tests.courier.shifts import COURIER

STILL: Mapping[str, Atom | bool] = {
    "blocked": 0,
    "sold-out": 0,
    "absent": 0,
    "calls": 0,
}
"""Options under which nothing is left to chance but how long people take."""

PAGE = (Path(__file__).parents[2] / "docs" / "reference" / "courier.md").read_text(
    encoding="utf-8"
)


def make(seed: int = 1, **options: Atom | bool) -> CourierWorld:
    """A world in which nothing goes wrong but what `options` say."""
    return CourierWorld(random.Random(seed), {**STILL, **options})


def do(world: CourierWorld, *request: Atom) -> str:
    """Ask for something and wait until it has ended: its result."""
    reply = world.perform(7, request)
    while not isinstance(reply, Reply):
        due = world.next_time()
        assert due is not None
        world.advance(due)
        ended = [m for m in world.messages() if isinstance(m, Finished)]
        reply = ended[0].reply if ended else None
    return reply.result


def test_it_keeps_to_the_port() -> None:
    loaded = load([COURIER / "world.rap"])
    assert loaded.diagnostics == ()
    requests: list[Fact] = [
        ("drive", "pharmacy"),
        ("take-on", "medicine", "ward-1"),
        ("drive", "ward-1"),
        ("ring",),
        ("hand-over", "medicine", "ward-1"),
        ("drive", "base"),
        ("dock",),
        ("help", "ward-1"),
    ]
    trials = try_world(
        lambda seed: CourierWorld(random.Random(f"{seed}:world"), {}),
        Program(loaded.library),
        requests,
    )
    assert [fault for trial in trials for fault in trial.faults] == []


def test_a_drive_takes_as_long_as_its_way_and_as_much_of_the_battery() -> None:
    world = make()
    assert do(world, "drive", "ward-4") == "okay"
    assert (world.now(), world.state.battery) == (34, 36)
    assert do(world, "drive", "ward-4") == "okay"
    assert world.now() == 34


def test_a_nurse_who_will_find_nobody_is_not_announced() -> None:
    """Nothing is sent when she comes, for the robot has driven off by then."""
    world = make()
    do(world, "drive", "ward-1")
    do(world, "ring")
    assert world.next_time() == world.state.nurses[0].time
    do(world, "drive", "pharmacy")
    assert world.state.nurses
    assert world.next_time() is None
    world.advance(100)
    assert (world.messages(), world.state.in_vain) == ([], 1)


def test_a_drive_that_is_cancelled_ends_where_it_has_got_to() -> None:
    world = make()
    world.perform(1, ("drive", "ward-4"))
    world.advance(12)
    world.cancel(1)
    state = world.state
    assert (state.room, state.along, state.drive) == ("corridor", 10, None)
    assert do(world, "drive", "pharmacy") == "okay"
    assert world.now() == 12 + 4 + 2


def test_the_way_is_as_long_in_pieces_as_at_once() -> None:
    for room in ROOMS:
        whole = way_to_room(11, 2, room)
        for gone in range(whole):
            along, depth = passed(11, 2, room, gone)
            if gone <= 2 or depth == 0:
                assert gone + way_to_room(along, depth, room) == whole


def test_a_blocked_door_leaves_the_robot_before_it() -> None:
    world = make(blocked=100)
    assert do(world, "drive", "kitchen") == "blocked"
    assert (world.state.room, world.state.along) == ("corridor", 14)


def test_an_empty_battery_is_the_end() -> None:
    world = make(battery=20)
    assert do(world, "drive", "ward-4") == "battery-empty"
    assert world.ended() == "the battery is empty, 18 along the corridor"
    assert world.next_time() is None


def test_the_dock_charges_until_the_robot_leaves() -> None:
    world = make(battery=20)
    assert do(world, "dock") == "okay"
    world.advance(12)
    world.perform(1, ("drive", "pharmacy"))
    world.advance(15)
    assert world.state.battery == 40
    world.cancel(1)
    assert world.state.battery == 37


def test_who_loads_the_tray_is_left_standing_when_the_robot_drives_off() -> None:
    world = make()
    do(world, "drive", "pharmacy")
    world.perform(2, ("take-on", "medicine", "ward-1"))
    world.perform(3, ("drive", "base"))
    ended = [m for m in world.messages() if isinstance(m, Finished)]
    assert [(m.ticket, m.reply.result) for m in ended] == [(2, "robot-left")]
    assert (world.state.in_vain, world.state.tray) == (1, [])


def test_a_nurse_takes_what_is_for_her_if_the_robot_is_there() -> None:
    world = make()
    do(world, "drive", "pharmacy")
    assert do(world, "take-on", "medicine", "ward-1") == "okay"
    do(world, "drive", "ward-1")
    assert do(world, "hand-over", "medicine", "ward-1") == "nobody-there"
    assert do(world, "ring") == "okay"
    due = world.next_time()
    assert due is not None
    world.advance(due)
    assert Signal((":nurse", "ward-1")) in world.messages()
    assert do(world, "hand-over", "meals", "ward-1") == "not-aboard"
    assert do(world, "hand-over", "medicine", "ward-1") == "okay"
    [delivery] = world.state.deliveries
    assert (delivery.goods, delivery.label, delivery.ward) == (
        "medicine",
        "ward-1",
        "ward-1",
    )
    assert world.state.in_vain == 0


def test_a_nurse_who_finds_nobody_came_in_vain() -> None:
    world = make()
    do(world, "drive", "ward-1")
    do(world, "ring")
    do(world, "drive", "ward-2")
    world.advance(200)
    assert not [m for m in world.messages() if isinstance(m, Signal)]
    assert world.state.in_vain == 1


def test_a_call_is_over_once_somebody_was_helped() -> None:
    world = make(calls=30)
    while not world.state.calls:
        world.advance(world.now() + 1)
    [ward] = world.state.calls
    assert do(world, "help", ward) == "not-here"
    do(world, "drive", ward)
    assert do(world, "help", ward) == "okay"
    assert ward not in world.state.calls
    assert do(world, "help", ward) == "not-called"


@pytest.mark.parametrize("option", ["battery", "blocked", "sold-out", "absent"])
@pytest.mark.parametrize("value", [-1, 101])
def test_an_option_out_of_range_is_refused(option: str, value: int) -> None:
    with pytest.raises(ValueError, match=option):
        CourierWorld(random.Random(1), {option: value})


def test_a_state_of_other_options_is_refused() -> None:
    saved = make(tray=1).save()
    with pytest.raises(ValueError, match="with other options"):
        make(tray=2).restore(saved)
    with pytest.raises(ValueError, match="no state"):
        make().restore(b"{}")


def test_the_page_has_all_that_the_world_offers() -> None:
    kit = CourierWorld.kit
    for name, (_, results) in kit.offer.primitives.items():
        assert f"`({name}" in PAGE
        assert all(r == "okay" or f"`{r}`" in PAGE for r in results), name
    for name in (*kit.offer.data, *kit.offer.events):
        assert f"`({name}" in PAGE
    for option in kit.options:
        row = f"| `{option.name}` | {option.default} {option.unit} | {option.doc} |"
        assert row in PAGE
