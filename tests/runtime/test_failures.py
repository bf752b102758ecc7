"""How failures are handed up, and what leaves with what [L 3]."""

from __future__ import annotations

from rapc.worlds.scripted import ScriptedWorld

from .helpers import Play, play, row

NEST = """
(define-rap (top) (method (task-net (t1 (mid)))))
(define-rap (mid) (method (task-net (t1 (low)))))
(define-rap (low) (method (primitive (act a))))
"""


def test_the_worlds_symbol_is_handed_up() -> None:
    ran = play(NEST, "(top)", rows=[row("(act a)", "jammed")])
    failed = ran.told("failed")
    assert failed[0] == "failed (low) futile-loop jammed"
    assert failed[-1] == "failed (top) futile-loop jammed"
    assert {line.split()[-1] for line in failed} == {"jammed"}


def test_task_returns_the_last_failure_it_received() -> None:
    ran = play(
        """
        (define-rap (top)
          (method one (context (not (method-tried one))) (primitive (act a)))
          (method two (context (and (method-tried one) (not (method-tried two))))
                      (primitive (act b)))
          (method three (context (and (method-tried two) (not (method-tried three))))
                        (primitive (act c))))
        """,
        "(top)",
        rows=[
            row("(act a)", "jammed"),
            row("(act b)", "dropped"),
            row("(act c)", "okay", asserts=["(p c)"]),
        ],
    )
    assert ran.told("succeeded") == ["succeeded (top)"]
    ran = play(
        """
        (define-rap (top) (succeed nil)
          (method one (context (not (method-tried one))) (primitive (act a)))
          (method two (context (and (method-tried one) (not (method-tried two))))
                      (primitive (act b)))
          (method three (context (and (method-tried two) (not (method-tried three))))
                        (primitive (act c))))
        """,
        "(top)",
        rows=[row("(act a)", "jammed"), row("(act b)", "dropped")],
    )
    # a good end since does not wipe out the symbol, and never is handed up itself
    assert ran.told("failed") == ["failed (top) no-method dropped"]


def test_repaired_failure_does_not_reach_the_parent() -> None:
    ran = play(
        """
        (define-rap (top) (succeed nil) (method (task-net (t1 (low)))))
        (define-rap (low) (method (primitive (act a))))
        """,
        "(top)",
        rows=[row("(act a)", "jammed", times=1)],
    )
    assert ran.told("failed") == ["failed (top) futile-loop futile-loop"]


def test_last_result_is_the_result_of_the_step() -> None:
    ran = play(
        """
        (define-rap (top)
          (succeed (last-result interference))
          (method (task-net (t1 (low)))))
        (define-rap (low) (preconditions nil))
        """,
        "(top)",
    )
    assert ran.told("succeeded") == ["succeeded (top)"]


def test_failed_primitive_is_tried_again() -> None:
    ran = play(
        "(define-rap (low) (method (primitive (act a))))",
        "(low)",
        rows=[row("(act a)", "dropped", times=1)],
    )
    assert ran.told("asked", "succeeded") == ["asked (act a)"] * 2 + ["succeeded (low)"]


def test_siblings_and_all_they_spawned_leave_descendants_first() -> None:
    ran = play(
        """
        (define-rap (top)
          (method (context (not (last-result ?)))
            (task-net (t1 (busy)) (t2 (idle)) (t3 (break) (window now 5 9))
                      (t4 (idle) (window t3 0 9)))))
        (define-rap (busy) (method (task-net (b1 (deep)) (b2 (idle)))))
        (define-rap (deep) (method (primitive (slow a))))
        (define-rap (idle) (monitor-state (go)) (method (task-net)))
        (define-rap (break) (method (primitive (act a))))
        """,
        "(top)",
        rows=[row("(act a)", "jammed"), row("(slow a)", after=50)],
    )
    told = ran.told("failed", "removed", "ended")
    assert told[:9] == [
        "ended break #1 jammed",
        "ended break #1 jammed",
        "failed (break) futile-loop jammed",
        "removed deep parent-removed",
        "removed idle parent-removed",
        "removed busy sibling-failed",
        "removed idle sibling-failed",
        "removed idle sibling-failed",
        "ended top #1 jammed",
    ]


class _Deaf(ScriptedWorld):
    """A world that goes on with what is wanted no more."""

    def cancel(self, ticket: int) -> None:
        """Do nothing."""


def test_result_after_a_removal_still_reaches_memory() -> None:
    """Its result and data go through the handlers; the trace names no task."""
    ran = Play(
        """
        (define-rap (top) (method (task-net (t1 (get)) (t2 (break)))))
        (define-rap (get) (method (primitive (slow a))))
        (define-rap (break) (preconditions (p yes)))
        (define-rap (stay) (monitor-state (p got)) (method (primitive (act z))))
        """,
        "(top)",
        "(stay)",
        rows=[row("(slow a)", after=9, asserts=["(p got)"], times=2)],
        seed=1,
        world=_Deaf,
    ).run()
    assert ran.told("done", times=True) == [
        "9 done - (slow a) okay",
        "9 done stay (act z) okay",
    ] or "done - (slow a) okay" in ran.told("done")
    assert ran.memory("(p ?)") == ["(p got)"]


def test_failed_top_level_task_is_reported_and_removed() -> None:
    ran = play("(define-rap (low) (preconditions nil))", "(low)", "(low)")
    assert ran.told("failed") == ["failed (low) interference interference"] * 2
    results = ran.interpreter.results()
    assert [(r.outcome, r.result) for r in results] == [("failed", "interference")] * 2


def test_the_parent_comes_up_again_and_may_choose_another_method() -> None:
    ran = play(
        """
        (define-rap (top)
          (method a (task-net (t1 (low a))))
          (method b (context (method-tried a)) (task-net (t1 (low b)))))
        (define-rap (low ?x) (preconditions (p ?x)) (method (primitive (act ?x))))
        """,
        "(top)",
        facts=["(p b)"],
    )
    assert ran.told("chosen") == ["chosen top a", "chosen top b", "chosen low #1"]


def test_an_empty_task_net_ends_well_at_once() -> None:
    ran = play("(define-rap (top) (method (task-net)))", "(top)")
    assert ran.told("selected", "chosen", "ended", "succeeded") == [
        "selected top",
        "chosen top #1",
        "ended top #1 okay",
        "selected top",
        "succeeded (top)",
    ]
