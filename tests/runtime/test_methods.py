"""Choosing methods, futile loops, recursion, solvers (semantics 3, steps 6 to 9)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import pytest

from rapc.ir import nodes
from rapc.runtime.machine import Settings

from .helpers import Play, at, compiled, play, row


def chosen(ran: Play) -> str:
    """The names of the methods chosen, in order, in one word."""
    return "".join(line.split()[-1] for line in ran.told("chosen"))


def test_only_methods_whose_context_holds_are_chosen() -> None:
    text = """
        (define-rap (top)
          (method a (context (p left)) (task-net))
          (method b (context (p right)) (task-net)))
        """
    assert chosen(play(text, "(top)", facts=["(p right)"])) == "b"
    assert play(text, "(top)").told("failed") == ["failed (top) no-method no-method"]


def test_a_method_without_context_always_holds() -> None:
    assert chosen(play("(define-rap (top) (method a (task-net)))", "(top)")) == "a"


def test_the_method_that_failed_least_is_chosen() -> None:
    """After one failure of each both are as good: so all are tried twice."""
    text = """
        (define-rap (top)
          (method a (primitive (act a)))
          (method b (primitive (act b)))
          (method c (primitive (act c))))
        """
    rows = [row("(act ?)", "jammed")]
    for seed in range(8):
        order = chosen(play(text, "(top)", rows=rows, seed=seed))
        assert sorted(order[:3]) == sorted(order[3:]) == ["a", "b", "c"]
        failed = play(text, "(top)", rows=rows, seed=seed).told("failed")
        assert failed == ["failed (top) futile-loop jammed"]


def test_the_method_chosen_least_is_chosen_among_those_that_never_failed() -> None:
    """A method that ended well has not failed, whatever `succeed` says then."""
    text = """
        (define-rap (top) (succeed (p done))
          (method a (primitive (act a)))
          (method b (primitive (act b))))
        """
    for seed in range(8):
        order = chosen(play(text, "(top)", seed=seed))
        assert sorted(order[:2]) == sorted(order[2:]) == ["a", "b"]


def test_failures_count_for_a_method_whatever_its_bindings() -> None:
    """And the choices are counted with the bindings that it would have now."""
    ran = play(
        """
        (define-rap (top) (succeed (p done))
          (method a (context (and (q a ?x) (not (color ?x used)))) (primitive (act ?x)))
          (method b (primitive (look b))))
        """,
        "(top)",
        facts=["(q a one)", "(q a two)", "(q a three)"],
        rows=[
            row("(act ?x)", asserts=["(color ?x used)"]),
            row("(look b)", "dropped", times=1),
        ],
        seed=1,
    )
    # b fails once and then stands back while a, each time with other bindings, holds
    order = chosen(ran)
    assert order.replace("b", "", 1).startswith("aaa")


def test_chance_decides_between_equals_and_draws_from_the_seed() -> None:
    text = "(define-rap (top) (method a (task-net)) (method b (task-net)))"
    first = Counter(chosen(play(text, "(top)", seed=seed)) for seed in range(60))
    again = Counter(chosen(play(text, "(top)", seed=seed)) for seed in range(60))
    assert first == again
    assert 15 < first["a"] < 45


def test_a_choice_is_allowed_twice_and_then_is_a_futile_loop() -> None:
    text = "(define-rap (top) (succeed (p done)) (method a (primitive (act a))))"
    ran = play(text, "(top)")
    assert ran.told("asked", "failed") == [
        *["asked (act a)"] * 2,
        "failed (top) futile-loop futile-loop",
    ]


@pytest.mark.parametrize("limit", [1, 5])
def test_the_futile_limit_is_a_setting(limit: int) -> None:
    text = "(define-rap (top) (succeed (p done)) (method a (primitive (act a))))"
    ran = play(text, "(top)", settings=Settings(futile_limit=limit))
    assert len(ran.told("asked")) == limit


def test_other_bindings_are_another_choice() -> None:
    ran = play(
        """
        (define-rap (top) (succeed (p done))
          (method a (context (color it ?x)) (primitive (act ?x))))
        """,
        "(top)",
        facts=["(color it 1)"],
        rows=[
            row("(act 1)", times=2, asserts=["(color it 2)"]),
            row("(act 2)", times=1, asserts=["(color it 3)"]),
            row("(act 3)", times=1, asserts=["(p done)"]),
        ],
    )
    assert ran.told("failed") == []
    assert len(ran.told("asked")) == 3


def test_a_resource_that_has_changed_makes_another_choice() -> None:
    ran = play(
        """
        (define-rap (top) (succeed (= (value ?c) 5)) (resources (counter ?c))
          (method (task-net (t1 (rest) (counter-add ?c 1)))))
        (define-rap (rest) (method (task-net)))
        """,
        "(top)",
    )
    assert ran.told("failed") == []
    assert len(ran.told("chosen")) == 10


def test_a_monitor_that_blocks_starts_the_futile_loop_afresh() -> None:
    ran = play(
        """
        (define-rap (top) (monitor-state (go)) (succeed (p done))
          (method a (primitive (act a))))
        """,
        "(top)",
        facts=["(go)"],
        rows=[row("(act a)", times=2), row("(act a)", erases=["(go)"], times=1)],
        times=[],
    )
    assert ran.told("failed") == ["failed (top) futile-loop futile-loop"]
    ran = play(
        """
        (define-rap (top) (monitor-state (go)) (succeed (p done))
          (method a (primitive (act a))))
        """,
        "(top)",
        facts=["(go)"],
        rows=[row("(act a)", times=1), row("(act a)", erases=["(go)"], times=1)],
        times=[at(5, "(go)")],
    )
    # two, blocked at 0, woken at 5, and two more are allowed
    assert ran.told("asked", "blocked", "failed", times=True) == [
        "0 asked (act a)",
        "0 asked (act a)",
        "0 blocked top on (go)",
        "5 asked (act a)",
        "5 asked (act a)",
        "5 failed (top) futile-loop futile-loop",
    ]


def test_method_tried_and_results_tell_of_the_task_that_asks() -> None:
    ran = play(
        """
        (define-rap (top)
          (succeed (and (result-with-method a jammed) (result-with-method b okay)))
          (method a (context (not (method-tried a))) (primitive (act a)))
          (method b (context (and (method-tried a) (last-result ?r) (= ?r jammed)))
                    (primitive (look b))))
        """,
        "(top)",
        rows=[row("(act a)", "jammed")],
    )
    assert chosen(ran) == "ab"
    assert ran.told("succeeded") == ["succeeded (top)"]


def test_in_a_for_formula_history_is_the_parents() -> None:
    ran = play(
        """
        (define-rap (top)
          (method one (task-net (t1 (rest) ((method-tried one) for t2)) (t2 (use)))))
        (define-rap (rest) (method (task-net)))
        (define-rap (use) (method two (primitive (act a))))
        """,
        "(top)",
    )
    assert ran.told("failed") == []


# --- recursion ---------------------------------------------------------------------


def test_a_step_equal_to_an_ancestor_fails_the_task_before_its_method_starts() -> None:
    ran = play(
        """
        (define-rap (top ?x) (method a (task-net (t1 (mid ?x)))))
        (define-rap (mid ?x) (method b (task-net (t1 (use) (for t2)) (t2 (top ?x)))))
        (define-rap (use) (method (primitive (act a))))
        """,
        "(top 1)",
    )
    assert ran.told("created", "chosen", "asked", "failed") == [
        "created (top 1)",
        "chosen top a",
        "created (mid 1)",
        "failed (mid 1) futile-loop futile-loop",
        "chosen top a",
        "created (mid 1)",
        "failed (mid 1) futile-loop futile-loop",
        "failed (top 1) futile-loop futile-loop",
    ]


def test_other_inputs_are_no_recursion() -> None:
    ran = play(
        """
        (define-rap (count-down ?n)
          (succeed (or (= ?n 0) (last-result okay)))
          (method (task-net (t1 (count-down (- ?n 1))))))
        """,
        "(count-down 20)",
    )
    assert ran.told("succeeded")[0] == "succeeded (count-down 0)"
    assert len(ran.told("succeeded")) == 21


def test_recursion_found_when_the_last_input_is_bound() -> None:
    """After the outputs and effects of the step that bound it, in the same cycle."""
    ran = play(
        """
        (define-rap (top ?x) (resources (counter ?c))
          (method a (task-net (t1 (find => ?y) (counter-add ?c 1))
                              (t2 (rest) (until-end t1))
                              (t3 (top ?y) (for t4)) (t4 (use)))))
        (define-rap (find => ?y) (succeed (p ?y)))
        (define-rap (rest) (monitor-state (go)) (method (task-net)))
        (define-rap (use) (method (primitive (act a))))
        """,
        "(top 1)",
        facts=["(p 1)"],
        seed=3,
    )
    told = ran.told("succeeded", "changed", "removed", "ended", "failed")
    start = told.index("succeeded (find => 1)")
    assert told[start:] == [
        "succeeded (find => 1)",
        "changed find counter-add 1: #counter(1)",
        "removed rest until",
        "removed top parent-failed",
        "removed use parent-failed",
        "ended top a futile-loop",
        "failed (top 1) futile-loop futile-loop",
    ]
    cycles = {event.cycle for event in ran.events[-3:]}
    assert len(cycles) == 1


def test_a_for_formula_that_binds_a_recursion_fails_the_parent() -> None:
    ran = play(
        """
        (define-rap (top ?x)
          (method a (task-net (t1 (rest) ((p ?y) for t2)) (t2 (use) (for t3))
                              (t3 (top ?y)))))
        (define-rap (rest) (method (task-net)))
        (define-rap (use) (method (primitive (act a))))
        """,
        "(top 1)",
        facts=["(p 1)"],
    )
    assert ran.told("asked") == []
    assert ran.told("failed") == ["failed (top 1) futile-loop futile-loop"]


def test_an_ancestor_is_compared_by_the_value_its_resource_had() -> None:
    """The counter grows, and yet the step asks for what its ancestor asked for."""
    text = """
        (define-rap (top) (resources (counter ?c))
          (method (task-net (t1 (work ?c)))))
        (define-rap (work ?c)
          (method (task-net (t1 (rest) {effect} (for t2)) (t2 (work ?c)))))
        (define-rap (rest) (method (task-net)))
        """
    same = play(text.format(effect=""), "(top)")
    assert same.told("created")[:2] == ["created (top)", "created (work #counter(0))"]
    assert same.told("chosen").count("chosen work #1") == 0
    # t2's inputs are bound when the method starts: the effect comes too late for it
    grown = play(text.format(effect="(counter-add ?c 1)"), "(top)")
    assert grown.told("chosen").count("chosen work #1") == 0


# --- solvers -------------------------------------------------------------------------


def method(text: str) -> nodes.Method:
    """A method from text."""
    library = compiled(f"(define-rap (for-its-method) {text})").library
    return library.raps["for-its-method"].methods[0]


def test_a_solver_is_asked_when_no_method_holds_and_adds_methods() -> None:
    asked: list[Any] = []

    def solver(goal: Any, view: Any) -> Sequence[nodes.Method]:
        asked.append((goal, view.query("p", None)))
        return [method("(method new (primitive (look ?x)))")]

    text = """
        (define-rap (top ?x) (succeed (p done))
          (method old (context (p old)) (primitive (act ?x))))
        """
    ran = play(
        text,
        "(top 3)",
        facts=["(p b)"],
        solvers={"top": solver},
        rows=[row("(look 3)", asserts=["(p done)"])],
    )
    assert asked == [(("top", 3), [("p", "b")])]
    assert ran.told("solver", "chosen", "asked") == [
        "solver (top 3) 1",
        "chosen top new",
        "asked (look 3)",
    ]


def test_a_returned_method_stays_in_the_run_for_other_tasks() -> None:
    calls: list[Any] = []

    def solver(goal: Any, view: Any) -> Sequence[nodes.Method]:
        calls.append(goal)
        return [method("(method (primitive (act ?x)))")]

    text = "(define-rap (top ?x) (method (context (p no)) (task-net)))"
    ran = play(text, "(top 1)", "(top 2)", solvers={"top": solver})
    assert len(calls) == 1
    assert sorted(ran.told("asked")) == ["asked (act 1)", "asked (act 2)"]
    assert ran.told("chosen") == ["chosen top #2", "chosen top #2"]


def test_a_returned_method_that_the_rap_has_is_that_one() -> None:
    def solver(goal: Any, view: Any) -> Sequence[nodes.Method]:
        return [method("(method one (context (p yes)) (task-net))")]

    text = "(define-rap (top) (method one (context (p yes)) (task-net)))"
    ran = play(text, "(top)", solvers={"top": solver})
    assert ran.told("solver", "failed") == [
        "solver (top) 1",
        "failed (top) no-method no-method",
    ]


def test_a_solver_is_not_asked_while_a_method_holds_or_repeat_while_does_not() -> None:
    def solver(goal: Any, view: Any) -> Sequence[nodes.Method]:
        raise AssertionError("nobody should ask")

    one = "(define-rap (top) (method (task-net)))"
    assert play(one, "(top)", solvers={"top": solver}).told("failed") == []
    two = "(define-rap (top) (repeat-while (p no)) (method (context nil) (task-net)))"
    ran = play(two, "(top)", solvers={"top": solver})
    assert ran.told("failed") == ["failed (top) no-method no-method"]
