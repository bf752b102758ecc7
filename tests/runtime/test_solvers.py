"""Problem solvers that add methods [L 3.34] [T 7.4.1]."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
import pytest

import rapc
from rapc.ir import nodes

from .helpers import compiled, play, row


def method(text: str) -> nodes.Method:
    """A method from text."""
    library = compiled(f"(define-rap (for-its-method) {text})").library
    return library.raps["for-its-method"].methods[0]


def test_a_solver_is_asked_when_no_method_holds_and_adds_methods() -> None:
    asked: list[Any] = []

    def solver(goal: Any, view: Any) -> Sequence[nodes.Method]:
        asked.append((goal, view.query("p", None)))
        return [method("(method new (primitive (look ?x)))")]

    text = """
        (define-rap (top ?x) (succeed (p done))
          (method old (context (p old)) (primitive (act ?x))))
        """
    ran = play(
        text,
        "(top 3)",
        facts=["(p b)"],
        solvers={"top": solver},
        rows=[row("(look 3)", asserts=["(p done)"])],
    )
    assert asked == [(("top", 3), [("p", "b")])]
    assert ran.told("solver", "chosen", "asked") == [
        "solver (top 3) 1",
        "chosen top new",
        "asked (look 3)",
    ]


def test_a_returned_method_stays_in_the_run_for_other_tasks() -> None:
    calls: list[Any] = []

    def solver(goal: Any, view: Any) -> Sequence[nodes.Method]:
        calls.append(goal)
        return [method("(method (primitive (act ?x)))")]

    text = "(define-rap (top ?x) (method (context (p no)) (task-net)))"
    ran = play(text, "(top 1)", "(top 2)", solvers={"top": solver})
    assert len(calls) == 1
    assert sorted(ran.told("asked")) == ["asked (act 1)", "asked (act 2)"]
    assert ran.told("chosen") == ["chosen top #2", "chosen top #2"]


def test_solver_method_equal_to_an_existing_one_is_not_added() -> None:
    def solver(goal: Any, view: Any) -> Sequence[nodes.Method]:
        return [method("(method one (context (p yes)) (task-net))")]

    text = "(define-rap (top) (method one (context (p yes)) (task-net)))"
    ran = play(text, "(top)", solvers={"top": solver})
    assert ran.told("solver", "failed") == [
        "solver (top) 1",
        "failed (top) no-method no-method",
    ]


def test_solver_is_called_only_without_applicable_method() -> None:
    def solver(goal: Any, view: Any) -> Sequence[nodes.Method]:
        raise AssertionError("nobody should ask")

    one = "(define-rap (top) (method (task-net)))"
    assert play(one, "(top)", solvers={"top": solver}).told("failed") == []
    two = "(define-rap (top) (repeat-while (p no)) (method (context nil) (task-net)))"
    ran = play(two, "(top)", solvers={"top": solver})
    assert ran.told("failed") == ["failed (top) no-method no-method"]


WRONG = {
    "(method (task-net (t1 (nowhere))))": "`nowhere`",
    "(method (task-net (t1 (top 1 2))))": "`top` has 1 input, not 2",
    "(method (primitive (fly ?x)))": "`fly`",
    "(method (context (flown ?x)) (task-net))": "`flown`",
    "(method (notations (flown ?x)) (task-net))": "`flown`",
    "(method (primitive (enable (:hover))))": "`:hover`",
}


@pytest.mark.parametrize("text", WRONG)
def test_solver_returning_an_invalid_method_is_named(text: str) -> None:
    def solver(goal: Any, view: Any) -> Sequence[nodes.Method]:
        return rapc.methods(text)

    said = rf"the solver of `top` .{Path(__file__).name}:\d+. returned a method that .*"
    with pytest.raises(rapc.PortError, match=said + WRONG[text]):
        play("(define-rap (top ?x))", "(top 1)", solvers={"top": solver})


def test_solver_with_a_method_made_of_other_values_is_blamed() -> None:
    def solver(goal: Any, view: Any) -> Sequence[nodes.Method]:
        [made] = rapc.methods("(method (task-net))")
        return [msgspec.structs.replace(made, notations=3)]

    with pytest.raises(rapc.PortError, match=r"the solver of `top`.*cannot be run"):
        play("(define-rap (top ?x))", "(top 1)", solvers={"top": solver})
