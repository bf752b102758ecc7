"""Inputs, `succeed`, outputs [L 3]."""

from __future__ import annotations

import pytest

from .helpers import play, row


def test_an_unbound_input_fails_the_step() -> None:
    ran = play(
        """
        (define-rap (top) (method (task-net (t1 (use ?never)))))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """,
        "(top)",
    )
    assert ran.told("created", "failed")[:3] == [
        "created (top)",
        "created (use ?never)",
        "failed (use ?never) interference interference",
    ]
    assert ran.told("asked") == []


def test_a_for_formula_binds_an_input() -> None:
    ran = play(
        """
        (define-rap (top)
          (succeed (last-result okay))
          (method (task-net (t1 (rest) ((p ?x) for t2)) (t2 (use ?x)))))
        (define-rap (rest) (method (task-net)))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """,
        "(top)",
        facts=["(p a)"],
    )
    assert ran.told("created") == [
        "created (top)",
        "created (rest)",
        "created (use ?x)",
    ]
    assert ran.told("asked") == ["asked (act a)"]


def test_all_for_formulas_are_tried_for_an_input_not_only_the_first() -> None:
    ran = play(
        """
        (define-rap (top)
          (method (task-net (t1 (rest) ((p ?x) for t3))
                            (t2 (rest) ((q ?y ?z) for t3))
                            (t3 (use ?x ?y)))))
        (define-rap (rest) (method (task-net)))
        (define-rap (use ?x ?y) (method (primitive (act ?y))))
        """,
        "(top)",
        facts=["(p a)", "(q b c)"],
    )
    assert ran.told("asked") == ["asked (act b)"]


def test_succeed_is_looked_at_before_anything_is_done() -> None:
    ran = play(
        "(define-rap (get ?x) (succeed (p ?x)) (method (primitive (act ?x))))",
        "(get a)",
        facts=["(p a)"],
    )
    assert ran.told("selected", "asked", "succeeded", "over") == [
        "selected get",
        "succeeded (get a)",
        "over done",
    ]


def test_succeed_comes_before_monitors_and_preconditions() -> None:
    ran = play(
        """
        (define-rap (get ?x) (succeed (p ?x)) (preconditions nil)
          (method (primitive (act ?x))))
        """,
        "(get a)",
        facts=["(p a)"],
    )
    assert ran.told("succeeded") == ["succeeded (get a)"]


def test_without_succeed_a_good_method_is_success() -> None:
    ran = play("(define-rap (get ?x) (method (primitive (act ?x))))", "(get a)")
    assert ran.told("selected", "ended", "succeeded") == [
        "selected get",
        "ended get #1 okay",
        "selected get",
        "succeeded (get a)",
    ]


def test_a_rap_without_a_method_succeeds_or_has_no_method() -> None:
    text = "(define-rap (get ?x) (succeed (p ?x)))"
    assert play(text, "(get a)", facts=["(p a)"]).told("failed") == []
    failed = play(text, "(get b)", facts=["(p a)"]).told("failed")
    assert failed == ["failed (get b) no-method no-method"]


def test_outputs_are_bound_by_succeed() -> None:
    ran = play(
        """
        (define-rap (top) (method (task-net (t1 (find ?x) (for t2)) (t2 (use ?x)))))
        (define-rap (top2)
          (method (task-net (t1 (find a => ?where) (for t2)) (t2 (use ?where)))))
        (define-rap (find ?x => ?where)
          (succeed (and (q ?x ?where) (last-result okay)))
          (method (primitive (look ?x))))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """,
        "(top2)",
        facts=["(q a shelf)", "(q a floor)"],
    )
    assert ran.told("asked") == ["asked (look a)", "asked (act shelf)"]
    assert "succeeded (find a => shelf)" in ran.told("succeeded")


def test_outputs_fall_back_on_the_last_good_method() -> None:
    ran = play(
        """
        (define-rap (top)
          (method (task-net (t1 (find => ?a ?b) (for t2)) (t2 (use ?a ?b)))))
        (define-rap (find => ?a ?b)
          (succeed (and (last-result okay) (p ?b)))
          (method (context (q ?a ?b)) (primitive (look ?a))))
        (define-rap (use ?x ?y)
          (method (task-net (t1 (one ?x)) (t2 (one ?y) (for t1)))))
        (define-rap (one ?x) (method (primitive (act ?x))))
        """,
        "(top)",
        facts=["(q first second)", "(p mine)"],
    )
    # ?b comes from `succeed`, ?a from the method's environment
    assert "succeeded (find => first mine)" in ran.told("succeeded")
    assert ran.told("asked")[1:] == ["asked (act mine)", "asked (act first)"]


def test_failed_method_gives_no_outputs() -> None:
    ran = play(
        """
        (define-rap (top) (method (task-net (t1 (find => ?a)))))
        (define-rap (find => ?a) (succeed (or (last-result okay) (last-result jammed)))
          (method (context (p ?a)) (primitive (act ?a))))
        """,
        "(top)",
        facts=["(p thing)"],
        rows=[row("(act thing)", "jammed")],
    )
    assert ran.told("succeeded") == ["succeeded (find => ?a)", "succeeded (top)"]


def test_an_output_left_unbound_leaves_the_variable_unbound() -> None:
    ran = play(
        """
        (define-rap (top)
          (method (task-net (t1 (find => ?a) (for t2)) (t2 (use ?a)))))
        (define-rap (find => ?a) (method (task-net)))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """,
        "(top)",
    )
    assert ran.told("failed")[0] == "failed (use ?a) interference interference"


@pytest.mark.parametrize(
    ("outputs", "good"),
    [
        ("?new", True),
        ("here", True),
        ("there", False),
        ("?", True),
        ("?place", True),
        ("?other", False),
        ("?new ?new", True),
    ],
)
def test_unequal_output_fails_the_task(outputs: str, good: bool) -> None:
    """`?place` is bound to `here` beforehand, `?other` to `there`."""
    twice = "?b" if " " in outputs else ""
    ran = play(
        f"""
        (define-rap (top)
          (method (context (and (p ?place) (color other ?other)))
                  (task-net (t1 (find => {outputs})))))
        (define-rap (find => ?a {twice})
          (succeed (and (last-result okay) (color it ?a) (color it ?b)))
          (method (task-net)))
        """,
        "(top)",
        facts=["(p here)", "(color it here)", "(color other there)"],
    )
    failed = ran.told("failed")
    if good:
        assert failed == []
    else:
        assert failed[0] == f"failed (find => {'?a'}) interference interference"
        assert ran.told("succeeded") == []


def test_two_outputs_of_one_step_must_agree() -> None:
    ran = play(
        """
        (define-rap (top) (method (task-net (t1 (find => ?x ?x)))))
        (define-rap (find => ?a ?b) (succeed (q ?a ?b)))
        """,
        "(top)",
        facts=["(q one two)"],
    )
    assert ran.told("failed")[0].startswith("failed (find => ?a ?b) interference")


def test_inputs_are_read_when_the_step_may_run() -> None:
    """The amount is what the counter holds then, not when the method started."""
    ran = play(
        """
        (define-rap (top)
          (resources (counter ?c 1))
          (method (task-net (t1 (rest) (counter-add ?c 4) (for t2))
                            (t2 (use (value ?c))))))
        (define-rap (rest) (method (task-net)))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """,
        "(top)",
    )
    assert ran.told("asked") == ["asked (act 5)"]


def test_computed_inputs_need_their_variables() -> None:
    ran = play(
        """
        (define-rap (top ?n)
          (method (task-net (t1 (find => ?m) (for t2)) (t2 (use (+ ?n ?m))))))
        (define-rap (find => ?m) (succeed (color size ?m)))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """,
        "(top 2)",
        facts=["(color size 3)"],
    )
    assert ran.told("asked") == ["asked (act 5)"]
    assert ran.told("created")[-1] == "created (use (+ 2 ?m))"


def test_an_ill_typed_input_is_a_fault_and_interference() -> None:
    ran = play(
        """
        (define-rap (top ?n) (method (task-net (t1 (use (+ ?n 1))))))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """,
        "(top three)",
    )
    assert "`three` is not a number" in ran.told("fault")[0]
    assert ran.told("failed")[0] == "failed (use (+ three 1)) interference interference"
