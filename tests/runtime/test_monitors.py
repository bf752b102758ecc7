"""Monitors: blocking, standing monitors, what a block forgets [L 5] [T 4.7]."""

from __future__ import annotations

from rapc import events

from .helpers import at, play, row

WAIT = """
(define-rap (wait ?x) (monitor-state (p ?x)) (method (primitive (act ?x))))
"""


def test_true_monitor_does_not_block() -> None:
    ran = play(WAIT, "(wait a)", facts=["(p a)"])
    assert ran.told("blocked", "woken", "asked") == ["asked (act a)"]


def test_false_monitor_blocks_without_a_cycle() -> None:
    ran = play(WAIT, "(wait a)", times=[at(4, "(p a)")])
    assert ran.told("selected", "blocked", "woken", "asked", times=True)[:4] == [
        "0 blocked wait on (p a)",
        "4 woken wait",
        "4 selected wait",
        "4 asked (act a)",
    ]
    assert ran.of(events.TaskBlocked)[0].cycle == 0


def test_monitors_are_tested_by_task_number_after_all_messages() -> None:
    ran = play(
        WAIT,
        "(wait a)",
        "(wait b)",
        "(wait c)",
        times=[at(4, "(p c)"), at(4, "(p b)"), at(4, "(p a)")],
    )
    woken = [event.task for event in ran.of(events.TaskWoken)]
    assert woken == [1, 2, 3]


def test_the_bindings_of_a_monitor_are_not_kept() -> None:
    ran = play(
        """
        (define-rap (wait) (monitor-state (p ?x))
          (method (context (q a ?x)) (primitive (act ?x))))
        """,
        "(wait)",
        facts=["(p one)", "(q a two)"],
    )
    assert ran.told("asked") == ["asked (act two)"]


def test_change_undone_before_the_choice_wakes_no_task() -> None:
    ran = play(
        WAIT,
        "(wait a)",
        times=[at(4, "(p a)"), at(4, erases=["(p a)"]), at(6, "(p a)")],
    )
    assert ran.told("woken", times=True) == ["6 woken wait"]


def test_woken_task_with_false_monitor_is_blocked_again() -> None:
    ran = play(
        WAIT
        + "(define-rap (spoil) (monitor-state (go)) (method (primitive (look it))))",
        "(wait a)",
        "(spoil) :priority 1",
        rows=[row("(look it)", erases=["(p a)"])],
        times=[at(4, "(p a)", "(go)"), at(9, "(p a)")],
    )
    assert ran.told("woken", "blocked", "asked", times=True) == [
        "0 blocked wait on (p a)",
        "0 blocked spoil on (go)",
        "4 woken wait",
        "4 woken spoil",
        "4 asked (look it)",
        "4 blocked wait on (p a)",
        "9 woken wait",
        "9 asked (act a)",
    ]


def test_monitored_task_is_eligible_once_after_its_method() -> None:
    """Selected, it does steps 1 and 2; step 3 blocks it."""
    ran = play(
        """
        (define-rap (guard) (monitor-state (go)) (succeed (p done))
          (method (primitive (act a))))
        """,
        "(guard)",
        facts=["(go)"],
        rows=[row("(act a)", erases=["(go)"], times=1)],
        times=[at(7, "(p done)"), at(9, "(go)")],
    )
    assert ran.told("selected", "asked", "blocked", "succeeded", times=True) == [
        "0 selected guard",
        "0 asked (act a)",
        "0 selected guard",
        "0 blocked guard on (go)",
        "9 selected guard",
        "9 succeeded (guard)",
    ]


def test_task_is_eligible_once_after_a_failed_method() -> None:
    ran = play(
        """
        (define-rap (guard) (monitor-state (go)) (succeed (last-result jammed))
          (method (primitive (act a))))
        """,
        "(guard)",
        facts=["(go)"],
        rows=[row("(act a)", "jammed", erases=["(go)"])],
    )
    assert ran.told("blocked", "succeeded") == ["succeeded (guard)"]


def test_a_monitor_without_succeed_ends_after_its_first_good_method() -> None:
    ran = play(WAIT, "(wait a)", facts=["(p a)"])
    assert ran.told("succeeded", "over") == ["succeeded (wait a)", "over done"]


def test_a_standing_monitor_never_ends() -> None:
    ran = play(
        """
        (define-rap (guard) (monitor-state (p ?x)) (succeed nil)
          (method (context (p ?x)) (primitive (act ?x))))
        """,
        "(guard)",
        rows=[row("(act ?x)", erases=["(p ?x)"])],
        times=[at(3, "(p a)"), at(5, "(p b)", "(p c)")],
    )
    assert ran.told("asked", "over", times=True) == [
        "3 asked (act a)",
        "5 asked (act b)",
        "5 asked (act c)",
        "5 over stuck",
    ]
    assert ran.told("succeeded", "failed") == []


def test_history_survives_a_block() -> None:
    """Nothing but the futile-loop history starts afresh."""
    ran = play(
        """
        (define-rap (guard) (monitor-state (go))
          (resources (counter ?c))
          (succeed (and (= (value ?c) 2) (method-tried one)
                        (result-with-method one okay)))
          (method one (task-net (t1 (use) (counter-add ?c 1)))))
        (define-rap (use) (method (primitive (act a))))
        """,
        "(guard)",
        facts=["(go)"],
        rows=[row("(act a)", erases=["(go)"])],
        times=[at(3, "(go)")],
    )
    assert ran.told("blocked", "succeeded", times=True)[-1] == "3 succeeded (guard)"
