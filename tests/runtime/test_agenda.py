"""Who is chosen among the eligible [L 4] [T 3.2.4]."""

from __future__ import annotations

from collections import Counter

import pytest

from .helpers import Play, at, play, row

USE = "(define-rap (use ?x) (method (primitive (act ?x))))"


def order(ran: Play) -> str:
    """The arguments of all requests, in one word."""
    return "".join(line.split()[-1].strip(")") for line in ran.told("asked"))


def test_higher_priority_goes_first() -> None:
    tasks = ["(use a)", "(use b) :priority 5", "(use c) :priority -1"]
    for seed in range(5):
        assert order(play(USE, *tasks, seed=seed)) == "bac"


def test_a_steps_priority_adds_to_its_parents() -> None:
    text = USE + "(define-rap (top ?x) (method (task-net (t1 4 (use ?x)))))"
    for seed in range(5):
        ran = play(text, "(top a) :priority 1", "(use b) :priority 4", seed=seed)
        # (top a) has 1 and waits for (use b); its step then has 5
        assert order(ran) == "ba"
        made = [line.split()[-1] for line in ran.told("created")]
        assert len(made) == 3
        ran = play(text, "(top a) :priority 4", "(use b) :priority 5", seed=seed)
        assert order(ran) == "ba"


def test_a_running_task_is_taken_over_by_steps_of_higher_priority() -> None:
    text = USE + "(define-rap (top) (method (task-net (t1 (use a)) (t2 7 (use b)))))"
    assert order(play(text, "(top)", "(use c) :priority 3")) == "cba"


def test_the_earlier_latest_start_goes_first() -> None:
    text = USE + "(define-rap (long ?x) (duration 30) (method (primitive (act ?x))))"
    tasks = ["(use a) :deadline 50", "(long b) :deadline 70", "(use c)"]
    for seed in range(5):
        # latest starts: 50, 70 - 30 = 40, none
        assert order(play(text, *tasks, seed=seed)) == "bac"


def test_priority_comes_before_deadline() -> None:
    tasks = ["(use a) :deadline 5", "(use b) :priority 1"]
    assert order(play(USE, *tasks)) == "ba"


def test_deadlines_are_inherited_and_the_nearest_counts() -> None:
    text = (
        USE
        + """
        (define-rap (top)
          (method (task-net (t1 (use a) (window now 0 80))
                            (t2 (use b) (window now 0 20))
                            (t3 (use c)))))
        """
    )
    for seed in range(5):
        # 20 of its own, 40 of the parent for the two others, 50 and 60
        ran = play(
            text,
            "(top) :deadline 40",
            "(use d) :deadline 60",
            "(use e) :deadline 50",
            seed=seed,
        )
        assert order(ran) in ("baced", "bcaed")


def test_a_computed_duration_counts_from_when_its_inputs_are_known() -> None:
    text = (
        USE
        + """
        (define-rap (long ?x ?n) (duration (* 2 ?n)) (method (primitive (act ?x))))
        """
    )
    tasks = ["(use a) :deadline 50", "(long b 12) :deadline 70"]
    assert order(play(text, *tasks)) == "ba"
    tasks = ["(use a) :deadline 50", "(long b 9) :deadline 70"]
    assert order(play(text, *tasks)) == "ab"


def test_tasks_with_failed_methods_are_selected_last() -> None:
    text = """
        (define-rap (use ?x) (succeed (p ?x)) (method (primitive (act ?x))))
        """
    rows = [
        row("(act a)", "jammed", times=1),
        row("(act ?x)", "okay", asserts=["(p ?x)"]),
    ]
    for seed in range(10):
        ran = play(text, "(use a)", "(use b)", "(use c)", rows=rows, seed=seed)
        told = order(ran)
        # whenever a has failed, b and c, if still there, are served before it
        rest = told[told.index("a") + 1 :]
        assert rest[-1] == "a"
        assert sorted(told) == ["a", "a", "b", "c"]


def test_the_family_on_top_of_the_stack_goes_on() -> None:
    text = (
        USE
        + """
        (define-rap (top ?x ?y ?z)
          (method (task-net (t1 (use ?x)) (t2 (use ?y)) (t3 (use ?z)))))
        """
    )
    tasks = ["(top a a a)", "(top b b b)", "(top c c c)"]
    for seed in range(10):
        told = order(play(text, *tasks, seed=seed))
        assert {told[:3], told[3:6], told[6:]} == {"aaa", "bbb", "ccc"}


def test_a_family_interrupted_by_a_higher_priority_is_taken_up_again() -> None:
    """The stack remembers who was at work (push, then pop)."""
    text = """
        (define-rap (top ?x)
          (method (task-net (t1 (use ?x)) (t2 (use ?x)) (t3 (use ?x)))))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """
    for seed in range(10):
        ran = play(
            text,
            "(top a)",
            "(top b)",
            "(top h) :priority 2 :at 1",
            rows=[row("(act ?)", takes=1)],
            seed=seed,
        )
        told = order(ran)
        first = told[0]
        assert told[1:4] == "hhh"
        assert told[4:6] == first * 2
        assert len(ran.told("switched")) == 3


def test_another_family_at_the_tops_priority_replaces_it() -> None:
    """When the first family has nothing eligible, the second takes its place."""
    text = """
        (define-rap (top ?x)
          (method (task-net (t1 (use ?x) (for t2)) (t2 (slowly ?x) (for t3))
                            (t3 (use ?x) (for t4)) (t4 (use ?x)))))
        (define-rap (use ?x) (method (primitive (act ?x))))
        (define-rap (slowly ?x) (method (primitive (slow ?x))))
        """
    for seed in range(10):
        ran = play(
            text,
            "(top a)",
            "(top b)",
            rows=[row("(slow ?)", after=5)],
            seed=seed,
        )
        told = order(ran)
        first, second = told[0], "b" if told[0] == "a" else "a"
        # both wait for their slow primitives, which end at one time: the stack still
        # says who came last
        assert told[:4] == first * 2 + second * 2
        assert told[4:] == second * 2 + first * 2


def test_chance_is_drawn_once_among_candidates_in_order_of_number() -> None:
    counts = Counter(
        order(play(USE, "(use a)", "(use b)", "(use c)", seed=seed))[0]
        for seed in range(90)
    )
    assert all(18 < counts[name] < 42 for name in "abc")


def test_a_single_candidate_draws_nothing() -> None:
    """So what comes before does not change what chance decides later."""
    text = (
        USE
        + "(define-rap (top) (method (task-net (t1 (use x) (for t2)) (t2 (use y)))))"
    )
    for seed in range(20):
        plain = order(play(USE, "(use a)", "(use b)", seed=seed))
        later = play(
            text, "(top)", "(use a) :at 9", "(use b) :at 9", seed=seed, times=[at(1)]
        )
        assert order(later) == "xy" + plain


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_step_bound_late_takes_its_place_anew(seed: int) -> None:
    """Eligible with an unbound input, then bound: its duration counts from then on."""
    text = (
        USE
        + """
        (define-rap (top)
          (method (task-net (t1 5 (find => ?n)) (t2 (long b ?n) (window now 0 70))
                            (t3 (use a) (window now 0 50)))))
        (define-rap (find => ?n) (succeed (color size ?n)))
        (define-rap (long ?x ?n) (duration ?n) (method (primitive (act ?x))))
        """
    )
    ran = play(text, "(top)", facts=["(color size 30)"], seed=seed)
    assert order(ran) == "ba"
    ran = play(text, "(top)", facts=["(color size 10)"], seed=seed)
    assert order(ran) == "ab"


def test_a_constant_duration_counts_while_inputs_are_unbound() -> None:
    """Duration waits for inputs only if it uses one that is unbound."""
    text = (
        USE
        + """
        (define-rap (top)
          (method (task-net (t2 (long ?n) (window now 0 70))
                            (t3 (use a) (window now 0 50) ((p ?n) for t4))
                            (t4 (use ?n)))))
        (define-rap (long ?n) (duration 30) (method (primitive (act ?n))))
        """
    )
    for seed in range(5):
        ran = play(text, "(top)", facts=["(p z)"], seed=seed)
        # its latest start is 40: it is selected first, and fails for want of ?n
        assert ran.told("asked", "failed")[0] == (
            "failed (long ?n) interference interference"
        )
