"""`SimpleWorld`: a world of a few lines, from a class and from a function."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

import rapc
from rapc.errors import WorldError
from rapc.testing.contract.trials import try_world
from rapc.world import (
    Datum,
    Fact,
    Finished,
    Handlers,
    Kit,
    Offer,
    Reply,
    Savable,
    SimpleWorld,
)
from rapc.worlds.registry import build_world, find_world, refuse_incomplete


@dataclass
class Brew:
    """The state of a kettle."""

    boiled: int = 0


class Kettle(SimpleWorld):
    """A kettle that takes its time and whistles."""

    name = "kettle"
    kit = Kit(
        Offer({"boil": (0, ("okay",))}, {"whistle": 1}, not_atomic=("boil",)),
        Handlers({}, {"whistle": lambda memory, datum: None}),
    )

    def __init__(self, rng: Any, options: Any) -> None:
        super().__init__(rng, options)
        self.state: Any = Brew()

    def perform(self, ticket: int, request: Fact) -> None:
        """Boil for some time."""
        self.state.boiled += 1
        takes = self.rng.randint(3, 9)
        self.send(Datum(("whistle", self.state.boiled)), takes)
        self.send(Finished(ticket, Reply("okay")), takes)


def test_a_simple_world_with_ends_and_data_to_come_keeps_to_the_port() -> None:
    trials = try_world(lambda seed: build_world(Kettle, seed, {}), None, [("boil",)])
    assert [fault for trial in trials for fault in trial.faults] == []


def test_simple_world_sends_messages_in_order_of_time() -> None:
    world = build_world(Kettle, 1, {})
    assert isinstance(world, Kettle)
    assert world.next_time() is None
    world.send(Datum(("whistle", 2)), 5)
    world.send(Datum(("whistle", 1)), 2)
    assert world.next_time() == 2
    world.advance(3)
    assert world.messages() == [Datum(("whistle", 1))]
    world.advance(9)
    assert world.next_time() == 9
    assert world.messages() == [Datum(("whistle", 2))]


def test_simple_world_drops_the_end_of_a_cancelled_request() -> None:
    world = build_world(Kettle, 1, {})
    world.perform(1, ("boil",))
    world.cancel(1)
    world.advance(20)
    assert world.messages() == [Datum(("whistle", 1))]


def test_simple_world_runs_a_function_as_perform() -> None:
    library = rapc.loads(
        "(declare-primitive press () (okay))\n"
        "(define-rap (go) (succeed (last-result okay)) (method (primitive (press))))"
    )

    def press(world: SimpleWorld, ticket: int, request: Fact) -> Reply:
        world.advance(world.time + 2)
        world.state["presses"] = world.state.get("presses", 0) + 1
        return Reply("okay")

    kit = Kit(Offer({"press": (0, ("okay",))}))
    world = SimpleWorld(perform=press, kit=kit)
    assert isinstance(world, Savable)
    assert rapc.run(library, world, "(go)").succeeded
    assert (world.now(), world.state) == (2, {"presses": 1})


def test_simple_world_goes_back_to_a_saved_state() -> None:
    world, other = build_world(Kettle, 1, {}), build_world(Kettle, 2, {})
    assert isinstance(world, Kettle)
    assert isinstance(other, Kettle)
    world.perform(1, ("boil",))
    other.restore(world.save())
    for one in (world, other):
        one.perform(2, ("boil",))
    assert world.save() == other.save()


def test_simple_world_refuses_a_state_of_other_types() -> None:
    world = build_world(Kettle, 1, {})
    assert isinstance(world, Kettle)
    world.state = {1: "a number is no key of plain data"}
    with pytest.raises(TypeError, match="not plain data"):
        world.save()


def test_simple_world_requires_perform() -> None:
    with pytest.raises(TypeError, match="requires `perform`"):
        SimpleWorld()


def test_simple_world_refuses_states_of_other_worlds() -> None:
    world = build_world(Kettle, 1, {})
    assert isinstance(world, Kettle)
    other = build_world(Kettle, 1, {})
    other.made_with = {"size": 3}
    assert isinstance(other, Kettle)
    for state in (b"", b"{}", other.save()):
        with pytest.raises(ValueError, match=r".+"):
            world.restore(state)


def test_a_class_of_simple_worlds_without_a_kit_is_refused() -> None:
    with pytest.raises(WorldError, match="does not define kit"):
        refuse_incomplete(SimpleWorld, "rapc.world:SimpleWorld")
    with pytest.raises(WorldError, match="does not define kit"):
        find_world("rapc.world:SimpleWorld")
