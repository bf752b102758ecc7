"""Notations: in memory as long as their method [L 6] [T 4.9]."""

from __future__ import annotations

import pytest

from .helpers import Play, at, play, row

HOLD = """
(define-rap (hold ?x) (method (notations (p ?x)) (task-net (t1 (slowly ?x)))))
(define-rap (slowly ?x) (method (primitive (slow ?x))))
"""


def test_a_notation_comes_and_goes_with_its_method() -> None:
    ran = play(HOLD, "(hold a)", rows=[row("(slow a)", after=5)])
    assert ran.told("chosen", "asserted", "erased", "ended", times=True) == [
        "0 chosen hold #1",
        "0 asserted (p a) by notation",
        "0 chosen slowly #1",
        "5 ended slowly #1 okay",
        "5 erased (p a) by notation",
        "5 ended hold #1 okay",
    ]


def test_also_if_the_method_ends_badly_or_its_task_is_removed() -> None:
    ran = play(HOLD, "(hold a)", rows=[row("(slow a)", "dropped")])
    assert ran.memory("(p ?)") == []
    ran = Play(HOLD, "(hold a)", rows=[row("(slow a)", after=5)]).run(until=2)
    assert ran.told("erased") == ["erased (p a) by notation"]
    ran = play(
        HOLD
        + """
        (define-rap (top) (method (task-net (t1 (hold a) (until-end t2)) (t2 (rest)))))
        (define-rap (rest) (method (primitive (slow b))))
        """,
        "(top)",
        rows=[row("(slow a)", after=9), row("(slow b)", after=4)],
    )
    assert ran.told("erased", times=True) == ["4 erased (p a) by notation"]


def test_two_methods_may_note_the_same() -> None:
    ran = play(
        HOLD.replace("(p ?x)", "(p it)"),
        "(hold a)",
        "(hold b)",
        rows=[row("(slow a)", after=3), row("(slow b)", after=6)],
    )
    assert ran.told("asserted", "erased", times=True) == [
        "0 asserted (p it) by notation",
        "0 asserted (p it) by notation",
        "6 erased (p it) by notation",
    ]


@pytest.mark.parametrize("first", ["a", "b"])
def test_a_fact_asserted_by_anyone_else_meanwhile_stays(first: str) -> None:
    ran = play(
        HOLD.replace("(p ?x)", "(p it)"),
        "(hold a)",
        "(hold b)",
        rows=[row(f"(slow {first})", after=3), row("(slow ?)", after=9)],
        times=[at(2, "(p it)")],
    )
    assert ran.told("erased") == []
    assert ran.memory("(p ?)") == ["(p it)"]


def test_noting_an_existing_fact_updates_its_time() -> None:
    ran = play(
        HOLD,
        "(hold a) :at 5",
        facts=["(p a)"],
        rows=[row("(slow a)", after=3)],
        times=[at(1)],
    )
    assert ran.told("asserted", "erased", times=True) == [
        "0 asserted (p a) by user",
        "5 asserted (p a) by notation",
    ]
    assert ran.interpreter.memory.age("p", "a") == 3


def test_an_erase_takes_it_at_once_and_the_methods_end_does_nothing() -> None:
    ran = play(
        HOLD,
        "(hold a)",
        rows=[row("(slow a)", after=9)],
        times=[at(3, erases=["(p a)"])],
    )
    assert ran.told("erased", times=True) == ["3 erased (p a) by handler"]


def test_erased_and_asserted_by_another_it_stays() -> None:
    ran = play(
        HOLD,
        "(hold a)",
        rows=[row("(slow a)", after=9)],
        times=[at(3, erases=["(p a)"]), at(5, "(p a)")],
    )
    assert ran.memory("(p ?)") == ["(p a)"]


def test_a_new_value_takes_it_and_the_old_value_does_not_come_back() -> None:
    text = HOLD.replace("(p ?x)", "(color mood happy)")
    ran = play(
        text,
        "(hold a)",
        facts=["(color mood calm)"],
        rows=[row("(slow a)", after=9)],
        times=[at(3, "(color mood sad)")],
    )
    assert ran.told("asserted", "erased", times=True) == [
        "0 asserted (color mood calm) by user",
        "0 erased (color mood calm) by notation",
        "0 asserted (color mood happy) by notation",
        "3 erased (color mood happy) by handler",
        "3 asserted (color mood sad) by handler",
    ]
    ran = play(
        text,
        "(hold a)",
        facts=["(color mood calm)"],
        rows=[row("(slow a)", after=9)],
    )
    assert ran.memory("(color mood ?)") == []


def test_a_short_notation_means_true() -> None:
    text = HOLD.replace("(p ?x)", "(ready ?x)")
    ran = play(text, "(hold a)", rows=[row("(slow a)", after=9)])
    assert ran.told("asserted") == ["asserted (ready a true) by notation"]


def test_notation_noted_after_an_erase_belongs_to_its_method() -> None:
    """The first method's end must not take away what the second one notes anew."""
    ran = play(
        HOLD.replace("(p ?x)", "(p it)"),
        "(hold a)",
        "(hold b) :at 5",
        rows=[row("(slow a)", after=9), row("(slow b)", after=9)],
        times=[at(3, erases=["(p it)"])],
    )
    assert ran.told("erased", times=True) == [
        "3 erased (p it) by handler",
        "14 erased (p it) by notation",
    ]


@pytest.mark.parametrize("noted", ["(p ?never)", "(p ?c)", "(p (/ 1 0))"])
def test_an_unbound_notation_fails_the_method_before_any_is_made(noted: str) -> None:
    ran = play(
        f"""
        (define-rap (hold) (resources (counter ?c))
          (method (notations (q a b) {noted}) (primitive (act a))))
        """,
        "(hold)",
    )
    assert ran.told("asked") == []
    assert ran.told("asserted", "erased", "ended")[:1] == ["ended hold #1 interference"]
    assert ran.told("asserted", "erased") == []
    assert len(ran.told("fault")) >= 1


def test_a_notation_wakes_monitors() -> None:
    ran = play(
        HOLD + "(define-rap (wait) (monitor-state (p a)) (method (primitive (act b))))",
        "(wait)",
        "(hold a) :at 4",
        rows=[row("(slow a)", after=9)],
    )
    assert ran.told("done", times=True) == [
        "4 done wait (act b) okay",
        "13 done slowly (slow a) okay",
    ]


def test_notations_are_made_all_or_none() -> None:
    """What one would replace stays, and nobody wakes, if another cannot be made."""
    ran = play(
        """
        (define-rap (shut ?n)
          (method (notations (color door shut) (q left (+ ?n 1))) (primitive (act a))))
        (define-rap (watch) (succeed (color door shut))
          (monitor-state (color door shut)) (method (primitive (look a))))
        """,
        "(watch) :background true",
        "(shut none)",
        facts=["(color door open)", "(q left 1)"],
    )
    assert ran.told("asserted", "erased", "woken") == [
        "asserted (color door open) by user",
        "asserted (q left 1) by user",
    ]
    assert ran.memory("(color door ?)") == ["(color door open)"]
