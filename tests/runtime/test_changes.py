"""Changes of memory without handlers: by declaration, and as data."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import rapc
from rapc.runtime.settings import Settings
from rapc.world import Change, Datum, Fact, Handlers, Kit, Offer, Reply, SimpleWorld

LIBRARY = """
(declare-primitive press (?lamp) (okay stuck)
  :on (okay (not (dark ?lamp)) (lit ?lamp) (state ?lamp on)))
(declare-primitive put (?item ?place) (okay) :on (okay (location ?item ?place)))
(declare-primitive look () (okay) :tells (seen))
(declare-sensor-datum seen (?item ?place) :on ((location ?item ?place)))
(declare-sensor-datum noise (?lamp) :on ((may (dark ?lamp))))
(declare-memory-proposition lit (?lamp))
(declare-memory-proposition dark (?lamp))
(declare-memory-property state (?lamp ?state) unknown)
(declare-memory-property class (?item ?class ?value) false)
(declare-memory-property location (?item ?place) unknown)
(define-rap (light ?lamp) (method (primitive (press ?lamp))))
(define-rap (search) (method (primitive (look))))
(define-rap (move ?kind ?place)
  (method (context (and (class ?item ?kind) (location ?item ?from)))
          (primitive (put ?item ?place))))
"""
OFFER = Offer(
    {"press": (1, ("okay", "stuck")), "put": (2, ("okay",)), "look": (0, ("okay",))},
    {"seen": 2, "noise": 1},
)
INTRODUCED: tuple[Change, ...] = (("introduce", "cup-1", "cup", "shelf"),)


def run(
    *tasks: str,
    answers: Callable[[Fact], Reply] = lambda request: Reply("okay"),
    handlers: Handlers | None = None,
    strict: bool = True,
) -> rapc.Interpreter:
    def perform(world: Any, ticket: int, request: Fact) -> Reply:
        return answers(request)

    world = SimpleWorld(perform=perform, kit=Kit(OFFER, handlers or Handlers()))
    settings = Settings(strict=strict)
    library = rapc.loads(LIBRARY)
    return rapc.run(library, world, list(tasks), settings=settings).run


def test_a_result_without_handler_has_its_declared_effects() -> None:
    memory = run("(light lamp-1)").memory
    assert list(memory) == [("lit", "lamp-1"), ("state", "lamp-1", "on")]


def test_an_undeclared_result_changes_nothing() -> None:
    assert list(run("(light lamp-1)", answers=lambda _: Reply("stuck")).memory) == []


def test_a_handler_replaces_the_declared_effects() -> None:
    def pressed(memory: Any, request: Fact, result: str) -> None:
        memory.assert_fact("state", request[1], "off")

    handlers = Handlers({"press": pressed})
    memory = run("(light lamp-1)", handlers=handlers, strict=False).memory
    assert list(memory) == [("state", "lamp-1", "off")]


def test_declared_location_moves_an_introduced_item() -> None:
    made = run(
        "(search)",
        "(move cup table)",
        answers=lambda request: Reply(
            "okay", (), INTRODUCED if request[0] == "look" else None
        ),
    )
    (item,) = made.memory.items()
    assert item.kind == "cup"
    assert made.memory.value("location", item.name) == "table"


def test_a_datum_without_handler_has_its_declared_effects() -> None:
    seen = Reply("okay", (("seen", "cup", "table"),))
    memory = run("(search)", answers=lambda _: seen).memory
    assert list(memory) == [("location", "cup", "table")]


def test_a_datum_with_possible_effects_requires_a_handler() -> None:
    noise = Reply("okay", (("noise", "lamp-1"),))
    with pytest.raises(rapc.PortError, match="has no handler for its datum noise"):
        run("(light lamp-1)", answers=lambda _: noise, strict=False)


def test_changes_as_data_replace_the_declared_effects() -> None:
    off = Reply("okay", (), (("assert", "state", "lamp-1", "off"),))
    memory = run("(light lamp-1)", answers=lambda _: off, strict=False).memory
    assert list(memory) == [("state", "lamp-1", "off")]


def test_changes_as_data_follow_the_handler() -> None:
    def pressed(memory: Any, request: Fact, result: str) -> str:
        memory.assert_fact("state", request[1], "off")
        return "stuck"

    more = Reply("okay", (), (("erase", "state"), ("assert", "dark", "lamp-1")))
    made = run(
        "(light lamp-1)",
        answers=lambda _: more,
        handlers=Handlers({"press": pressed}),
        strict=False,
    )
    assert list(made.memory) == [("dark", "lamp-1")]
    assert made.results()[0].outcome == "failed"


def test_each_change_as_data_acts_like_its_method() -> None:
    changes = (
        ("introduce", "cup-1", "cup", "shelf"),
        ("introduce", "cup-2", "cup", "shelf"),
        ("move", "cup-1", "table"),
        ("lose", "cup-2"),
        ("arrive", "kitchen"),
        ("expire",),
    )
    memory = run("(search)", answers=lambda _: Reply("okay", (), changes)).memory
    one, other = memory.items()
    assert memory.place == "kitchen"
    assert memory.value("location", one.name) == "table"
    assert memory.value("location", other.name) == "unknown"
    assert not one.accessible


def test_strict_mode_refuses_undeclared_changes_as_data() -> None:
    dark = Reply("okay", (), (("assert", "dark", "lamp-1"),))
    wanted = r"handler of `press`.*without Python code.*asserted \(dark lamp-1\)"
    with pytest.raises(rapc.PortError, match=wanted):
        run("(light lamp-1)", answers=lambda _: dark)


def test_a_datum_with_changes_needs_no_handler() -> None:
    class Noisy(SimpleWorld):
        kit = Kit(OFFER)

        def perform(self, ticket: int, request: Fact) -> Reply:
            self.send(Datum(("noise", "lamp-1"), (("assert", "dark", "lamp-1"),)))
            return Reply("stuck")

    library = rapc.loads(LIBRARY)
    ended = rapc.run(library, Noisy(), "(light lamp-1)", settings=Settings(strict=True))
    assert list(ended.run.memory) == [("dark", "lamp-1")]


@pytest.mark.parametrize(
    "change",
    [
        ("forget", "lit"),
        ("assert",),
        ("introduce", "cup-1", "cup"),
        ("introduce", 1, "cup", "shelf"),
        ("move", 3, "shelf"),
        ("expire", "now"),
        ["assert", "lit", "lamp-1"],
    ],
)
def test_invalid_change_is_refused(change: Any) -> None:
    answer = Reply("okay", (), (change,))
    with pytest.raises(rapc.PortError, match=r"the reply to \(look\)"):
        run("(search)", answers=lambda _: answer)


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        (("assert", "bright", "lamp-1"), "bright"),
        (("assert", "lit"), "lit"),
        (("move", "cup-9", "shelf"), "no handler has introduced an item `cup-9`"),
    ],
)
def test_undeclared_change_names_the_request(change: Change, wanted: str) -> None:
    answer = Reply("okay", (), (change,))
    with pytest.raises(rapc.PortError) as caught:
        run("(search)", answers=lambda _: answer)
    assert "by (look) in the world `simple`" in caught.value.message
    assert wanted in caught.value.message
