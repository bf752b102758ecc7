"""Every method of the port goes through the one world that is held to its word."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

import rapc.runtime
import rapc.world
from rapc.debug.acts import ForcedWorld
from rapc.errors import PortError
from rapc.runtime.held_world import HeldWorld
from rapc.world import OPTIONAL, Finished, Reply, World, Wrapper, methods_of
from tests.worlds.broken_worlds import Good

CALLS: dict[str, tuple[Any, ...]] = {
    "perform": (1, ("look", "one")),
    "cancel": (1,),
    "advance": (1,),
    "activate": (1, (), ()),
    "deactivate": (1,),
    "usual_time": (("look", "one"),),
    "restore": (b"",),
    "adjust": ("size", 1),
    "resume": ((), 0),
    "acknowledge": (0,),
}
"""What the methods of the port are called with; the others with nothing."""

METHODS = [name for protocol in (World, *OPTIONAL) for name in methods_of(protocol)]


class Answer(Exception):
    """Raised by each method of a world that is called."""


def _world(answer: Callable[[str, Sequence[object]], object]) -> Any:
    """Return a world with the whole port, each of whose methods runs `answer`."""

    def method(name: str) -> Callable[..., object]:
        def call(*given: object) -> object:
            return answer(name, given[1:])

        return call

    code = {name: method(name) for name in METHODS}
    return type("Whole", (Good,), code)(None, {})


def test_the_optional_protocols_are_those_of_the_port() -> None:
    protocols = {
        value
        for value in vars(rapc.world).values()
        if getattr(value, "_is_runtime_protocol", False)
    }
    assert set(OPTIONAL) == protocols


@pytest.mark.parametrize("name", METHODS)
def test_a_wrapper_passes_each_method_on(name: str) -> None:
    told: list[tuple[str, Sequence[object]]] = []

    def tell(name: str, given: Sequence[object]) -> None:
        told.append((name, given))
        raise Answer

    world = Wrapper(_world(tell))
    with pytest.raises(Answer):
        getattr(world, name)(*CALLS.get(name, ()))
    assert told == [(name, CALLS.get(name, ()))]


@pytest.mark.parametrize("name", METHODS)
def test_exception_of_each_method_is_a_fault_of_the_world(name: str) -> None:
    def answer(name: str, given: Sequence[object]) -> object:
        raise Answer

    def call(held: Any) -> None:
        try:
            getattr(held, name)(*CALLS.get(name, ()))
        except Answer as error:  # as the interpreter does, for calls inside of a run
            held.blame(error)

    with pytest.raises(PortError, match=r"failed at test_held_world.py:\d+: Answer"):
        call(HeldWorld(_world(answer)))


RETURN_NOTHING = {
    *("cancel", "advance", "deactivate", "restore", "adjust", "acknowledge"),
}


@pytest.mark.parametrize("name", [m for m in METHODS if m not in RETURN_NOTHING])
def test_each_answer_of_another_type_is_told(name: str) -> None:
    held: Any = HeldWorld(_world(lambda *_: 1j))
    with pytest.raises(PortError, match=rf"`{name}` \(test_held_world.py:\d+\)"):
        getattr(held, name)(*CALLS.get(name, ()))


def test_a_late_end_is_one_of_a_request_under_way() -> None:
    held = HeldWorld(Good(None, {}))
    held.check_end(Finished(1, Reply("okay")), {1: (None, ("look", "one"))})
    with pytest.raises(PortError, match="not under way: 2"):
        held.check_end(Finished(2, Reply("okay")), {1: (None, ("look", "one"))})


def test_another_world_may_be_put_behind() -> None:
    held = HeldWorld(Good(None, {}))
    held.enclose(ForcedWorld(held.behind))
    held.advance(3)
    assert held.clock() == held.now() == held.behind.behind.now() == 3


def test_no_other_module_of_the_runtime_accuses_a_world() -> None:
    """Only `held_world` has what tells that a world broke its word.

    Others accuse handlers, solvers and comparators.
    """
    folder = Path(rapc.runtime.__path__[0])
    for path in folder.rglob("*.py"):
        if path.name == "held_world.py":
            continue
        used = {
            node.func.attr
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
        }
        assert not used & {"breach", "wrong_type"}, path
