"""A named query means its formula with the terms put in, however it is compiled."""

from __future__ import annotations

import pytest

from rapc.compiler.query import named
from tests.runtime.helpers import Play, at, compiled, row

QUERIES = """
(declare-memory-proposition joined (?x ?y))
(declare-memory-property size (?x ?n) unknown)
(define-query (near ?x ?y) (and (joined ?x ?z) (joined ?z ?y)))
(define-query (big ?x) (and (p ?x) (size ?x ?n) (> ?n 2)))
(define-query (grown ?x ?n ?m) (and (size ?x ?n) (= ?m (+ ?n 1))))
(define-query (either ?x ?y) (or (joined ?x ?y) (and (p ?x) (size ?y ?))))
(define-query (far ?x ?y) (and (near ?x ?z) (near ?z ?y) (not (joined ?x ?y))))
(define-query (after ?m) (last-result ?m))
(define-rap (top) (succeed (go)) (method (primitive (act x))))
"""

FACTS = (
    "(joined a b)",
    "(joined b c)",
    "(joined c a)",
    "(joined b b)",
    "(p a)",
    "(p b)",
    "(size a 3)",
    "(size b 1)",
    "(size c 4)",
)

PAIRS = {
    "(near ?a ?b)": "(and (joined ?a ?1) (joined ?1 ?b))",
    "(near ?a ?a)": "(and (joined ?a ?1) (joined ?1 ?a))",
    "(near a ?b)": "(and (joined a ?1) (joined ?1 ?b))",
    "(near ? ?z)": "(and (joined ?2 ?1) (joined ?1 ?z))",
    "(and (near ?z ?y) (joined ?y ?z))": (
        "(and (joined ?z ?1) (joined ?1 ?y) (joined ?y ?z))"
    ),
    "(not (big c))": "(not (and (p c) (size c ?1) (> ?1 2)))",
    "(big ?what)": "(and (p ?what) (size ?what ?1) (> ?1 2))",
    "(and (near ?a ?b) (near ?b ?a))": (
        "(and (joined ?a ?1) (joined ?1 ?b) (joined ?b ?2) (joined ?2 ?a))"
    ),
    "(grown ?x ?n (+ ?n 1))": "(and (size ?x ?n) (= (+ ?n 1) (+ ?n 1)))",
    "(grown ?x (- ?y 1) ?y)": "(and (size ?x (- ?y 1)) (= ?y (+ (- ?y 1) 1)))",
    "(and (size ?z ?y) (grown ?x (- ?y 1) ?y))": (
        "(and (size ?z ?y) (size ?x (- ?y 1)) (= ?y (+ (- ?y 1) 1)))"
    ),
    "(either ?u ?v)": "(or (joined ?u ?v) (and (p ?u) (size ?v ?)))",
    "(either ? b)": "(or (joined ?1 b) (and (p ?1) (size b ?)))",
    "(and (or (big ?x) (either ?x ?y)) (near ?x ?y))": (
        "(and (or (and (p ?x) (size ?x ?1) (> ?1 2))"
        " (or (joined ?x ?y) (and (p ?x) (size ?y ?))))"
        " (joined ?x ?2) (joined ?2 ?y))"
    ),
    "(far ?x ?y)": (
        "(and (joined ?x ?1) (joined ?1 ?3) (joined ?3 ?2) (joined ?2 ?y)"
        " (not (joined ?x ?y)))"
    ),
}
"""Uses of queries and what they mean; variables called by numbers are hidden."""


def _asked(play: Play, text: str) -> list[dict[str, object]]:
    found = play.interpreter.question(text).all()
    return [{n: v for n, v in one.items() if not n[1:].isdigit()} for one in found]


@pytest.mark.parametrize("most", [0, 3, 1000])
@pytest.mark.parametrize("use", PAIRS)
def test_a_use_means_the_formula_with_the_terms_put_in(
    use: str, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Solutions and their order are the same, written in place or as a function."""
    monkeypatch.setattr(named, "MOST_INLINE", most)
    play = Play(QUERIES, facts=FACTS)
    assert _asked(play, use) == _asked(play, PAIRS[use])


@pytest.mark.parametrize("most", [0, 1000])
def test_a_fault_within_a_query_names_the_query(
    most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The variable is called as its author called it."""
    monkeypatch.setattr(named, "MOST_INLINE", most)
    text = "(define-query (odd) (and (p ?x) (< ?x ?limit)))"
    text += "(define-rap (top) (succeed (odd)) (method (primitive (act x))))"
    play = Play(text, "(top)", facts=["(p 1)"]).run(cycles=1)
    (told,) = play.told("fault")
    assert "`odd` in succeed at t.rap:" in told
    assert told.endswith(": ?limit is not bound")


def test_a_monitor_on_a_query_wakes_as_its_formula_does() -> None:
    """And the trace shows the name."""
    text = """
    (define-query (open ?x) (and (color ?x green) (not (stop))))
    (define-rap (top) (monitor-state (open lamp)) (succeed (go))
      (method (primitive (act x))))
    """
    play = Play(
        text,
        "(top)",
        rows=[row("(act x)", asserts=["(go)"])],
        times=[at(5, "(color lamp green)"), at(9, erases=["(stop)"])],
        facts=["(stop)"],
    ).run()
    told = play.told("blocked", "woken", "succeeded", times=True)
    assert told == ["0 blocked top on (open lamp)", "9 woken top", "9 succeeded (top)"]


def test_history_in_a_query_is_that_of_the_task_that_asks() -> None:
    """A query that asks for a result has the result of the task whose clause it is."""
    text = """
    (define-query (after ?m) (last-result ?m))
    (define-rap (top) (succeed (after dropped)) (method (primitive (act x))))
    """
    play = Play(text, "(top)", rows=[row("(act x)", "dropped")]).run()
    assert play.interpreter.results()[0].outcome == "succeeded"


def test_chains_of_queries_grow_with_their_text() -> None:
    """Each uses the one before it twice: written out they would have no end."""
    text = "(define-query (q0 ?x ?y) (q ?x ?y))"
    for n in range(1, 60):
        text += f"(define-query (q{n} ?x ?y)"
        text += f" (and (q{n - 1} ?x ?z) (q{n - 1} ?z ?y)))"
    text += "(define-rap (top) (monitor-state (q59 a b)) (method (primitive (act x))))"
    program = compiled(text)
    plan = program.rap("top")
    assert plan is not None
    assert plan.monitor_state is not None
    play = Play(text)
    question = play.interpreter.question("(q59 a ?y)")
    assert question.first() is None
