"""What is refused before the first cycle, and how it is said [L 1]."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from rapc.compiler.program import Program
from rapc.errors import RefusedError
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import read_task_request
from rapc.world import World
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld

from .helpers import DECLARATIONS, compiled

WORLD = ScriptedWorld(
    [
        Row(("act", "?")),
        Row(("look", "?")),
        Row(("slow", "?")),
        Row(("wave", "?"), signals=((":bump", "left"),)),
    ]
)
"""It offers `act`, `look`, `slow`, `wave` and `:bump`, each with one argument."""


def reasons(
    text: str,
    task: str = "",
    functions: Mapping[str, Callable[..., Any]] | None = None,
    world: World = WORLD,
) -> tuple[str, ...]:
    """Why a library, or a task of it, is refused; nothing if it is not."""
    library: Program = compiled(text)
    try:
        run = Interpreter(library, world, functions=functions)
        if task:
            run.check([read_task_request(task)])
    except RefusedError as refused:
        return refused.reasons
    return ()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (
            "(declare-primitive wav (?x) (okay))",
            "t.rap:11:1: in the world `scripted` unknown primitive `wav`; "
            "did you mean `wave`?",
        ),
        (
            "(declare-primitive wave (?x ?y) (okay))",
            "t.rap:11:1: in the world `scripted` `wave` takes 1 argument, not 2",
        ),
        (
            "(declare-sensor-datum seen (?x))",
            "t.rap:11:1: in the world `scripted` unknown sensor datum `seen`",
        ),
        (
            "(declare-event :bumps (?x))",
            "t.rap:11:1: in the world `scripted` unknown event `:bumps`; "
            "did you mean `:bump`?",
        ),
        (
            "(declare-event :bump ())",
            "t.rap:11:1: in the world `scripted` `:bump` takes 1 argument, not 0",
        ),
        (
            "(declare-skill :roll (?x))",
            "t.rap:11:1: in the world `scripted` unknown skill `:roll`",
        ),
        (
            "(declare-memory-function near (?x ?y))",
            "t.rap:11:1: unknown function `near`",
        ),
        (
            "(declare-memory-function weigh (?index))"
            "(declare-memory-property weight (?x ?value) weigh)",
            "t.rap:11:1: unknown function `weigh`",
        ),
        (
            "(declare-indistinct-class cup looks)",
            "t.rap:11:1: unknown comparator `looks`",
        ),
    ],
)
def test_missing_parts_of_world_or_host_are_reported(text: str, reason: str) -> None:
    assert DECLARATIONS.count("\n") == 10
    assert reasons(text) == (reason,)


def test_a_library_for_another_world_is_refused_in_one_line() -> None:
    """Up to three names are told one by one, and more than half of all must lack."""
    text = "".join(f"(declare-primitive do-{n} () (okay))\n" for n in range(9))
    known = "(declare-primitive wave (?x) (okay))"
    others = "(declare-sensor-datum seen (?x))"
    assert reasons(text + others) == (
        "t.rap:11:1: the library is not for the world `scripted`: 10 of its 13 "
        "primitives and sensor data are missing: `do-0`, `do-1`, `do-2` and 7 more",
    )
    assert len(reasons(text + known)) == 1
    three = "".join(text.splitlines(keepends=True)[:3])
    assert len(reasons(three)) == 3
    four = "".join(text.splitlines(keepends=True)[:4])
    assert len(reasons(four)) == 1


def test_library_error_names_each_missing_name() -> None:
    names = "".join(f"(declare-primitive wave{n} (?x) (okay))\n" for n in range(9))
    known = [f"wave{n}" for n in range(5)]
    world = ScriptedWorld(
        [Row((name, "?")) for name in ("act", "look", "slow", *known)]
    )
    assert len(reasons(names, world=world)) == 4


def test_complete_library_is_not_refused() -> None:
    text = """
        (declare-primitive wave (?x) (okay))
        (declare-event :bump (?side))
        (declare-memory-function near (?x))
        (declare-memory-function weigh (?index))
        (declare-memory-property weight (?x ?value) weigh)
        """
    functions = {"near": lambda view, thing: True, "weigh": lambda view, index: 0}
    assert reasons(text, functions=functions) == ()


STEPS = """
(define-rap (easy) (method (task-net)))
(define-rap (hard)
  (method (task-net (t1 (middle)))))
(define-rap (middle)
  (method (context nil) (task-net (t1 (easy)) (t2 (hard)) (t3 (gone)))))
"""


def test_task_with_a_reachable_step_without_rap_is_refused() -> None:
    assert reasons(STEPS, "(easy)") == ()
    assert reasons(STEPS, "(hard)") == ("t.rap:16:63: unknown RAP `gone`",)


class Unskilled(ScriptedWorld):
    """A world that offers skills, and cannot switch them on."""

    name = "unskilled"
    activate = None  # type: ignore[assignment]


def test_skills_are_refused_in_a_world_without_skills() -> None:
    world = Unskilled([Row((":roll", "?x"), kind="enable")])
    assert (
        "the world `unskilled` cannot run skills: it has no `activate` or no "
        "`deactivate` method"
    ) in reasons("(declare-skill :roll (?x))", world=world)


@pytest.mark.parametrize(
    ("task", "reason"),
    [
        ("(eazy)", "unknown RAP `eazy`; did you mean `easy`?"),
        ("(easy now)", "`easy` has no inputs, not 1"),
    ],
)
def test_task_without_rap(task: str, reason: str) -> None:
    assert reasons(STEPS, task) == (reason,)


def test_default_that_is_the_name_of_an_undeclared_function_is_refused() -> None:
    text = "(declare-memory-property weight (?x ?value) weigh)"
    [reason] = reasons(text, functions={"weigh": lambda view, index: 0})
    assert reason == (
        "t.rap:11:1: the default `weigh` of `weight` is a constant, but a function has "
        "the same name: add `(declare-memory-function weigh (?index))`"
    )
