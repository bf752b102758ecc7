"""Beliefs are compared with the facts that a world tells as its truth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

import rapc
from rapc.base.values import Fact
from rapc.world import (
    Datum,
    HandlerMemory,
    Handlers,
    Kit,
    Offer,
    Reply,
    SimpleWorld,
)

LIBRARY = rapc.loads(
    """
(declare-memory-property robot-at (?place) unknown)
(declare-memory-property lid (?box ?state) closed)
(declare-memory-proposition on-tray (?goods ?ward))
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property class (?item ?class ?value) unknown)
(declare-memory-proposition liked (?goods))
(declare-primitive look (?place) (okay))
(define-rap (look-around) (method (primitive (look here))))
"""
)


def found(memory: HandlerMemory, datum: Fact) -> None:
    memory.introduce(str(datum[1]), "box", datum[2])


class Room(SimpleWorld):
    """A room in which a look finds a box; the truth is set by the tests."""

    name = "room"
    kit = Kit(
        Offer(primitives={"look": (1, ("okay",))}, data={"found": 2}),
        Handlers(data={"found": found}),
    )
    told: Any = None

    def perform(self, ticket: int, request: Fact) -> Reply:
        """Look."""
        self.send(Datum(("found", "box-7", "shelf")))
        return Reply("okay")

    def truth(self) -> Mapping[str, list[Fact]]:
        """Return the facts of the test."""
        return self.told  # type: ignore[no-any-return]


def wrong(told: Any, *facts: Fact, task: str | None = None) -> list[tuple[Any, ...]]:
    world = Room()
    world.told = told
    run = LIBRARY.start(world, facts=facts, tasks=[task] if task else [])
    run.run()
    return [(one.fact, *one.truth) for one in run.wrong_beliefs()]


HERE, THERE = ("robot-at", "lab"), ("robot-at", "hall")


def test_other_value_of_a_property_is_wrong() -> None:
    assert wrong({"robot-at": [THERE]}, HERE) == [(HERE, THERE)]


def test_one_of_two_true_values_is_right() -> None:
    assert wrong({"robot-at": [THERE, HERE]}, HERE) == []


def test_value_that_the_truth_does_not_have_is_wrong() -> None:
    assert wrong({"robot-at": []}, HERE) == [(HERE,)]


def test_default_value_is_no_belief() -> None:
    assert wrong({"robot-at": [THERE]}, ("robot-at", "unknown")) == []
    assert wrong({"lid": [("lid", "b", "open")]}, ("lid", "b", "closed")) == []


def test_proposition_is_wrong_if_the_truth_lacks_it() -> None:
    one, other = ("on-tray", "milk", "w1"), ("on-tray", "milk", "w2")
    assert wrong({"on-tray": [one]}, one, other) == [(other,)]


def test_facts_of_other_names_are_not_compared() -> None:
    assert wrong({"robot-at": []}, ("liked", "milk")) == []


def test_items_are_compared_by_sensor_name() -> None:
    right = {"location": [("location", "box-7", "shelf")]}
    moved = {"location": [("location", "box-7", "floor")]}
    assert wrong(right, task="(look-around)") == []
    ((belief, truth),) = wrong(moved, task="(look-around)")
    assert (belief[2], truth) == ("shelf", ("location", "box-7", "floor"))


def test_item_out_of_reach_is_not_compared() -> None:
    world = Room()
    world.told = {"location": []}
    run = LIBRARY.start(world, tasks=["(look-around)"])
    run.run()
    assert len(run.wrong_beliefs()) == 1
    run.move(run.memory.items()[0].name, None)
    assert run.wrong_beliefs() == []


def test_wrong_beliefs_are_a_figure_of_the_world() -> None:
    world = Room()
    world.told = {"robot-at": [THERE]}
    run = LIBRARY.start(world, facts=[HERE])
    assert run.figures() == {"wrong-beliefs": 1}


def test_world_without_truth_has_no_such_figure() -> None:
    class Mute(SimpleWorld):
        """A world without truth."""

        name, kit = "room", Room.kit

        def perform(self, ticket: int, request: Fact) -> Reply:
            """Look."""
            return Reply("okay")

    assert LIBRARY.start(Mute()).figures() == {}
    assert LIBRARY.start(Mute(), facts=[HERE]).wrong_beliefs() == []


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ([], "the truth of the world `room` is `\\[\\]`, not a mapping"),
        ({"robot-at": [("hall",)]}, "a true fact of 'robot-at'"),
        ({"robot-at": ["hall"]}, "a true fact of 'robot-at'"),
        ({"robot-at": 3}, "the world `room` failed"),
    ],
)
def test_invalid_truth_is_refused_with_its_place(told: Any, said: str) -> None:
    with pytest.raises(rapc.PortError, match=f"{said}.*test_truth.py"):
        wrong(told, HERE)


@pytest.mark.parametrize(
    ("library", "world", "agenda"),
    [
        ("examples/courier", "courier", "shift"),
        ("stdlib/hallway", "hallway", "errand"),
        ("stdlib/truck", "truck", "nine-orders"),
    ],
)
def test_sound_libraries_end_without_wrong_beliefs(
    library: str, world: str, agenda: str
) -> None:
    result = rapc.run(rapc.load(library), world, agenda=agenda, seed=1)
    assert result.run.figures()["wrong-beliefs"] == 0
