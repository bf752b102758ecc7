"""Constraints of a method: what must hold of all tasks below while it is under way."""

from __future__ import annotations

import pytest

from tests.runtime.helpers import Play, at, row

LIBRARY = """
(define-rap (top)
  (succeed (p done))
  (method careful
    (context (q key ?door))
    (constraints (not (p ?door)))
    (task-net (t1 (middle))))
  (method bold
    (context (p left))
    (primitive (act out))))
(define-rap (middle)
  (constraints (not (stop)))
  (succeed (go))
  (method (task-net (t1 (bottom)) (t2 (pause)))))
(define-rap (bottom) (succeed (go)) (method (primitive (slow x))))
(define-rap (pause) (succeed (go)) (method (primitive (slow y))))
"""


def test_false_constraint_ends_only_its_method() -> None:
    """The task selected leaves with the rest, and the method's task goes on."""
    rows = [
        row("(slow x)", after=5, asserts=["(p left)"]),
        row("(slow y)", after=9),
        row("(act out)", asserts=["(p done)"]),
    ]
    play = Play(LIBRARY, "(top)", rows=rows, facts=["(q key left)"]).run()
    told = play.told("ended", "removed", "failed", "chosen", "succeeded", times=True)
    assert told == [
        "0 chosen top careful",
        "0 chosen middle #1",
        "0 chosen bottom #1",
        "0 chosen pause #1",
        "5 ended bottom #1 okay",
        "5 removed bottom parent-removed",
        "5 removed pause parent-removed",
        "5 removed middle parent-failed",
        "5 ended top careful interference",
        "5 chosen top bold",
        "5 ended top bold okay",
        "5 succeeded (top)",
    ]


def test_constraints_of_tasks_between_come_first() -> None:
    """That of `middle` is nearer to `bottom` than that of the method of `top`."""
    rows = [
        row("(slow x)", after=5, asserts=["(p left)", "(stop)"]),
        row("(slow y)", after=9),
    ]
    play = Play(LIBRARY, "(top)", rows=rows, facts=["(q key left)"]).run(until=5)
    assert play.told("failed")[:1] == ["failed (bottom) interference interference"]


@pytest.mark.parametrize("first", [0, 3])
def test_it_is_no_part_of_the_choice(first: int) -> None:
    """A method may be chosen whose constraint does not hold; it then ends at once."""
    play = Play(
        LIBRARY,
        "(top)",
        facts=["(q key left)"],
        times=[at(first, "(p left)"), at(first, "(p x)")],
        rows=[row("(act out)", asserts=["(p done)"]), row("(slow ?)", after=9)],
    ).run()
    assert "top careful" in " ".join(play.told("chosen"))
    assert play.interpreter.results()[0].outcome == "succeeded"


def test_constraint_sees_later_bindings_of_the_method() -> None:
    """A variable that an output binds counts from then on."""
    text = """
    (define-rap (top)
      (succeed (go))
      (method
        (constraints (q fine ?found))
        (task-net (t1 (find => ?found) (for t2)) (t2 (use ?found)))))
    (define-rap (find => ?what)
      (succeed (q found ?what)) (method (primitive (act look))))
    (define-rap (use ?x) (method (primitive (act ?x))))
    """
    rows = [row("(act look)", asserts=["(q found ball)"])]
    play = Play(text, "(top)", rows=rows, facts=["(q fine stone)"]).run(cycles=4)
    assert play.told("asked", "ended") == [
        "asked (act look)",
        "ended find #1 okay",
        "ended top #1 interference",
    ]


def test_a_saved_run_goes_on_as_it_was() -> None:
    """Constraints are found again when a run is taken up."""
    rows = [
        row("(slow x)", after=5, asserts=["(p left)"]),
        row("(slow y)", after=9),
        row("(act out)", asserts=["(p done)"]),
    ]
    one = Play(LIBRARY, "(top)", rows=rows, facts=["(q key left)"])
    for _ in range(4):
        assert one.interpreter.step()
    other = one.interpreter.fork()
    one.run()
    told: list[object] = []
    other.listen(told.append)
    other.run()
    assert other.results() == one.interpreter.results()
    assert [str(e) for e in told[-3:]] == [str(e) for e in one.events[-3:]]
