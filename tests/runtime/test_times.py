"""Windows, deadlines, monitor-time, and how time moves on [L 4, 5]."""

from __future__ import annotations

import pytest

from .helpers import at, play, row

USE = "(define-rap (use ?x) (method (primitive (act ?x))))"
LATER = "(define-rap (later ?x) (monitor-time now 5 9) (method (primitive (act ?x))))"


@pytest.mark.parametrize(
    ("window", "when"),
    [
        ("(window now 5 9)", 5),
        ("(window absolute 12 20)", 12),
        ("(window now 0 9)", 0),
        ("(window now 3 9) (window absolute 7 20)", 7),
        ("(window now 2.5 9)", 2.5),
    ],
)
def test_a_step_is_not_before_its_windows_open(window: str, when: float) -> None:
    text = USE + f"(define-rap (top) (method (task-net (t1 (use a) {window}))))"
    assert play(text, "(top)").told("asked", times=True) == [f"{when} asked (act a)"]


def test_now_is_when_the_task_net_was_made() -> None:
    text = USE + "(define-rap (top) (method (task-net (t1 (use a) (window now 5 9)))))"
    ran = play(text, "(top) :at 10")
    assert ran.told("asked", times=True) == ["15 asked (act a)"]


def test_a_window_on_a_step_orders_and_counts_from_its_end() -> None:
    text = (
        USE
        + """
        (define-rap (top)
          (method (task-net (t2 (use b) (window t1 3 9)) (t1 (use a)))))
        """
    )
    ran = play(text, "(top)", rows=[row("(act a)", takes=4)])
    assert ran.told("asked", times=True) == ["0 asked (act a)", "7 asked (act b)"]


def test_step_ended_by_until_counts_as_ended() -> None:
    text = (
        USE
        + """
        (define-rap (top)
          (method (task-net (t1 (idle) (until-end t2)) (t2 (use a) (window now 6 9))
                            (t3 (use b) (window t1 3 9)))))
        (define-rap (idle) (monitor-state (go)) (method (task-net)))
        """
    )
    ran = play(text, "(top)")
    assert ran.told("asked", times=True) == ["6 asked (act a)", "9 asked (act b)"]


def test_window_times_use_inputs_and_variables_of_earlier_steps() -> None:
    text = (
        USE
        + """
        (define-rap (top ?n)
          (method (task-net (t1 (find => ?m) (for t2))
                            (t2 (use a) (window now (+ ?n ?m) 99)))))
        (define-rap (find => ?m) (succeed (color size ?m)))
        """
    )
    ran = play(text, "(top 4)", facts=["(color size 7)"])
    assert ran.told("fault", "failed") == []
    assert ran.told("asked", times=True) == ["11 asked (act a)"]


def test_non_numeric_time_is_a_fault_and_interference() -> None:
    text = (
        USE + "(define-rap (top ?n) (method (task-net (t1 (use a) (window now ?n 9)))))"
    )
    ran = play(text, "(top soon)")
    assert len(ran.told("fault")) == 2  # one for each of the two methods tried
    assert ran.told("failed")[0] == "failed (use a) interference interference"


def test_missed_deadline_is_reported_once_for_its_task() -> None:
    text = (
        USE
        + """
        (define-rap (top)
          (method (task-net (t1 (use a) (window now 0 5) (for t2)) (t2 (use b)))))
        """
    )
    ran = play(text, "(top) :deadline 8", rows=[row("(act ?)", takes=6)])
    assert ran.told("asked", "missed", "succeeded", times=True) == [
        "0 asked (act a)",
        "6 missed use 5",
        "6 succeeded (use a)",
        "6 asked (act b)",
        "12 missed top 8",
        "12 succeeded (use b)",
        "12 succeeded (top)",
    ]


def test_a_deadline_is_missed_when_the_clock_has_passed_it_not_before() -> None:
    text = USE
    ran = play(text, "(use a) :deadline 5", rows=[row("(act a)", takes=5)])
    assert ran.told("missed") == []


def test_a_missed_deadline_changes_nothing_else() -> None:
    tasks = ["(use a) :deadline 5", "(use b)"]
    ran = play(USE, *tasks, rows=[row("(act ?)", takes=9)])
    assert ran.told("asked") == ["asked (act a)", "asked (act b)"]
    assert ran.told("failed", "removed") == []


# --- monitor-time ------------------------------------------------------------------


def test_monitor_time_now_delays_each_method_anew() -> None:
    ran = play(
        """
        (define-rap (tick) (monitor-time now 10 15)
          (succeed (color it 3))
          (method (context (color it ?n)) (primitive (act ?n))))
        """,
        "(tick)",
        facts=["(color it 0)"],
        rows=[
            row(f"(act {n})", takes=2, asserts=[f"(color it {n + 1})"])
            for n in range(3)
        ],
    )
    assert ran.told("asked", "blocked", "succeeded", times=True) == [
        "0 blocked tick on time 10",
        "10 asked (act 0)",
        "12 blocked tick on time 22",
        "22 asked (act 1)",
        "24 blocked tick on time 34",
        "34 asked (act 2)",
        "36 succeeded (tick)",
    ]


def test_monitor_time_absolute_holds_from_then_on() -> None:
    ran = play(
        """
        (define-rap (tick) (monitor-time absolute 10 15) (succeed (p done))
          (method (primitive (act a))))
        """,
        "(tick)",
        rows=[row("(act a)", takes=1, times=1), row("(act a)", asserts=["(p done)"])],
    )
    assert ran.told("asked", "missed", times=True) == [
        "10 asked (act a)",
        "11 asked (act a)",
    ]


@pytest.mark.parametrize("reference", ["now", "absolute"])
def test_the_deadline_of_a_monitor_is_missed_once(reference: str) -> None:
    ran = play(
        f"""
        (define-rap (tick) (monitor-time {reference} 10 15) (succeed (p done))
          (method (primitive (act a))))
        """,
        "(tick)",
        rows=[
            row("(act a)", takes=20, times=1),
            row("(act a)", takes=1, asserts=["(p done)"]),
        ],
    )
    missed = ran.told("missed", times=True)
    assert missed == ["30 missed tick 15"]


def test_a_delay_set_anew_has_a_deadline_of_its_own() -> None:
    ran = play(
        """
        (define-rap (tick) (monitor-time now 10 15) (succeed (p done))
          (method (primitive (act a))))
        (define-rap (use ?x) (method (primitive (look ?x))))
        """,
        "(tick)",
        "(use a) :at 11",
        rows=[
            row("(act a)", takes=1, times=1),
            row("(look a)", takes=50),
            row("(act a)", asserts=["(p done)"]),
        ],
    )
    # done at 11, so again from 21 on and before 26; the clock is next seen at 61
    assert ran.told("missed", times=True) == ["61 missed tick 26"]


def test_the_deadline_of_a_monitor_orders_the_agenda() -> None:
    text = (
        USE
        + """
        (define-rap (tick ?x ?n) (monitor-time now 0 ?n) (method (primitive (act ?x))))
        """
    )
    for seed in range(5):
        ran = play(text, "(tick a 50)", "(tick b 40)", "(use c)", seed=seed)
        assert ran.told("asked") == [f"asked (act {x})" for x in "bac"]


def test_monitor_time_counts_from_when_the_task_was_made() -> None:
    """Not from when its inputs were bound, nor from when its turn came."""
    text = (
        USE
        + """
        (define-rap (top)
          (method (task-net (t1 (find => ?x) (for t2)) (t2 (tick ?x)))))
        (define-rap (find => ?x) (succeed (and (p ?x) (last-result okay)))
          (method (primitive (look a))))
        (define-rap (tick ?x) (monitor-time now 10 90) (method (primitive (act ?x))))
        """
    )
    ran = play(text, "(top)", facts=["(p z)"], rows=[row("(look a)", takes=4)])
    assert ran.told("asked", times=True)[-1] == "10 asked (act z)"


def test_non_numeric_monitor_time_fails_the_task() -> None:
    ran = play(
        "(define-rap (tick ?n) (monitor-time now ?n 9) (method (task-net)))",
        "(tick soon)",
    )
    assert ran.told("failed") == ["failed (tick soon) interference interference"]
    assert len(ran.told("fault")) == 1


def test_time_and_state_must_hold_at_once() -> None:
    ran = play(
        """
        (define-rap (tick) (monitor-time now 10 90) (monitor-state (go))
          (method (primitive (act a))))
        """,
        "(tick)",
        times=[at(3, "(go)"), at(6, erases=["(go)"]), at(20, "(go)")],
    )
    assert ran.told("asked", times=True) == ["20 asked (act a)"]


# --- the clock ---------------------------------------------------------------------


def test_time_moves_only_when_nothing_is_eligible() -> None:
    text = USE + LATER
    ran = play(text, "(later z)", *["(use a)"] * 5)
    assert ran.told("asked", times=True) == ["0 asked (act a)"] * 5 + [
        "5 asked (act z)"
    ]


def test_a_whole_time_is_an_integer_in_every_event() -> None:
    text = (
        USE + "(define-rap (top) (method (task-net (t1 (use a) (window now 0.5 9)))))"
    )
    ran = play(text, "(top) :at 0.5")
    times = [repr(event.time) for event in ran.events]
    assert "0.5" in times
    assert "1" in times
    assert "1.0" not in times


def test_an_atomic_primitive_holds_everything() -> None:
    text = USE + LATER
    ran = play(text, "(use a)", "(later b)", rows=[row("(act a)", takes=10)])
    assert ran.told("asked", times=True) == ["0 asked (act a)", "10 asked (act b)"]


def test_non_atomic_primitive_lets_other_tasks_run() -> None:
    text = USE + "(define-rap (drag ?x) (method (primitive (slow ?x))))"
    ran = play(text, "(drag a)", "(use b)", rows=[row("(slow a)", after=10)])
    assert ran.told("done", times=True) == [
        "0 done use (act b) okay",
        "10 done drag (slow a) okay",
    ]
