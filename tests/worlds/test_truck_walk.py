"""Random requests: nothing vanishes, nothing doubles, every result is declared."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rapc.terms import Atom, Fact, Text
from rapc.worlds.truck import TruckWorld
from rapc.worlds.truck.kinds import KINDS
from rapc.worlds.truck.primitives import OFFER
from rapc.worlds.truck.state import ARMS, State

from .drive import map_text, rock, thing

ITEMS = [
    rock(count=3),
    rock("zone-1"),
    rock("factory-1"),
    thing("fuel-drum", count=2),
    thing("ammo-box"),
    thing("gun"),
    thing("gun-tool"),
]
BUSY: dict[str, Atom | bool] = {
    "map": Text(map_text(ITEMS)),
    "quarry-interval": 7,
    "warehouse-interval": 9,
    "depot-interval": 5,
    "factory-interval": 6,
    "fuel-use": 0.1,
    "lasting-names": True,
}
ENDLESS: dict[str, Atom | bool] = {"fuel-use": 0, "capture-time": 0}
CAPACITY = {"arm1": 8, "arm2": 15, "bay1": 20, "bay2": 100, "weapon-bay": 10}

arms = st.sampled_from(ARMS)
rocks = st.integers(1, 6).map(lambda number: f"rock-{number}")
others = st.sampled_from(["fuel-drum-1", "fuel-drum-2", "ammo-box-1", "gun-1"])
things = st.one_of(rocks, others, st.just("gun-tool-1"))
spots = st.sampled_from(
    ["external", "folded", "bay1", "bay2", "weapon-bay", "fuel-bay", "arm1", "depot"]
)
at_item = st.one_of(
    st.sampled_from(["arm-move", "arm-grasp", "arm-ungrasp"]),
    st.sampled_from(["arm-pour", "arm-ladle", "arm-toggle", "arm-examine"]),
)
directions = st.sampled_from(["north", "south", "east", "west"])
requests = st.one_of(
    st.tuples(at_item, arms, things),
    st.tuples(at_item, arms, things),
    st.tuples(st.just("arm-move"), arms, spots),
    st.tuples(st.sampled_from(["eye-scan", "eye-monitor"]), spots),
    st.tuples(st.just("eye-examine"), spots, things),
    st.tuples(st.just("truck-turn"), directions),
    st.just(("truck-move",)),
)


def visit(world: TruckWorld, request: Fact) -> str:
    before = world.now()
    reply = world.perform(0, request)
    assert reply.result in OFFER.primitives[str(request[0])][1]
    assert world.now() > before
    for datum in reply.data:
        assert OFFER.data[str(datum[0])] == len(datum) - 1
    return reply.result


def check(state: State) -> None:
    """What holds of every state of the world."""
    assert sum(state.made.values()) == len(state.items) + state.gone
    for arm in state.truck.arms.values():
        if arm.at is not None:
            where = arm.place if arm.place != "external" else state.truck.place
            assert state.items[arm.at].place == where
    for place, capacity in CAPACITY.items():
        held = [i for i in state.items.values() if i.place == place]
        assert sum(KINDS[item.kind].size for item in held) <= capacity
    for item in state.items.values():
        assert 0 <= item.amount <= KINDS[item.kind].capacity
        assert item.place not in ("folded", "fuel-bay", "external")
    assert 0 <= state.truck.fuel <= 30


@given(st.lists(requests, max_size=60), st.integers(0, 9))
@settings(max_examples=150, deadline=None)
def test_items_never_vanish_or_double(walk: list[Fact], seed: int) -> None:
    world = TruckWorld(random.Random(seed), BUSY)
    for request in walk:
        before = world.state.items
        visit(world, request)
        after = world.state
        check(after)
        for name, item in before.items():
            gone = name not in after.items
            assert not gone or item.kind in ("rock", "fuel-drum")


@given(st.lists(requests, max_size=60), st.integers(0, 9))
@settings(max_examples=40, deadline=None)
def test_a_saved_world_goes_on_as_if_nothing_had_been(
    walk: list[Fact], seed: int
) -> None:
    world = TruckWorld(random.Random(seed), BUSY)
    world.messages()
    half = len(walk) // 2
    for request in walk[:half]:
        world.perform(0, request)
    other = TruckWorld(random.Random(99), BUSY)
    other.restore(world.save())
    for request in walk[half:]:
        assert world.perform(0, request) == other.perform(0, request)
    assert world.save() == other.save()


def test_a_state_of_other_options_or_none_is_refused() -> None:
    world = TruckWorld(random.Random(0), BUSY)
    with pytest.raises(ValueError, match="with other options"):
        world.restore(TruckWorld(random.Random(0), {}).save())
    for state in (b"", b"{}", b"[1]", world.save()[:-5]):
        with pytest.raises(ValueError, match="no state of a truck world"):
            world.restore(state)


def test_a_long_walk_among_things_in_reach_stays_consistent() -> None:
    world = TruckWorld(random.Random(1), {**BUSY, **ENDLESS})
    dice = random.Random(2)
    seen = set()
    for _ in range(5000):
        request = next_request(world.state, dice)
        seen.add((request[0], visit(world, request)))
        check(world.state)
    assert len(world.deliveries) > 1
    assert {result for act, result in seen if act == "arm-grasp"} >= {
        *("okay", "arm-dropped", "arm-too-full", "arm-cant-grasp", "arm-interference"),
    }


def next_request(state: State, dice: random.Random) -> Fact:
    """A request about something in reach, if there is anything."""
    name = dice.choice(ARMS)
    arm = state.truck.arms[name]
    where = state.truck.place if arm.place == "external" else arm.place
    near = [item.name for item in state.items.values() if item.place == where]
    held = [item.name for item in state.items.values() if item.place == name]
    wishes: list[Fact] = [
        ("arm-move", name, dice.choice(["external", "bay1", "bay2", "folded"])),
        ("truck-turn", dice.choice(["north", "south", "east", "west"])),
        ("truck-move",),
    ]
    wishes += [("arm-move", name, dice.choice(near))] if near else []
    wishes += [("arm-ungrasp", name, dice.choice(held))] if held else []
    wishes += [("arm-grasp", name, arm.at)] * 2 if arm.at else []
    return dice.choice(wishes)
