"""Questions that go back very often are given up after a number of steps [L 2.70]."""

from __future__ import annotations

import pytest

from rapc import events
from rapc.debug.questions.why_not import ask
from rapc.parser.parse import parse_formula
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


def test_query_over_the_step_limit_is_aborted() -> None:
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


def takes(
    count: int, parts: str, before: str = "(p ?a) (p ?b)", queries: str = ""
) -> bool:
    """Whether it takes so many steps back to know that parts have no solution.

    The fewest that may be allowed is one; what takes any here takes four.
    """
    formula = f"(and {before} {parts} (p three))"
    if count > 0 and "given up" not in said(asked(formula, count - 1, queries)):
        return False
    told = said(asked(formula, max(count, 1), queries))
    return told.startswith("no") and "given up" not in told


@pytest.mark.parametrize(
    ("part", "count"),
    [
        ("(p ?c)", 4),
        ("(p ?)", 4),
        ("(or (p one) (p two))", 4),
        ("(or)", 4),
        ("(color ?c unknown)", 4),
        ("(believe (p ?c) 5)", 4),
        ("(believe (p ?c) ?age)", 4),
        ("(know-sensor-name ?c)", 4),
        ("(p one)", 0),
        ("(p ?a)", 0),
        ("(color one ?value)", 0),
        ("(believe (p one) ?age)", 0),
        ("(know-sensor-name ?a)", 0),
        ("(= ?a ?b)", 0),
        ("(not (p four))", 0),
        ("(last-result ?c)", 0),
    ],
)
def test_which_parts_search(part: str, count: int) -> None:
    """Four combinations of two parts of two stand before each of them."""
    assert takes(count, part)


@pytest.mark.parametrize(
    ("parts", "count"),
    [
        ("(or (p ?c) (p ?c)) (p ?c)", 4 + 8),
        ("(or (p ?c) (p ?d)) (p ?c)", 4 + 8 + 16),
        ("(or (= ?a ?c) (p ?c)) (p ?c)", 4 + 4),
        ("(or (p ?c) (p ?d)) (= ?c one) (p ?c)", 4 + 8),
        ("(not (and (p ?c) (p three))) (p ?c)", 4 + 4),
        ("(color one ?c) (color ?c unknown)", 0),
    ],
)
def test_which_variables_have_a_value(parts: str, count: int) -> None:
    """In one of them `?c` may be without one behind the `or`."""
    assert takes(count, parts)


@pytest.mark.parametrize(
    ("before", "parts", "count"),
    [
        ("(p ?a) (and (p ?b))", "(and (and (p ?c)))", 4),
        ("(p ?a)", "(or (p ?b) (p ?b)) (p ?c)", 8),
        ("(p ?a)", "(or (and (p ?b) (p ?c)) (p ?d))", 4),
        ("(or (p ?a) (p ?b))", "(p ?c) (p ?d)", 8),
        ("(p ?a)", "(not (and (p ?b) (p ?c) (p three))) (p ?d)", 4),
        ("(p ?a) (p one) (= ?a ?a)", "(p ?c)", 0),
    ],
)
def test_preceding_parts_of_a_part(before: str, parts: str, count: int) -> None:
    assert takes(count, parts, before)


LONG = " ".join(["(p ?x)"] * 30)


@pytest.mark.parametrize("more", ["", LONG])
def test_query_counts_as_its_formula(more: str) -> None:
    """Short ones, which are written where they are used, and long ones."""
    queries = f"""
    (define-query (some ?x) (and (p ?x) {more}))
    (define-query (both ?x ?y) (and (some ?x) (some ?y)))
    (define-query (either ?x ?y) (or (some ?x) (some ?y)))
    """
    assert takes(4, "(some ?c)", queries=queries)
    assert takes(0, "(some ?a)", queries=queries)
    assert takes(4, "(some ?)", "(both ?a ?b)", queries)
    assert takes(0, "(some ?c)", "(both ?a ?a)", queries)
    assert takes(4 + 8 + 16, "(either ?c ?d) (some ?c)", queries=queries)
    assert takes(4 + 8, "(either ?c ?c) (some ?c)", queries=queries)


@pytest.mark.parametrize("before", [9, 11])
@pytest.mark.parametrize("depth", [8, 11, 20])
def test_queries_in_queries_behind_many_parts_can_be_asked(
    before: int, depth: int
) -> None:
    """Python nests twenty blocks; what a question is written as keeps within that."""
    queries = "(define-query (q0 ?x) (p ?x))\n" + "\n".join(
        f"(define-query (q{at} ?x) (and (q{at - 1} ?x) (p ?y)))"
        for at in range(1, depth + 1)
    )
    formula = f"(and {parts(before)} (q{depth} ?z) (p three))"
    assert "given up after 100" in said(asked(formula, 100, queries))


def test_a_long_query_knows_its_argument_in_an_or_in_a_not() -> None:
    """No other part has used the argument before."""
    queries = f"""
    (define-query (apart ?i) (and (not (or (q ?u ?i) (p four))) (p ?x) {LONG}))
    """
    fact = ("(q one two)", *FACTS)
    text = f"""{queries}
    (define-rap (ask ?thing)
      (method (context (apart ?thing)) (primitive (act yes)))
      (method (context otherwise) (primitive (act no))))
    """
    assert said(play(text, "(ask three)", facts=fact)) == "yes"
    assert said(play(text, "(ask two)", facts=fact)) == "no"


def test_fault_in_a_long_query_names_its_use() -> None:
    """Both uses share their code; the second is not told as the first."""
    queries = f"""
    (define-query (large ?x) (and (p one) (< ?x 3) {LONG}))
    (define-query (inner ?x) (large ?x))
    """
    told = said(asked("(or (inner ?c) (large ?d))", 9, queries))
    assert "`large` in `inner` in context of method `#1`" in told
    assert "?c is not bound" in told
    assert " `large` in context of method `#1`" in told
    assert "?d is not bound" in told


def test_immediate_solution_takes_no_step_back() -> None:
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


def test_an_explanation_tells_after_how_many_steps_a_clause_was_given_up() -> None:
    """It goes back less often itself: the cause names the part at which it stopped."""
    text = f"""
    (define-rap (ask)
      (method (context (and {parts(12)} (p three))) (primitive (act yes))))
    """
    for most, note in (
        (3_000, "given up after 3000 steps back: see `rapc.query-steps`"),
        (300, "given up after 300 steps back: see `rapc.query-steps`"),
        (9_000, "given up after 2000 steps back: an explanation takes no more"),
    ):
        ran = play(text, "(ask)", facts=FACTS, settings=Settings(query_steps=most))
        cause = ran.of(events.TaskFailed)[0].because
        assert (cause.methods[0].part, cause.methods[0].note) == ("(p three)", note)


def test_explanations_respect_the_step_limit() -> None:
    ran = asked("true", 1_000_000)
    run = ran.interpreter
    formula = parse_formula(f"(and {parts(14)} (p three) (p ?y))")
    query = run.library.compiler.query(formula, "question", formula.span)
    told = ask(run, "question", query, None, {})
    assert told.note == "given up after 2000 steps back: an explanation takes no more"
    assert told.parts[-1][1] == 0
    assert not told.holds


def test_host_query_over_the_step_limit_has_no_solution_and_no_event() -> None:
    ran = asked("true", 100)
    for asks, nothing in (("first", None), ("all", []), ("holds", False)):
        ask = ran.interpreter.question(f"(and {parts(40)} (p three))")
        assert getattr(ask, asks)() == nothing
    assert said(ran) == "yes"
