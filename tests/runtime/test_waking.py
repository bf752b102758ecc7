"""What wakes a blocked task, and what does not [L 5] [T 4.7]."""

from __future__ import annotations

import pytest

from .helpers import at, play, row

WAIT = """
(define-rap (wait ?x) (monitor-state (p ?x)) (method (primitive (act ?x))))
"""


def test_a_belief_goes_stale_by_a_timer() -> None:
    ran = play(
        """
        (define-rap (watch) (monitor-state (not (believe (p a) 10)))
          (method (primitive (act a))))
        """,
        "(watch)",
        facts=["(p a)"],
        times=[at(4, "(p a)"), at(30, "(p b)")],
    )
    assert ran.told("blocked", "asked", times=True) == [
        "0 blocked watch on (not (believe (p a) 10))",
        "14 asked (act a)",
    ]


def test_two_beliefs_the_earlier_timer_counts() -> None:
    ran = play(
        """
        (define-rap (watch)
          (monitor-state (not (and (believe (p a) 10) (believe (p b) 3))))
          (method (primitive (act a))))
        """,
        "(watch)",
        facts=["(p a)", "(p b)"],
        times=[at(2, "(p b)")],
    )
    assert ran.told("asked", times=True) == ["5 asked (act a)"]


def test_stale_belief_blocks_the_woken_task_again() -> None:
    ran = play(
        """
        (define-rap (use ?x) (method (primitive (act ?x))))
        (define-rap (watch) (monitor-state (believe (p a) 5))
          (method (primitive (look a))))
        """,
        "(watch)",
        "(use long) :priority 1 :at 2",
        times=[at(2, "(p a)"), at(40, "(p a)")],
        rows=[row("(act long)", takes=20)],
    )
    assert ran.told("woken", "blocked", "asked", times=True) == [
        "0 blocked watch on (believe (p a) 5)",
        "2 woken watch",
        "2 asked (act long)",
        "22 blocked watch on (believe (p a) 5)",
        "40 woken watch",
        "40 asked (look a)",
    ]


def test_bound_age_is_tested_when_the_clock_has_moved() -> None:
    """It sets no time of its own: 12 is when something else happens."""
    ran = play(
        """
        (define-rap (watch) (monitor-state (and (believe (p a) ?age) (> ?age 5)))
          (method (primitive (act a))))
        """,
        "(watch)",
        facts=["(p a)"],
        times=[at(4, "(q x y)"), at(12, "(q x y)")],
    )
    assert ran.told("asked", times=True) == ["12 asked (act a)"]


def test_resource_wakes_tasks_with_queries_of_it() -> None:
    ran = play(
        """
        (define-rap (top)
          (resources (counter ?c) (set ?s))
          (method (task-net (t1 (watch ?c ?s)) (t2 (rest 1) (counter-add ?c 2))
                            (t3 (rest 2) (set-add ?s a)))))
        (define-rap (rest ?n) (method (primitive (slow ?n))))
        (define-rap (watch ?c ?s)
          (monitor-state (and (> (value ?c) 1) (member ?s a)))
          (method (primitive (act a))))
        """,
        "(top)",
        rows=[row("(slow 1)", after=3), row("(slow 2)", after=6)],
    )
    assert ran.told("asked", times=True)[-1] == "6 asked (act a)"
    assert len(ran.told("blocked")) == 1


def test_a_default_wakes_when_a_first_value_comes() -> None:
    ran = play(
        """
        (define-rap (watch) (monitor-state (and (p ?x) (not (ready ?x false))))
          (method (primitive (act a))))
        """,
        "(watch)",
        facts=["(p arm)"],
        times=[at(3, "(ready arm true)")],
    )
    assert ran.told("asked", times=True) == ["3 asked (act a)"]


def test_a_function_without_reads_is_tested_at_every_change() -> None:
    calls: list[object] = []

    def full(view: object, name: object) -> bool:
        calls.append(name)
        return len(calls) > 2

    ran = play(
        """
        (declare-memory-function full (?x))
        (define-rap (watch) (monitor-state (full bin)) (method (primitive (act a))))
        """,
        "(watch)",
        functions={"full": full},
        times=[at(2, "(p a)"), at(5, "(q a b)")],
    )
    assert ran.told("asked", times=True) == ["5 asked (act a)"]


def test_a_function_with_reads_is_tested_at_those() -> None:
    calls: list[object] = []

    def full(view: object, name: object) -> bool:
        calls.append(name)
        return False

    play(
        """
        (declare-memory-function full (?x) :reads (q))
        (define-rap (watch) (monitor-state (full bin)) (method (primitive (act a))))
        """,
        "(watch)",
        functions={"full": full},
        times=[at(2, "(p a)"), at(5, "(q a b)"), at(6, "(p b)")],
    )
    assert len(calls) == 2


@pytest.mark.parametrize("noise", [10, 400])
def test_waking_does_not_poll(noise: int) -> None:
    """However often other things change, a formula is asked when it may matter."""
    asked: list[object] = []

    def spy(view: object, name: object) -> bool:
        asked.append(name)
        return False

    play(
        """
        (declare-memory-function spy (?x) :reads ())
        (define-rap (watch ?x) (monitor-state (and (q ?x ready) (spy ?x)))
          (method (task-net)))
        """,
        *[f"(watch w{n})" for n in range(20)],
        functions={"spy": spy},
        times=[at(n + 1, f"(q other{n} ready)") for n in range(noise)]
        + [at(noise + 2, "(q w7 ready)")],
    )
    assert asked == ["w7"]


def test_one_block_one_wake() -> None:
    """A change that does not make it hold tells nothing."""
    ran = play(
        """
        (define-rap (watch) (monitor-state (and (p a) (p b)))
          (method (primitive (act a))))
        """,
        "(watch)",
        times=[at(2, "(p a)"), at(3, erases=["(p a)"]), at(4, "(p b)"), at(6, "(p a)")],
    )
    assert ran.told("blocked", "woken", times=True) == [
        "0 blocked watch on (and (p a) (p b))",
        "6 woken watch",
    ]


def test_a_step_with_an_unbound_input_is_not_tested_but_fails() -> None:
    ran = play(
        "(define-rap (top) (method (task-net (t1 (wait ?never)))))" + WAIT, "(top)"
    )
    assert ran.told("blocked") == []
    assert ran.told("failed")[0] == "failed (wait ?never) interference interference"


def test_a_step_bound_while_eligible_is_tested_with_no_cycle() -> None:
    ran = play(
        """
        (define-rap (top)
          (method (task-net (t1 5 (find => ?x)) (t2 (wait ?x)))))
        (define-rap (find => ?x) (succeed (q a ?x)))
        """
        + WAIT,
        "(top)",
        facts=["(q a thing)"],
        times=[at(5, "(p thing)")],
    )
    assert ran.told("selected", "blocked", times=True)[:3] == [
        "0 selected top",
        "0 selected find",
        "0 blocked wait on (p thing)",
    ]
    assert ran.told("asked", times=True) == ["5 asked (act thing)"]


def test_a_monitored_task_is_tested_when_order_and_start_allow_it() -> None:
    ran = play(
        """
        (define-rap (top)
          (method (task-net (t1 (use a) (for t2)) (t2 (wait b))
                            (t3 (wait c) (window now 8 20)))))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """
        + WAIT,
        "(top)",
        rows=[row("(act a)", takes=3)],
        times=[at(10, "(p b)", "(p c)")],
    )
    assert ran.told("blocked", times=True) == [
        "3 blocked wait on (p b)",
        "8 blocked wait on (p c)",
    ]


def test_function_of_a_resource_is_tested_on_its_change() -> None:
    ran = play(
        """
        (declare-memory-function enough (?counter) :reads ())
        (define-rap (top) (resources (counter ?c))
          (method (task-net (t1 (watch ?c)) (t2 (rest) (counter-add ?c 2)))))
        (define-rap (rest) (method (primitive (slow it))))
        (define-rap (watch ?c) (monitor-state (enough ?c))
          (method (primitive (act a))))
        """,
        "(top)",
        functions={"enough": lambda view, counter: counter.value > 1},
        rows=[row("(slow it)", after=4)],
    )
    assert ran.told("asked", times=True)[-1] == "4 asked (act a)"
