"""Questions that go back very often are given up after a number of steps [L 2.70]."""

from __future__ import annotations

import pytest

from rapc.runtime.events import events
from rapc.runtime.settings import Settings
from tests.runtime.helpers import Play, play

FACTS = ("(p one)", "(p two)")


def parts(count: int, name: str = "x") -> str:
    """So many parts of a conjunction, each of which has two solutions."""
    return " ".join(f"(p ?{name}{at})" for at in range(count))


def asked(formula: str, most: int, queries: str = "") -> Play:
    """A run in which `yes` is printed if a formula has a solution, else `no`."""
    text = f"""{queries}
    (define-rap (ask)
      (method (context {formula}) (primitive (act yes)))
      (method (context otherwise) (primitive (act no))))
    """
    return play(text, "(ask)", facts=FACTS, settings=Settings(query_steps=most))


def said(ran: Play) -> str:
    """What was said, and which faults there were."""
    faults = [fault.what for fault in ran.of(events.QueryFaulted)]
    words = [str(done.request[1]) for done in ran.of(events.PrimitiveEnded)]
    return " ".join(words + faults)


def test_a_question_that_goes_back_too_often_is_given_up() -> None:
    """The fault names the clause, with file and line, and the count."""
    ran = asked(f"(and {parts(40)} (p three))", 1000)
    assert said(ran).startswith("no context of method `#1` at t.rap:")
    end = ": given up after 1000 steps back: see `rapc.query-steps`"
    assert said(ran).endswith(end)
    assert len(ran.of(events.QueryFaulted)) == 1


def test_steps_back_are_counted_from_the_third_part_on() -> None:
    """Four parts of two: 4 times the third has no more, 8 times the fourth has not."""
    formula = f"(and {parts(4)} (p three))"
    assert said(asked(formula, 12)) == "no"
    assert said(asked(formula, 11)).startswith("no context of method")
    assert said(asked(f"(and {parts(2)} (p three))", 1)) == "no"


def test_an_answer_that_is_found_at_once_takes_no_step_back() -> None:
    assert said(asked(f"(and {parts(40)})", 1)) == "yes"


QUERIES = "(define-query (q0 ?x) (p ?x))\n" + "\n".join(
    f"(define-query (q{at} ?x) (and (q{at - 1} ?x) (q{at - 1} ?y)))"
    for at in range(1, 12)
)

SHAPES = {
    "or": (f"(and {' '.join('(or (p ?a) (p ?b))' for _ in range(30))} (p three))", ""),
    "or that binds": (
        f"(and {' '.join(f'(or (p ?a{n}) (p ?b{n}))' for n in range(30))} (p three))",
        "",
    ),
    "or asked again": (
        f"(and (or (p ?a) (p ?b)) {parts(30)} (or (p ?a) (p ?b)) (p three))",
        "",
    ),
    "part of a not": (f"(not (and {parts(40)} (p three)))", ""),
    "nots in nots": (
        f"{''.join(f'(not (and (p ?x{n}) (p ?y{n}) ' for n in range(16))}"
        f"(p three){'))' * 16}",
        "",
    ),
    "queries of queries": ("(and (q11 ?x) (p three))", QUERIES),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_each_shape_of_question_is_bounded(shape: str) -> None:
    """As a whole: within `not` it does not count as having no solution."""
    formula, queries = SHAPES[shape]
    ran = asked(formula, 500, queries)
    assert "given up after 500 steps back" in said(ran)
    assert said(ran).startswith("no ")
    assert len(ran.of(events.QueryFaulted)) == 1


def test_each_question_has_all_its_steps() -> None:
    """What one has used up the next one has again."""
    formula = f"(and {parts(4)} (p three))"
    text = f"""
    (define-rap (ask)
      (method (context {formula}) (primitive (act yes)))
      (method (context {formula}) (primitive (act yes)))
      (method (context true) (primitive (act no))))
    """
    ran = play(text, "(ask)", facts=FACTS, settings=Settings(query_steps=12))
    assert said(ran) == "no"


def test_a_host_that_asks_too_much_has_no_answer_and_no_trace() -> None:
    ran = asked("true", 100)
    for asks, nothing in (("first", None), ("all", []), ("holds", False)):
        ask = ran.interpreter.question(f"(and {parts(40)} (p three))")
        assert getattr(ask, asks)() == nothing
    assert said(ran) == "yes"
