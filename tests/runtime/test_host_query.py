"""What a host asks of memory: answers in order, given values, and what is refused."""

from __future__ import annotations

import re

import pytest

from rapc.base.resources import Value
from rapc.compiler.program import Program
from rapc.library.loader import load_text
from rapc.runtime.interpreter import Interpreter
from rapc.worlds.scripted import ScriptedWorld

LIBRARY = """\
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property full (?bay ?value) false)
(declare-memory-proposition near (?place ?other))
(declare-memory-function double)
"""


def run() -> Interpreter:
    """A run that knows where three boxes are."""
    library = Program(load_text(LIBRARY).library)
    world = ScriptedWorld([], declared=library.library)
    double = {"double": lambda view, number: number * 2}
    interpreter = Interpreter(library, world, functions=double)
    for item, place in (("box-1", "dock"), ("box-2", "barn"), ("box-3", "dock")):
        interpreter.assert_fact("location", item, place)
    interpreter.assert_fact("near", "dock", "barn")
    return interpreter


def test_given_tasks_start_in_their_order() -> None:
    ask = run().question("(and (near ?a ?b) (location ?x ?b))", "?b", "?a")
    assert ask.given == ("?b", "?a")
    assert ask.first("barn", "dock") == {"?x": "box-2"}
    assert ask.first("dock", "barn") is None
    assert ask.holds("barn", "dock")
    assert not ask.holds("barn", "barn")


def test_answers_follow_memory() -> None:
    interpreter = run()
    ask = interpreter.question("(location ?x ?p)", "?p")
    assert ask.all("dock") == [{"?x": "box-1"}, {"?x": "box-3"}]
    interpreter.assert_fact("location", "box-1", "dock")
    assert ask.all("dock") == [{"?x": "box-3"}, {"?x": "box-1"}]
    interpreter.erase("location", "box-3")
    assert ask.all("dock") == [{"?x": "box-1"}]
    assert ask.all("yard") == []
    assert interpreter.question("(location box-3 ?where)").first() == {
        "?where": "unknown"
    }


def test_a_variable_left_free_is_absent_from_the_answer() -> None:
    ask = run().question("(or (location ?x barn) (near ?y barn))")
    assert ask.all() == [{"?x": "box-2"}, {"?y": "dock"}]


def test_functions_are_asked_and_history_has_no_answer() -> None:
    interpreter = run()
    two: list[dict[str, Value]] = [{}]
    assert interpreter.question("(= (double ?n) 4)", "?n").all(2) == two
    assert not interpreter.question("(last-result ?r)").holds()


@pytest.mark.parametrize(
    ("text", "given", "message"),
    [
        (
            "(locatoin ?x dock)",
            (),
            "unknown predicate `locatoin`; did you mean `location`?",
        ),
        ("(not (far dock barn))", (), "unknown predicate `far`"),
        ("(= (dubble 1) 2)", (), "unknown function `dubble`; did you mean `double`?"),
        ("(near ?x)", (), "`near` takes 2 arguments, not 1"),
        ("(near ?item dock)", ("?itm",), "not in the query; did you mean `?item`?"),
        ("(near ?x ?y)", ("?x", "?x"), "duplicate variable `?x`"),
        ("(near ?x", (), "the list of `near` is not closed"),
        ("(near ?x ?y) (near ?y ?x)", (), "expected one formula"),
    ],
)
def test_meaningless_query_is_refused(
    text: str, given: tuple[str, ...], message: str
) -> None:
    with pytest.raises(ValueError, match=re.escape(message)) as refused:
        run().question(text, *given)
    assert "\n" not in str(refused.value)


def test_the_value_true_may_be_left_out() -> None:
    interpreter = run()
    interpreter.assert_fact("full", "bay-1")
    assert interpreter.question("(full ?bay)").all() == [{"?bay": "bay-1"}]
