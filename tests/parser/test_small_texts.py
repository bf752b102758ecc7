"""Facts, patterns and goals as they stand on a command line."""

from __future__ import annotations

import pytest

from rapc.base.values import Text
from rapc.errors import TextError
from rapc.ir import nodes
from rapc.parser.parse import parse_fact, parse_goal_options, parse_pattern


def test_fact() -> None:
    assert parse_fact('(Size box-1 2.0 -0.5 "Big")') == (
        *("size", "box-1", 2, -0.5),
        Text("Big"),
    )


def test_pattern() -> None:
    made = parse_pattern(" (size ?x (+ 1 2)) ; of something ")
    call = nodes.Call("+", (nodes.Const(1), nodes.Const(2)))
    assert made == nodes.Proposition("size", (nodes.Var("?x"), call))


def test_goal_with_options() -> None:
    made, options = parse_goal_options(
        "(fetch box => ?p) :priority 4 :deadline 290.5 :AT 120 :background true"
    )
    assert made == nodes.Goal("fetch", (nodes.Const("box"),), (nodes.Var("?p"),))
    assert options == {
        "priority": 4,
        "deadline": 290.5,
        "at": 120,
        "background": "true",
    }


def test_goal_alone() -> None:
    assert parse_goal_options("(wait)") == (nodes.Goal("wait", (), ()), {})


BAD_FACTS = [
    ("", "the text is empty"),
    ("; nothing", "the text is empty"),
    ("box", "expected a proposition, not a symbol: box"),
    ("()", "expected a proposition, not an empty list: ()"),
    ("(p ?x)", "expected only values in a fact, not a variable: (p ?x)"),
    ("(p (+ 1 2))", "expected only values in a fact, not a computed term: (p (+ 1 2))"),
    ("(not (p))", "`not` cannot be the name of a proposition: (not (p))"),
    ("(p) (q)", "expected one proposition: (p) (q)"),
    ("(p", "the list of `p` is not closed: (p"),
    ("(p 'x)", "unexpected `'`: (p 'x)"),
    (
        "(" * 3000,
        f"lists are nested more than 100 levels deep: {'(' * 200}...",
    ),
]


@pytest.mark.parametrize(("text", "message"), BAD_FACTS)
def test_bad_fact_is_refused_in_one_line(text: str, message: str) -> None:
    with pytest.raises(TextError) as caught:
        parse_fact(text)
    assert str(caught.value) == message


BAD_GOALS = [
    ("fetch", "expected a goal, not a symbol: fetch"),
    ("(fetch) 4", "expected an option that begins with a colon, not 4"),
    ("(fetch) :priorty 4", "unknown option :priorty; did you mean :priority?"),
    ("(fetch) :priority", "expected a number after :priority"),
    ("(fetch) :priority high", "expected a number after :priority"),
    ("(fetch) :priority 0.5", "expected an integer after :priority"),
    ("(fetch) :at 1 :at 2", "duplicate option :at"),
    ("(fetch) :background yes", "expected true or false after :background"),
]


@pytest.mark.parametrize(("text", "message"), BAD_GOALS)
def test_bad_goal_is_refused_in_one_line(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=r"^.*$") as caught:
        parse_goal_options(text)
    assert str(caught.value) == message
