"""`for` formulas, preconditions, constraints, `repeat-while` [L 3, 4, 5]."""

from __future__ import annotations

import pytest

from .helpers import at, play, row


def test_for_formulas_come_first_and_in_the_order_of_the_text() -> None:
    """The second formula sees what the first has bound, not the other way round."""
    text = """
        (define-rap (top)
          (method (task-net (t1 (rest) {first} {second}) (t2 (use ?x)))))
        (define-rap (rest) (method (task-net)))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """
    one, two = "((p ?x) for t2)", "((q ?x ?) for t2)"
    facts = ["(p a)", "(p b)", "(q b z)"]
    forth = play(text.format(first=two, second=one), "(top)", facts=facts)
    assert forth.told("asked") == ["asked (act b)"]
    back = play(text.format(first=one, second=two), "(top)", facts=facts)
    assert back.told("failed")[0] == "failed (use a) interference interference"


def test_the_bindings_of_a_for_formula_stay() -> None:
    """Seen again when the task comes up after its method, `?x` is what it was."""
    ran = play(
        """
        (define-rap (top)
          (method (task-net (t1 (rest) ((p ?x) for t2) (for t3)) (t2 (use a) (for t3))
                            (t3 (use ?x)))))
        (define-rap (rest) (method (task-net)))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """,
        "(top)",
        facts=["(p b)"],
        rows=[row("(act a)", asserts=["(p c)"])],
    )
    assert ran.told("asked") == ["asked (act a)", "asked (act b)"]


def test_conditions_are_checked_at_every_selection() -> None:
    """Also when the task comes up after its own method (T 6.2.1)."""
    ran = play(
        """
        (define-rap (top)
          (method (task-net (t1 (rest) ((ready arm) for t2)) (t2 (use a)))))
        (define-rap (rest) (method (task-net)))
        (define-rap (use ?x) (succeed (color ?x done)) (method (primitive (act ?x))))
        """,
        "(top)",
        facts=["(ready arm)"],
        rows=[row("(act a)", erases=["(ready arm)"])],
    )
    assert ran.told("asked", "failed")[:2] == [
        "asked (act a)",
        "failed (use a) interference interference",
    ]


@pytest.mark.parametrize("clause", ["preconditions", "constraints"])
def test_false_condition_is_interference(clause: str) -> None:
    text = f"(define-rap (use ?x) ({clause} (p ?x)) (method (primitive (act ?x))))"
    assert play(text, "(use a)", facts=["(p a)"]).told("failed") == []
    ran = play(text, "(use b)", facts=["(p a)"])
    assert ran.told("asked", "failed") == ["failed (use b) interference interference"]


def test_constraints_are_inherited_and_preconditions_are_not() -> None:
    text = """
        (define-rap (top ?x) ({clause} (p ?x))
          (method (task-net (t1 (use b) (for t2)) (t2 (use c)))))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """
    rows = [row("(act b)", erases=["(p a)"])]
    kept = play(text.format(clause="preconditions"), "(top a)", facts=["(p a)"])
    assert kept.told("asked") == ["asked (act b)", "asked (act c)"]
    one = text.format(clause="preconditions")
    ran = play(one, "(top a)", facts=["(p a)"], rows=rows)
    assert ran.told("asked") == ["asked (act b)", "asked (act c)"]
    two = text.format(clause="constraints")
    ran = play(two, "(top a)", facts=["(p a)"], rows=rows)
    # (use b) has succeeded before its constraints are looked at again
    assert ran.told("asked", "succeeded", "failed") == [
        "asked (act b)",
        "succeeded (use b)",
        "failed (use c) interference interference",
        "failed (top a) interference interference",
    ]


def test_an_inherited_constraint_keeps_its_own_variables_and_task() -> None:
    """`?x` in it is the ancestor's; what it asks of history is the ancestor's too."""
    ran = play(
        """
        (define-rap (top ?x) (constraints (and (p ?x) (not (method-tried inner))))
          (method outer (task-net (t1 (use b)))))
        (define-rap (use ?x) (method inner (primitive (act ?x))))
        """,
        "(top a)",
        facts=["(p a)"],
    )
    assert ran.told("failed") == []


def test_variables_of_the_method_mean_nothing_in_other_clauses() -> None:
    """`?y` of the context is free in `succeed`: any fact will do."""
    ran = play(
        """
        (define-rap (top)
          (succeed (and (last-result okay) (p ?y)))
          (method (context (q a ?y)) (primitive (act ?y))))
        """,
        "(top)",
        facts=["(q a b)", "(p other)"],
    )
    assert ran.told("asked", "succeeded") == ["asked (act b)", "succeeded (top)"]


def test_repeat_while_without_a_solution_is_no_method() -> None:
    ran = play(
        """
        (define-rap (top) (repeat-while (p ?x)) (succeed nil)
          (method (primitive (act ?x))))
        """,
        "(top)",
    )
    assert ran.told("asked", "failed") == ["failed (top) no-method no-method"]


def test_repeat_while_goes_on_as_long_as_it_holds() -> None:
    ran = play(
        """
        (define-rap (top) (repeat-while (p ?x)) (succeed (not (p ?)))
          (method (primitive (act ?x))))
        """,
        "(top)",
        facts=["(p a)", "(p b)", "(p c)"],
        rows=[row("(act ?x)", erases=["(p ?x)"])],
    )
    assert ran.told("asked") == ["asked (act a)", "asked (act b)", "asked (act c)"]
    assert ran.told("over") == ["over done"]


def test_repeat_while_and_context_have_a_joint_solution() -> None:
    """The context of the method backtracks into `repeat-while`."""
    ran = play(
        """
        (define-rap (top) (repeat-while (p ?x)) (succeed (last-result okay))
          (method one (context (q ?x ?y)) (primitive (act ?y)))
          (method two (context (color ?x red)) (primitive (look ?x))))
        """,
        "(top)",
        facts=["(p a)", "(p b)", "(q b wrench)"],
    )
    assert ran.told("chosen", "asked") == ["chosen top one", "asked (act wrench)"]


def test_step_ended_by_until_keeps_its_order_without_conditions() -> None:
    """T figure 4.3: what t1 carries for t3 goes with it."""
    ran = play(
        """
        (define-rap (top)
          (method (task-net
            (t1 (wait-long) (until-end t2) ((p never) for t3))
            (t2 (use a))
            (t3 (use b)))))
        (define-rap (wait-long) (monitor-state (stop)) (method (task-net)))
        (define-rap (use ?x) (method (primitive (act ?x))))
        """,
        "(top)",
        times=[at(5, "(go)")],
    )
    assert ran.told("asked", "removed", "failed", "over") == [
        "asked (act a)",
        "removed wait-long until",
        "asked (act b)",
        "over done",
    ]
