"""Tasks that ask for what is being done already [L 3.42]."""

from __future__ import annotations

from .helpers import play


def test_step_equal_to_an_ancestor_fails_before_the_start() -> None:
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


def test_for_formula_binding_a_recursion_fails_the_parent() -> None:
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
