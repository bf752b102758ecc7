"""Sets and counters [L 6] [T 4.8]."""

from __future__ import annotations

import pytest

from rapc.events import TaskFailed
from rapc.runtime.settings import Settings

from .helpers import Play, play, row

REST = "(define-rap (rest) (method (task-net)))"
USE = "(define-rap (use ?x) (method (primitive (act ?x))))"


def test_effects_are_traced_by_value_in_the_order_of_the_text() -> None:
    ran = play(
        REST
        + """
        (define-rap (top) (resources (counter ?c 5) (set ?s))
          (method (task-net (t1 (rest) (counter-add ?c 2) (counter-sub ?c 9)
                                       (set-add ?s b) (set-add ?s a) (set-sub ?s b)
                                       (set-sub ?s missing)))))
        """,
        "(top)",
    )
    assert ran.told("changed") == [
        "changed rest counter-add 2: #counter(7)",
        "changed rest counter-sub 9: #counter(-2)",
        "changed rest set-add b: #set(b)",
        "changed rest set-add a: #set(b a)",
        "changed rest set-sub b: #set(a)",
        "changed rest set-sub missing: #set(a)",
    ]


def test_resources_live_through_failed_methods() -> None:
    ran = play(
        REST
        + USE
        + """
        (define-rap (top) (resources (counter ?c)) (succeed (= (value ?c) 2))
          (method (task-net (t1 (rest) (counter-add ?c 1) (for t2)) (t2 (use a)))))
        """,
        "(top)",
        rows=[row("(act a)", "jammed", times=2)],
    )
    assert ran.told("changed") == [
        "changed rest counter-add 1: #counter(1)",
        "changed rest counter-add 1: #counter(2)",
    ]


def test_arguments_pass_them_by_reference() -> None:
    ran = play(
        REST
        + """
        (define-rap (top) (resources (counter ?c)) (succeed (= (value ?c) 1))
          (method (task-net (t1 (inner ?c)))))
        (define-rap (inner ?d) (method (task-net (t1 (rest) (counter-add ?d 1)))))
        """,
        "(top)",
    )
    assert ran.told("created")[1] == "created (inner #counter(0))"
    assert ran.told("succeeded")[-1] == "succeeded (top)"


def test_a_resources_clause_copies() -> None:
    ran = play(
        REST
        + """
        (define-rap (top) (resources (counter ?c 3) (set ?s))
          (succeed (and (last-result okay) (= (value ?c) 3) (empty ?s)))
          (method (task-net (t1 (inner ?c ?s)))))
        (define-rap (inner ?d ?t)
          (resources (counter ?e ?d) (set ?u ?t))
          (method (task-net (t1 (rest) (counter-add ?e 1) (set-add ?u a)))))
        """,
        "(top)",
    )
    assert ran.told("changed", "succeeded") == [
        "succeeded (rest)",
        "changed rest counter-add 1: #counter(4)",
        "changed rest set-add a: #set(a)",
        "succeeded (inner #counter(3) #set())",
        "succeeded (top)",
    ]


def test_a_task_made_twice_has_resources_of_its_own_each_time() -> None:
    ran = play(
        REST
        + """
        (define-rap (top) (method (task-net (t1 (inner) (for t2)) (t2 (inner)))))
        (define-rap (inner) (resources (counter ?c))
          (method (task-net (t1 (rest) (counter-add ?c 1)))))
        """,
        "(top)",
    )
    assert ran.told("changed") == ["changed rest counter-add 1: #counter(1)"] * 2


def test_effects_run_only_if_the_step_succeeds() -> None:
    ran = play(
        USE
        + """
        (define-rap (top) (resources (counter ?c))
          (method (task-net (t1 (use a) (counter-add ?c 1)))))
        """,
        "(top)",
        rows=[row("(act a)", "jammed")],
    )
    assert ran.told("changed") == []


@pytest.mark.parametrize(
    "effect",
    [
        "(counter-add ?c ?never)",
        "(counter-add ?c word)",
        "(counter-add ?s 1)",
        "(set-add ?c a)",
        "(set-add ?s ?c)",
        "(counter-add ?x 1)",
        "(counter-sub ?c (/ 1 0))",
    ],
)
def test_impossible_effect_fails_the_step(
    effect: str,
) -> None:
    ran = play(
        REST
        + f"""
        (define-rap (top ?x) (resources (counter ?c) (set ?s))
          (method (task-net (t1 (rest) (counter-add ?c 1) {effect}))))
        """,
        "(top plain)",
    )
    assert ran.told("changed") == []
    assert ran.told("failed")[0] == "failed (rest) interference interference"
    assert len(ran.told("fault")) >= 1


def test_effect_uses_outputs_of_its_step() -> None:
    ran = play(
        """
        (define-rap (top) (resources (counter ?c))
          (method (task-net (t1 (find => ?n) (counter-add ?c ?n)))))
        (define-rap (find => ?n) (succeed (color size ?n)))
        """,
        "(top)",
        facts=["(color size 4)"],
    )
    assert ran.told("changed") == ["changed find counter-add 4: #counter(4)"]


def test_unequal_outputs_prevent_the_effects() -> None:
    ran = play(
        """
        (define-rap (top) (resources (counter ?c))
          (method (task-net (t1 (find => wrong) (counter-add ?c 1)))))
        (define-rap (find => ?n) (succeed (color size ?n)))
        """,
        "(top)",
        facts=["(color size 4)"],
    )
    assert ran.told("changed") == []


@pytest.mark.parametrize(
    ("clause", "value"), [("(counter ?c ?x)", "word"), ("(set ?s ?x)", "3")]
)
def test_a_first_value_of_the_wrong_kind_fails_the_task(
    clause: str, value: str
) -> None:
    ran = play(
        f"(define-rap (top ?x) (resources {clause}) (method (task-net)))",
        f"(top {value})",
    )
    assert len(ran.told("fault")) == 1
    assert ran.told("failed") == [f"failed (top {value}) interference interference"]


def test_a_first_value_may_be_computed_from_inputs() -> None:
    ran = play(
        USE
        + """
        (define-rap (top ?n) (resources (counter ?c (* 2 ?n)))
          (method (task-net (t1 (use (value ?c))))))
        """,
        "(top 2.5)",
    )
    assert ran.told("asked") == ["asked (act 5)"]


def test_a_resource_handed_to_a_primitive_fails_the_request() -> None:
    ran = play(
        "(define-rap (top) (resources (counter ?c)) (method (primitive (act ?c))))",
        "(top)",
    )
    assert ran.told("asked") == []
    assert ran.told("ended")[0] == "ended top #1 interference"


def test_bindings_are_told_in_order_and_by_value() -> None:
    ran = play(
        REST
        + """
        (define-rap (top ?z ?a) (resources (set ?y) (counter ?b 1))
          (repeat-while (q ?x ?w))
          (method (context (p ?v)) (task-net)))
        """,
        "(top 1 2)",
        facts=["(q x1 w1)", "(p v1)"],
    )
    (bound,) = (e.bindings for e in ran.events if hasattr(e, "bindings"))
    assert list(bound.items()) == [
        ("?z", 1),
        ("?a", 2),
        ("?y", "#set()"),
        ("?b", "#counter(1)"),
        ("?x", "x1"),
        ("?w", "w1"),
        ("?v", "v1"),
    ]


DOUBLE = """
(define-rap (top) (resources (counter ?c {first})) (succeed (< (value ?c) 0))
  (method (task-net (t1 (rest) {effects}))))
"""


@pytest.mark.parametrize("first", ["1", "1.5", "-2"])
def test_a_counter_stays_a_number_however_often_it_is_doubled(first: str) -> None:
    text = REST + DOUBLE.format(first=first, effects="(counter-add ?c (value ?c))")
    ran = play(text.replace("(< (value ?c) 0)", "nil"), "(top)")
    assert 980 < len(ran.told("changed")) < 1010
    assert "the result is too large" in ran.told("fault")[0]
    assert "failed (rest) interference interference" in ran.told("failed")


def test_combined_effects_are_validated_first() -> None:
    most = "(* " + " ".join(["1024"] * 99) + ")"
    text = REST + DOUBLE.format(
        first=most, effects=f"(counter-sub ?c 1) {f'(counter-add ?c {most})' * 1100}"
    )
    ran = play(text, "(top)")
    assert ran.told("changed") == []
    assert ran.told("failed")[0] == "failed (rest) interference interference"


def test_nothing_is_counted_where_a_counter_stands_for_a_place() -> None:
    """A question may hold any value; hosts alone are told what they hand over."""
    ran = play(
        REST
        + """
        (define-rap (top) (resources (counter ?c 5))
          (method empty (context (count rock ?c 0)) (task-net (t1 (rest)))))
        """,
        "(top)",
    )
    assert ran.interpreter.succeeded


TWO = (
    REST
    + USE
    + """
    (define-rap (top) (resources (counter ?c))
      (method with-counts (context (not (method-tried with-counts)))
        (task-net (t1 (inner a) (for t2)) (t2 (inner b))))
      (method in-the-world (context otherwise) (task-net (t1 (use a)))))
    (define-rap (inner ?x) (resources (counter ?d) (set ?s))
      (method (task-net (t1 (use ?x)))))
    """
)


def _limited(most: int, *tasks: str) -> Play:
    return Play(TWO, *tasks, settings=Settings(max_resources=most))


def test_task_over_the_limit_gets_no_resources() -> None:
    ran = _limited(4, "(top)").run()
    assert ran.told("asked") == ["asked (act a)", "asked (act a)"]
    (failed,) = ran.of(TaskFailed)
    assert (failed.because.clause, failed.because.part) == (
        "resources of `inner`",
        "(counter ?d)",
    )
    assert "more than 4 sets and counters" in failed.because.note
    assert not _limited(5, "(top)").run().of(TaskFailed)


def test_task_without_its_resources_fails_when_selected() -> None:
    ran = _limited(4, "(top)").run()
    told = ran.told("asked", "failed", "chosen")
    assert told[:-4] == [
        "chosen top with-counts",
        "chosen inner #1",
        "chosen use #1",
        "asked (act a)",
    ]
    assert told[-4:] == [
        "failed (inner b) interference interference",
        "chosen top in-the-world",
        "chosen use #1",
        "asked (act a)",
    ]


def test_ended_tasks_free_their_resources() -> None:
    tasks = [f"(inner {x}) :at {at}" for at, x in enumerate("abc")]
    ran = _limited(2, *tasks).run()
    assert [one.outcome for one in ran.interpreter.results()] == ["succeeded"] * 3


def test_restored_run_counts_the_resources_of_its_tasks() -> None:
    ran = _limited(5, "(top)")
    other = _limited(5)
    for _ in range(3):
        ran.interpreter.step()
        other.interpreter.restore(ran.interpreter.save())
        assert other.interpreter.state.resources == ran.interpreter.state.resources == 5
