"""Declared kinds are held wherever a fact or a goal comes in from outside."""

from __future__ import annotations

import re

import pytest

from rapc.errors import FactError, RefusedError, TextError
from tests.runtime.helpers import Play, row

LIBRARY = """
(declare-kind door (front back))
(declare-memory-property shut ((?door door) ?value) false)
(declare-memory-proposition weighs (?thing (?kilos number)))
(define-rap (top) (succeed (go)) (method (primitive (act x))))
(define-rap (pass (?door door)) (succeed (go)) (method (primitive (act ?door))))
"""


@pytest.mark.parametrize(
    ("fact", "said"),
    [
        (("shut", "side", "true"), "`side`"),
        (("shut", "side"), "`side`"),
        (("weighs", "box", "much"), "`much`"),
    ],
)
def test_a_fact_of_the_host_is_refused(fact: tuple[str, ...], said: str) -> None:
    """Whether it is asserted or only looked at; memory stays as it was."""
    interpreter = Play(LIBRARY).interpreter
    with pytest.raises(FactError, match=said):
        interpreter.check_fact(*fact)
    with pytest.raises(FactError, match=said):
        interpreter.assert_fact(*fact)
    assert not list(interpreter.memory.query(fact[0], None, None))


@pytest.mark.parametrize(
    "fact", [("shut", "front"), ("shut", "unknown", "true"), ("weighs", "box", 3)]
)
def test_value_of_the_declared_kind_is_accepted(fact: tuple[str | int, ...]) -> None:
    """`unknown` is of every kind."""
    interpreter = Play(LIBRARY).interpreter
    interpreter.assert_fact(*fact)
    assert list(interpreter.memory.query(str(fact[0]), None, None))


def test_a_goal_is_refused_before_anything_runs() -> None:
    """A goal of another kind never becomes a task."""
    with pytest.raises(RefusedError, match="`side`"):
        Play(LIBRARY, "(pass side)")
    assert Play(LIBRARY, "(pass back)").run(cycles=1).told("asked") == [
        "asked (act back)"
    ]


@pytest.mark.parametrize(
    ("question", "said"),
    [
        (
            "(shut side ?x)",
            "`side` is not a value of kind door, as declared for `?door` in `(shut",
        ),
        ("(not (believe (shut side true) 5))", "`side` is not a value of kind door"),
        ("(weighs ?box much)", "`much` is not a value of kind number"),
    ],
)
def test_host_query_with_wrong_kind_is_refused(question: str, said: str) -> None:
    """The reason is that of the refusal of a fact."""
    interpreter = Play(LIBRARY).interpreter
    with pytest.raises(TextError, match=re.escape(said)):
        interpreter.question(question)
    assert interpreter.question("(shut front ?x)").all() == [{"?x": "false"}]
    assert not interpreter.question("(shut unknown true)").holds()


def test_a_fact_of_a_world_is_refused() -> None:
    """What a script asserts comes through the same gate as what handlers assert."""
    play = Play(LIBRARY, "(top)", rows=[row("(act x)", asserts=["(shut side true)"])])
    with pytest.raises(Exception, match="`side`"):
        play.run()
