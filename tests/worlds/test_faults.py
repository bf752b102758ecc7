"""A world with faults keeps to the port, and saves its random stream too."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import pytest

from rapc.world import (
    Drawable,
    Fact,
    Kit,
    Message,
    Offer,
    Reply,
    Savable,
    Time,
    Timed,
    World,
)
from rapc.worlds.faults import FaultyWorld, InjectedFault
from rapc.worlds.truck import TruckWorld

SCAN = ("eye-scan", "external")
FAULTS = (InjectedFault(("eye-scan", "?"), "eye-cant-find", 0.5),)


def _truck() -> Any:
    return FaultyWorld(TruckWorld(random.Random("0:world"), {}), FAULTS, 0)


class Still(World):
    """A world that has no part but the needed ones."""

    name = "still"
    kit = Kit(Offer({"wait": (0, ("okay", "late"))}))

    def now(self) -> Time:
        return 0

    def perform(self, ticket: int, request: Fact) -> Reply:
        return Reply("okay")

    def next_time(self) -> None:
        return None

    def advance(self, to: Time) -> None:
        pass

    def messages(self) -> Sequence[Message]:
        return ()


def test_wrapper_has_attributes_of_the_wrapped_world() -> None:
    world, truck = _truck(), TruckWorld(random.Random("0:world"), {})
    assert world.name == truck.name
    assert world.kit == truck.kit
    assert list(world.facts()) == list(truck.facts())


def test_a_fault_takes_its_usual_time_and_brings_no_data() -> None:
    truck = TruckWorld(random.Random("0:world"), {})
    world = FaultyWorld(truck, [InjectedFault(("eye-scan", "?"), "eye-cant-find")], 0)
    reply = world.perform(1, SCAN)
    assert isinstance(reply, Reply)
    assert (reply.result, reply.data) == ("eye-cant-find", ())
    assert world.now() == truck.usual_time(SCAN) > 0


def test_wrapper_has_the_protocols_of_the_wrapped_world() -> None:
    for kind in (Drawable, Savable, Timed):
        assert isinstance(_truck(), kind)
        assert not isinstance(FaultyWorld(Still(), FAULTS, 0), kind)


def test_fault_takes_no_time_in_a_world_without_times() -> None:
    world = FaultyWorld(Still(), [InjectedFault(("wait",), "late")], 0)
    assert world.perform(1, ("wait",)) == Reply("late")
    assert world.now() == 0


@pytest.mark.parametrize("state", [b"", b"{}", b'{"world":"","rng":[3,[1],null]}'])
def test_invalid_state_is_refused_and_changes_nothing(state: bytes) -> None:
    world = _truck()
    before = world.save()
    with pytest.raises(ValueError, match="no state"):
        world.restore(state)
    assert world.save() == before


def test_the_random_stream_is_saved() -> None:
    world = _truck()
    state = world.save()
    replies = [world.perform(n, SCAN) for n in range(10)]
    results = {reply.result for reply in replies if isinstance(reply, Reply)}
    assert results == {"okay", "eye-cant-find"}
    other: Any = FaultyWorld(TruckWorld(random.Random("1:world"), {}), FAULTS, 1)
    other.restore(state)
    assert [other.perform(n, SCAN) for n in range(10)] == replies
