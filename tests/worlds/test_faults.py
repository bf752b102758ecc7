"""A world with faults keeps to the port, and saves its random stream too."""

from __future__ import annotations

import random

from rapc.library.loader import load_text
from rapc.world import World
from rapc.worlds.faults import Fault, FaultyWorld
from rapc.worlds.truck import TruckWorld

from .contract import check_world

SCAN = ("eye-scan", "external")
FAULTS = (Fault(("eye-scan", "?"), "eye-cant-find", 0.5),)


def _truck() -> World:
    return FaultyWorld(TruckWorld(random.Random("0:world"), {}), FAULTS, 0)


def test_it_keeps_to_the_port() -> None:
    library = load_text('(require "truck")').library
    check_world(_truck, library, [SCAN, SCAN, ("truck-turn", "north"), SCAN])


def test_it_is_what_is_behind_it() -> None:
    world, truck = _truck(), TruckWorld(random.Random("0:world"), {})
    assert world.name == truck.name
    assert world.offer() == truck.offer()
    assert list(world.functions()) == list(truck.functions())
    assert list(world.comparators()) == list(truck.comparators())
    assert list(world.solvers()) == list(truck.solvers())
    assert list(world.facts()) == list(truck.facts())


def test_a_fault_takes_its_usual_time_and_brings_no_data() -> None:
    truck = TruckWorld(random.Random("0:world"), {})
    world = FaultyWorld(truck, [Fault(("eye-scan", "?"), "eye-cant-find")], 0)
    reply = world.perform(1, SCAN)
    assert reply is not None
    assert (reply.result, reply.data) == ("eye-cant-find", ())
    assert world.now() == truck.usual_time(SCAN) > 0


def test_the_random_stream_is_saved() -> None:
    world = _truck()
    state = world.save()
    replies = [world.perform(n, SCAN) for n in range(10)]
    assert {reply.result for reply in replies if reply} == {"okay", "eye-cant-find"}
    other = FaultyWorld(TruckWorld(random.Random("1:world"), {}), FAULTS, 1)
    other.restore(state)
    assert [other.perform(n, SCAN) for n in range(10)] == replies
