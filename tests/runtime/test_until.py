"""`until-start` and `until-end` [L 4.27] [T 5.2.1]."""

from __future__ import annotations

from rapc import events

from .helpers import at, play, row

USE = "(define-rap (use ?x) (method (primitive (act ?x))))"
IDLE = "(define-rap (idle) (monitor-state (go)) (method (task-net)))"
SLOWLY = "(define-rap (slowly ?x) (method (primitive (slow ?x))))"


def test_until_end_removes_the_step_and_all_it_spawned() -> None:
    ran = play(
        USE
        + SLOWLY
        + """
        (define-rap (top)
          (method (task-net (t1 (watch) (until-end t2)) (t2 (slowly b)))))
        (define-rap (watch) (method (task-net (w1 (slowly a)))))
        """,
        "(top)",
        rows=[row("(slow a)", after=50), row("(slow b)", after=9)],
        seed=2,
    )
    assert ran.told("succeeded", "removed", "done", "over", times=True) == [
        "9 done slowly (slow b) okay",
        "9 succeeded (slowly b)",
        "9 removed slowly parent-removed",
        "9 removed watch until",
        "9 succeeded (top)",
        "9 over done",
    ]


def test_until_start_removes_the_step_when_the_other_is_first_selected() -> None:
    ran = play(
        USE
        + IDLE
        + """
        (define-rap (top)
          (method (task-net (t1 (idle) (until-start t2))
                            (t2 (use a) (window now 6 9)))))
        """,
        "(top)",
    )
    assert ran.told("removed", "selected", "asked", times=True)[1:] == [
        "6 selected use",
        "6 removed idle until",
        "6 asked (act a)",
        "6 selected use",
        "6 selected top",
    ]


def test_until_start_waits_for_the_monitors_of_the_other() -> None:
    ran = play(
        """
        (define-rap (top) (method (task-net (t1 (idle) (until-start t2)) (t2 (later)))))
        (define-rap (later) (monitor-state (stop)) (method (primitive (act a))))
        """
        + IDLE,
        "(top)",
        times=[at(5, "(stop)")],
    )
    assert ran.told("removed", "asked", times=True) == [
        "5 removed idle until",
        "5 asked (act a)",
    ]


def test_until_start_applies_at_any_selection() -> None:
    """Also if the task fails at once; and a second selection sets off nothing."""
    ran = play(
        """
        (define-rap (top)
          (method (context (not (last-result ?)))
                  (task-net (t1 (idle) (until-start t2)) (t2 (no)))))
        (define-rap (no) (preconditions nil))
        """
        + IDLE,
        "(top)",
    )
    assert ran.told("removed", "failed")[:2] == [
        "removed idle until",
        "failed (no) interference interference",
    ]


def test_step_ended_by_until_has_ended_for_order_and_method() -> None:
    ran = play(
        USE
        + IDLE
        + """
        (define-rap (top)
          (method (task-net (t1 (idle) (until-end t2) (for t3)) (t2 (use a))
                            (t3 (use b)))))
        """,
        "(top)",
    )
    assert ran.told("asked", "succeeded") == [
        "asked (act a)",
        "succeeded (use a)",
        "asked (act b)",
        "succeeded (use b)",
        "succeeded (top)",
    ]


def test_step_ended_by_until_ends_no_other_step() -> None:
    """t3 waits for t1's end with `until-end t1`; t1 is ended by t2 (T 5.2.1)."""
    ran = play(
        USE
        + IDLE
        + """
        (define-rap (top)
          (method (task-net (t1 (idle) (until-end t2)) (t2 (use a))
                            (t3 (idle) (until-end t1)))))
        """,
        "(top)",
        times=[at(9, "(go)")],
    )
    assert ran.told("removed", "succeeded", "over", times=True) == [
        "0 succeeded (use a)",
        "0 removed idle until",
        "9 succeeded (idle)",
        "9 succeeded (top)",
        "9 over done",
    ]


def test_untils_go_in_the_order_of_the_text() -> None:
    ran = play(
        USE
        + """
        (define-rap (top)
          (method (task-net (t4 (idle 1) (until-end t1)) (t1 (use a))
                            (t2 (idle 2) (until-end t1)) (t3 (idle 3) (until-end t1)))))
        (define-rap (idle ?n) (monitor-state (color ?n go)) (method (task-net)))
        """,
        "(top)",
    )
    removed = [event.task for event in ran.of(events.TaskRemoved)]
    assert removed == [2, 4, 5]


def test_until_comes_after_outputs_and_effects_and_before_the_methods_end() -> None:
    ran = play(
        IDLE
        + """
        (define-rap (top)
          (resources (counter ?c))
          (method (task-net (t1 (find => ?x) (counter-add ?c 1))
                            (t2 (idle) (until-end t1)))))
        (define-rap (find => ?x) (succeed (p ?x)))
        """,
        "(top)",
        facts=["(p a)"],
    )
    assert ran.told("succeeded", "changed", "removed", "ended")[:4] == [
        "succeeded (find => a)",
        "changed find counter-add 1: #counter(1)",
        "removed idle until",
        "ended top #1 okay",
    ]


def test_two_steps_until_the_end_of_each_other() -> None:
    """Whichever ends first takes the other along, and then the method ends."""
    ran = play(
        SLOWLY
        + """
        (define-rap (top)
          (method (task-net (t1 (slowly a) (until-end t2))
                            (t2 (slowly b) (until-end t1)))))
        """,
        "(top)",
        rows=[row("(slow a)", after=5), row("(slow b)", after=3)],
    )
    assert ran.told("removed", "succeeded", times=True) == [
        "3 succeeded (slowly b)",
        "3 removed slowly until",
        "3 succeeded (top)",
    ]


def test_a_failure_sets_off_no_until() -> None:
    ran = play(
        IDLE
        + """
        (define-rap (top)
          (method (context (not (last-result ?)))
                  (task-net (t1 (idle) (until-end t2)) (t2 (no)))))
        (define-rap (no) (preconditions nil))
        """,
        "(top)",
    )
    assert ran.told("removed") == ["removed idle sibling-failed"]


def test_a_step_cannot_end_itself() -> None:
    ran = play(
        USE
        + """
        (define-rap (top)
          (method (task-net (t1 (use a) (until-start t1) (until-end t1)))))
        """,
        "(top)",
    )
    assert ran.told("asked", "removed", "succeeded") == [
        "asked (act a)",
        "succeeded (use a)",
        "succeeded (top)",
    ]
