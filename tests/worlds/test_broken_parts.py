"""Optional parts of the port that break: saving, pictures, figures, options."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

import rapc
from rapc.debug.acts import ChangeOption, changeable_options
from rapc.debug.history import History
from rapc.runtime.held_world import HeldWorld
from rapc.runtime.truth import figures_of
from rapc.world import Option, Picture
from rapc.worlds.faults import FaultyWorld
from tests.worlds.broken_worlds import (
    HERE,
    LIBRARY,
    Good,
    answers,
    boom,
    leave,
    with_,
)


class Saved(Good):
    """A world that can be saved."""

    name = "bad"

    def save(self) -> Any:
        return str(self.time).encode()

    def restore(self, state: bytes) -> None:
        self.time = int(state)


SAVES = {
    "raises": ("save", boom, f"the world `bad` failed at {HERE}:.*KeyError"),
    "returns a text": ("save", answers("0"), "saved state .* is `'0'`, not bytes"),
    "restores nothing": ("restore", leave, f"failed at {HERE}:.*SystemExit"),
}


@pytest.mark.parametrize("faulty", [False, True])
@pytest.mark.parametrize("case", SAVES)
def test_world_failing_in_save_or_restore_is_named(case: str, faulty: bool) -> None:
    call, code, said = SAVES[case]
    world: Any = type("Bad", (Saved,), {call: code})(None, {})
    if faulty:
        world = FaultyWorld(world, [], seed=0)
    going = rapc.loads(LIBRARY).start(world, tasks="(compare)")
    with pytest.raises(rapc.PortError, match=said) as caught:
        going.restore(going.save())
    assert f"{HERE}:" in caught.value.message
    assert going.run() == "done"


def test_run_of_an_unsavable_world_can_be_stepped() -> None:
    world = type("Bad", (Saved,), {"save": boom})
    session = History.open(rapc.loads(LIBRARY), world, tasks="(compare)")
    session.step(3)
    assert session.cycle == 3
    with pytest.raises(rapc.StateError, match="cannot go back: the world `bad` failed"):
        session.goto(0)


class Adjusted(Good):
    """A world with an option that can be changed, and a figure."""

    name = "bad"
    kit = msgspec.structs.replace(
        Good.kit, options=(Option("size", "number", 1, "", ""),)
    )

    def adjustable(self) -> Any:
        return {"size": 1}

    def adjust(self, name: str, value: Any) -> None:
        return None

    def figures(self) -> Any:
        return {"size": 1}


@pytest.mark.parametrize("code", [boom, answers(3)])
def test_world_failing_in_adjustable_is_named(code: Any) -> None:
    world = type("Bad", (Adjusted,), {"adjustable": code})
    going = rapc.loads(LIBRARY).start(world)
    with pytest.raises(rapc.PortError, match=f"the world `bad` failed.*{HERE}:"):
        changeable_options(going)


def test_world_failing_in_adjust_is_named() -> None:
    world = type("Bad", (Adjusted,), {"adjust": boom})
    going = rapc.loads(LIBRARY).start(world)
    with pytest.raises(rapc.PortError, match=f"the world `bad` failed.*{HERE}:"):
        ChangeOption("bad", "size", 2).do(going)


def test_adjusted_option_of_kind_text_is_a_str() -> None:
    told: list[Any] = []
    named = msgspec.structs.replace(
        Good.kit, options=(Option("size", "text", "", "", ""),)
    )
    adjust = {"adjust": lambda *given: told.append(given[2]), "kit": named}
    world = type("Kept", (Adjusted,), adjust)
    ChangeOption("bad", "size", "a b").do(rapc.loads(LIBRARY).start(world))
    assert told == ["a b"]


@pytest.mark.parametrize("code", [boom, answers(3), answers({3: object()})])
def test_world_failing_in_figures_is_named(code: Any) -> None:
    world: Any = type("Bad", (Adjusted,), {"figures": code})
    with pytest.raises(rapc.PortError, match=f"the world `bad` failed.*{HERE}:"):
        figures_of(world(None, {}))


PICTURES = {
    "a number": (answers(5), "the picture of .* is `5`, not a `Picture`"),
    "spots that are none": (
        answers(Picture("here", (5,))),  # type: ignore[arg-type]
        "cannot be drawn: .*spots",
    ),
    "an error": (boom, f"the world `bad` failed at {HERE}:.*KeyError"),
}


@pytest.mark.parametrize("case", PICTURES)
def test_world_without_a_true_picture_is_blamed(case: str) -> None:
    code, said = PICTURES[case]
    world: Any = HeldWorld(with_(picture=code)(None, {}))  # type: ignore[call-arg]
    with pytest.raises(rapc.PortError, match=said) as caught:
        world.picture()
    assert f"{HERE}:" in caught.value.message
