"""What the comparison has found about queries, things, skills and what is refused.

One small program for each fault, as in `test_found`.
"""

from __future__ import annotations

from rapc.runtime.settings import Settings
from rapc.worlds.script import At, Row
from tests.reference.play import play

# --- queries, things, and what is under way -------------------------------------------


def test_a_fault_within_queries_names_them_and_the_clause_they_stand_in() -> None:
    """A `?` put in is called by the name of the argument that it stands for."""
    text = """
    (define-query (large ?x) (> ?x 2))
    (define-query (fits ?x) (and (q a) (large ?x)))
    (define-rap (top) (succeed (fits ?)))
    """
    (told,) = play(text, "(top)", only="query-faulted", facts=("(q a)",))
    assert told.startswith("0 faulted 1 `large` in `fits` in succeed at lib.rap:")
    assert told.endswith(": ?x is not bound")


def test_an_own_variable_of_a_query_is_bound_by_nobody_else() -> None:
    text = """
    (define-query (known ?x) (p ?x ?u))
    (define-rap (top) (method
      (context (and (known a) (known c) (q ?u))) (primitive (act ?u))))
    """
    told = play(
        text,
        "(top)",
        only="method-chosen",
        facts=("(p a 1)", "(p c 2)", "(q d)"),
    )
    assert told == ["0 chosen 1 top #1 {'?u': 'd'}"]


def test_a_claim_without_a_value_is_found_before_anything_is_noted() -> None:
    text = """
    (define-rap (top) (method (claims (arm ?u)) (notations (q a)) (task-net)))
    """
    told = play(
        text,
        "(top)",
        only="fact-asserted query-faulted method-ended",
        settings=Settings(futile_limit=1),
    )
    assert [line.split()[1] for line in told] == ["faulted", "ended"]


def test_an_atomic_primitive_that_outlasts_the_run_is_cancelled() -> None:
    text = "(define-rap (top) (method (primitive (act a))))"
    told = play(
        text,
        "(top)",
        only="primitive-cancelled task-removed",
        rows=(Row(("act", "?"), takes=9),),
        until=5,
    )
    assert told == ["5 cancelled 1 (act a)", "5 removed 1 run-over"]


def test_a_suspended_task_has_not_tried_its_method_and_may_choose_it_again() -> None:
    """Twice suspended and twice chosen anew, with a futile limit of one."""
    text = """
    (declare-primitive carry (?x) (okay) :atomic false :uses (wheels))
    (define-rap (top ?i) (method one (primitive (carry ?i))))
    """
    told = play(
        text,
        "(top a)",
        "(top c) :priority 1 :at 1",
        "(top d) :priority 1 :at 5",
        only="method-suspended method-ended task-woken",
        rows=(Row(("carry", "?"), after=3),),
        settings=Settings(futile_limit=1),
    )
    assert told == [
        "1 suspended 1 one wheels 2",
        "4 ended 2 one okay",
        "4 woken 1 wheels 2",
        "5 suspended 1 one wheels 3",
        "8 ended 3 one okay",
        "8 woken 1 wheels 3",
        "11 ended 1 one okay",
    ]


# --- skills -------------------------------------------------------------------------


def test_a_lower_claim_to_what_a_higher_one_claims_leaves_other_skills_on() -> None:
    text = """
    (declare-skill :roll () :uses (wheels))
    (declare-skill :hum ())
    (define-rap (drive ?i)
      (method (claims room) (skills (:hum) (:roll)) (task-net (t1 (idle)))))
    (define-rap (idle) (method (primitive (slow a))))
    """
    tasks = ("(drive a)", "(drive c) :at 1 :priority 1")
    only = "skill-disabled skill-enabled"
    told = play(text, *tasks, only=only, rows=[Row(("slow", "?"), after=9)])
    assert told == [
        "0 enabled 1 (:hum) True",
        "0 enabled 1 (:roll) True",
        "1 disabled 1 (:roll)",
        "1 enabled 3 (:hum) True",
        "1 enabled 3 (:roll) True",
        "9 disabled 1 (:hum)",
        "10 disabled 3 (:hum)",
        "10 disabled 3 (:roll)",
    ]


def test_rules_at_the_end_of_a_task_ask_how_its_last_method_has_ended() -> None:
    """One that has tried none has no result, though the task succeeds."""
    text = """
    (define-rap (done) (succeed (q a)))
    (define-memory-rule (done) :finish
      (match-result (succeed (rule ((last-result ?r) (mem-add (q ?r)))))))
    """
    only = "task-succeeded rule-run fact-asserted"
    told = play(text, "(done)", only=only, facts=("(q a)",))
    assert told == ["0 asserted (q a) user", "0 succeeded 1 (done) {}"]


def test_skills_that_stay_on_are_as_they_were_though_a_counter_is_not() -> None:
    text = """
    (declare-skill :roll (?x) :uses (wheels))
    (declare-skill :scan (?x) :uses ((arm ?x)))
    (define-rap (look ?i)
      (resources (counter ?c 1))
      (method (skills (:scan (value ?c)) (:roll a))
        (task-net (t1 (wait) (counter-add ?c 1) (for t2)) (t2 (wait)))))
    (define-rap (wait) (method (primitive (slow a))))
    (define-rap (drive ?i)
      (method (primitive (enable (:roll ?i)) (wait-for (:stop) :succeed))))
    """
    told = play(
        text,
        "(look a)",
        "(drive c) :at 5 :priority 1",
        only="skill-disabled skill-enabled",
        rows=[Row(("slow", "?"), after=4)],
        at=(At(7, signals=((":stop",),)),),
    )
    assert told == [
        "0 enabled 1 (:scan 1) True",
        "0 enabled 1 (:roll a) True",
        "5 disabled 1 (:roll a)",
        "5 enabled 4 (:roll c)",
        "7 disabled 4 (:roll c)",
        "7 enabled 1 (:roll a) True",
        "8 disabled 1 (:scan 1)",
        "8 disabled 1 (:roll a)",
    ]


def test_a_refusal_that_names_an_ancestor_is_not_asked_again_for_ever() -> None:
    text = """
    (declare-skill :hum ())
    (define-rap (top) (method (skills (:hum)) (task-net (t1 (sub)))))
    (define-rap (sub) (method (primitive (act a))))
    """
    told = play(
        text,
        "(top)",
        only="request-refused task-failed",
        rows=[Row(("act", "?"), refused=True)],
        settings=Settings(futile_limit=1),
    )
    assert told[0].startswith("0 refused 2 (act a) (act a)")
    assert [line.split()[2] for line in told if "failed" in line] == ["2", "1"]


def test_an_item_that_cannot_be_computed_is_in_nobodys_reach() -> None:
    text = """
    (define-query (near ?u) (know-sensor-name ?u))
    (define-rap (top) (succeed (near (/ 1 0))))
    """
    (told,) = play(text, "(top)", only="query-faulted task-succeeded")
    assert told.startswith("0 faulted 1 `near` in succeed at lib.rap:")
