"""Choosing methods, and futile loops [L 3]."""

from __future__ import annotations

from collections import Counter

import pytest

from rapc.runtime.settings import Settings

from .helpers import Play, at, play, row


def chosen(ran: Play) -> str:
    """The names of the methods chosen, in order, in one word."""
    return "".join(line.split()[-1] for line in ran.told("chosen"))


def test_only_applicable_methods_are_chosen() -> None:
    text = """
        (define-rap (top)
          (method a (context (p left)) (task-net))
          (method b (context (p right)) (task-net)))
        """
    assert chosen(play(text, "(top)", facts=["(p right)"])) == "b"
    assert play(text, "(top)").told("failed") == ["failed (top) no-method no-method"]


def test_a_method_without_context_always_holds() -> None:
    assert chosen(play("(define-rap (top) (method a (task-net)))", "(top)")) == "a"


ORDERED = """
    (define-rap (top) (repeat-while (color ?x lit)) (succeed (p done))
      (method a (context (q ?x ?)) (primitive (act a)))
      (method b (context (and (q ?y ?) (and otherwise (p ?y)))) (primitive (act b)))
      (method c (context otherwise) (primitive (act c)))
      (method d (context (p up)) (primitive (act d))))
    """


@pytest.mark.parametrize(
    ("facts", "method"),
    [
        (("(q one 1)", "(p one)"), "a"),
        (("(q two 1)", "(p two)"), "b"),
        (("(q two 1)", "(p one)"), "c"),
        (("(q one 1)", "(p up)"), "ad"),
        (("(p up)",), "cd"),
        ((), "c"),
    ],
)
def test_otherwise_holds_if_no_method_before_does(
    facts: tuple[str, ...], method: str
) -> None:
    """Apart from what the method binds: `?y` need not have the value of `?x`."""
    for seed in range(4):
        told = ["(color one lit)", *facts]
        assert chosen(play(ORDERED, "(top)", facts=told, seed=seed))[0] in method


def test_otherwise_ignores_failed_methods() -> None:
    text = """
        (define-rap (top)
          (method a (context (p up)) (primitive (act a)))
          (method b (context otherwise) (primitive (act b))))
        """
    failing = [row("(act a)", "jammed")]
    ran = play(text, "(top)", facts=["(p up)"], rows=failing)
    assert chosen(ran) == "aa"
    assert ran.told("failed") == ["failed (top) futile-loop jammed"]
    assert chosen(play(text, "(top)")) == "b"


def test_least_failed_method_is_preferred() -> None:
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


def test_least_chosen_method_is_preferred() -> None:
    """A method that ended well has not failed, whatever `succeed` says then."""
    text = """
        (define-rap (top) (succeed (p done))
          (method a (primitive (act a)))
          (method b (primitive (act b))))
        """
    for seed in range(8):
        order = chosen(play(text, "(top)", seed=seed))
        assert sorted(order[:2]) == sorted(order[2:]) == ["a", "b"]


def test_failures_count_for_a_method_with_any_bindings() -> None:
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


def test_changed_resource_is_a_different_choice() -> None:
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


@pytest.mark.parametrize(("kept", "chosen_times"), [(1, 40), (2, 40), (3, 6), (9, 6)])
def test_only_the_last_choices_count_for_a_futile_loop(
    kept: int, chosen_times: int
) -> None:
    """Three choices take turns: a task that remembers fewer never repeats itself."""
    text = """
        (define-rap (top) (succeed (p done))
          (method (context (color it ?x)) (primitive (act ?x))))
        """
    turns = ("red", "green"), ("green", "blue"), ("blue", "red")
    rows = [
        row(f"(act {one})", asserts=[f"(color it {other})"]) for one, other in turns
    ]
    play = Play(
        text,
        "(top)",
        rows=rows,
        facts=["(color it red)"],
        settings=Settings(max_choices=kept),
    )
    play.interpreter.step()
    other = play.interpreter.fork()
    play.run(cycles=39)
    assert len(play.told("chosen")) == chosen_times
    assert other.run(cycles=39) == play.interpreter.reason
    assert other.succeeded == 0
    assert other.recorder.cycle == play.interpreter.recorder.cycle


def test_blocking_restarts_the_count_of_choices() -> None:
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


def test_history_queries_refer_to_their_task() -> None:
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
