"""Functions that a host registers: what they are given, what they may return."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from rapc.base.values import Text

from .helpers import play

TEXT = """
(declare-memory-function made (?x) :reads (p))
(declare-memory-function made-weight (?index))
(declare-memory-property weight (?item ?value) made-weight)
(define-rap (top ?x)
  (succeed (last-result okay))
  (method (context (q ?x ?y)) (primitive (act (made ?y)))))
(define-rap (ask ?x)
  (method (context (and (= (made ?x) ?x) (p ?x))) (primitive (look ?x))))
(define-rap (weigh ?x)
  (method (context (weight ?x ?w)) (primitive (act ?w))))
"""


def asked(task: str, function: Callable[..., Any]) -> tuple[list[str], list[str]]:
    """What is asked of the world, and the faults, if a function does so."""
    ran = play(
        TEXT,
        task,
        facts=["(q a b)", "(p 2)", "(p a)"],
        functions={"made": function, "made-weight": function},
    )
    return ran.told("asked"), ran.told("fault")


@pytest.mark.parametrize(
    ("returned", "told"),
    [(2.0, "2"), (0.5, "0.5"), ("word", "word"), (7, "7"), (Text("hi"), '"hi"')],
)
def test_function_must_return_a_value(returned: Any, told: str) -> None:
    requests, faults = asked("(top a)", lambda view, thing: returned)
    assert (requests, faults) == ([f"asked (act {told})"], [])


@pytest.mark.parametrize("returned", [None, True, float("inf"), ["a"], object()])
def test_invalid_value_is_a_fault(returned: Any) -> None:
    requests, faults = asked("(top a)", lambda view, thing: returned)
    assert requests == []
    assert "primitive at t.rap" in faults[0]
    requests, faults = asked("(ask a)", lambda view, thing: returned)
    assert requests == []
    assert "context of method `#1`" in faults[0]
    requests, faults = asked("(weigh a)", lambda view, index: returned)
    assert requests == []
    assert "context of method `#1`" in faults[0]


def test_a_function_gets_a_view_of_memory_and_its_arguments() -> None:
    def sees(view: Any, thing: Any) -> Any:
        assert view.query("q", None, None) == [("q", "a", "b")]
        assert view.now == 0
        return thing

    assert asked("(ask 2)", sees) == (["asked (look 2)"], [])


def test_a_default_function_gets_the_index() -> None:
    def weight(view: Any, index: Any) -> Any:
        assert index == ("weight", "crate")
        return 12.0

    assert asked("(weigh crate)", weight) == (["asked (act 12)"], [])
