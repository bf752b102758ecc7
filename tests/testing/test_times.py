"""When an `at` takes effect, when it is judged, and when a test is over."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.testing.run import Status, run_case

from .small_suite import GRAB, LIBRARY, cases, happened, run

LONG = "(script ((grab ?x) okay :takes 10 :asserts ((have ?x)))) (task (fetch box))"
"""A primitive from time 0 to 10, and nothing else."""

SLOW = "(script ((grab ?x) okay :after 10 :asserts ((have ?x)))) (task (fetch box))"
"""The same, not atomic."""


def passes(folder: Path, clauses: str) -> bool:
    outcome = run(folder, clauses)
    assert outcome.status is Status.PASSED or outcome.failures
    return outcome.status is Status.PASSED


def test_facts_are_in_memory_at_time_0(tmp_path: Path) -> None:
    known = "(facts (have box) (where cup shelf))"
    expected = "(expect (memory (have box)) (memory (where cup shelf)))"
    assert passes(tmp_path, f"{known} (at 0 {expected})")


def test_at_asserts_in_the_name_of_the_user_and_first_thing(tmp_path: Path) -> None:
    ats = "(at 3 (asserts (have cup) (where cup here)))"
    trace = "(trace (fact-asserted :fact (have cup) :by user) (task-woken))"
    assert passes(tmp_path, f"{ats} (task (watch cup)) (expect {trace})")


def test_at_erases_by_prefix(tmp_path: Path) -> None:
    known = "(facts (where cup shelf) (where box shelf))"
    expected = "(memory (not (where ? shelf)))"
    assert passes(tmp_path, f"{known} (at 3 (erases (where))) (expect {expected})")


def test_at_acts_in_the_order_of_the_text(tmp_path: Path) -> None:
    last = "(asserts (where cup shelf)) (erases (where cup))"
    assert passes(tmp_path, f"(at 3 {last}) (expect (memory (where cup unknown)))")
    ats = "(at 3 (asserts (where cup a))) (at 3 (asserts (where cup b)))"
    assert passes(tmp_path, f"{ats} (expect (memory (where cup b)))")


def test_at_sends_signals(tmp_path: Path) -> None:
    given = f"(script {GRAB}) (task (await ?)) (at 3 (signals (:bump left)))"
    given = given.replace("(await ?)", "(await left)")
    expected = "(succeeds (await left)) (trace (signal :what (:bump left)))"
    assert passes(tmp_path, f"{given} (expect {expected})")


def test_at_gives_tasks(tmp_path: Path) -> None:
    given = f"(script {GRAB}) (at 3 (task (fetch box) :priority 4))"
    expected = "(trace (task-created :goal (fetch box) :priority 4))"
    expected += " (ends-by 5 (fetch box))"
    assert passes(tmp_path, f"{given} (expect {expected})")


def test_at_cancels_all_matching_top_level_tasks(tmp_path: Path) -> None:
    given = "(task (watch cup)) (task (watch box)) (task (await left))"
    given += " (at 3 (cancel (watch ?)) (cancel (fetch cup)))"
    expected = """
      (expect (trace (task-removed :task 1 :cause cancelled)
                     (task-removed :task 2 :cause cancelled))
              (active (fetch cup)))
    """
    assert passes(tmp_path, f"{given} (until 5) {expected}")


def test_a_cancelled_task_neither_succeeds_nor_fails(tmp_path: Path) -> None:
    given = f"{SLOW} (at 3 (cancel (fetch box)))"
    expected = "(succeeds (fetch box)) (fails (fetch box)) (active (fetch box))"
    told = happened(run(tmp_path, f"{given} (expect {expected})"))
    assert told == ["(fetch box) [1] was removed at time 3 (cancelled)"] * 3


# --- when ----------------------------------------------------------------------------


def test_at_inside_an_atomic_primitive_comes_before_its_result(tmp_path: Path) -> None:
    given = f"{LONG} (at 4 (asserts (where cup shelf)))"
    trace = """
      (trace (primitive-requested)
             (fact-asserted :fact (where cup shelf) :time 10)
             (fact-asserted :fact (have box) :time 10)
             (primitive-ended))
    """
    assert passes(tmp_path, f"{given} (expect {trace})")


def test_at_inside_a_slow_primitive_comes_at_its_time(tmp_path: Path) -> None:
    given = f"{SLOW} (at 4 (asserts (where cup shelf)))"
    expected = "(trace (fact-asserted :fact (where cup shelf) :time 4))"
    assert passes(tmp_path, f"{given} (expect {expected})")


def test_at_precedes_results_of_its_time(tmp_path: Path) -> None:
    trace = """
      (trace (fact-asserted :fact (where cup shelf) :time 10)
             (primitive-ended :time 10))
    """
    for given in (LONG, SLOW):
        clauses = f"{given} (at 10 (asserts (where cup shelf))) (expect {trace})"
        assert passes(tmp_path, clauses)


def test_timed_expectation_is_judged_when_the_clock_moves_on(
    tmp_path: Path,
) -> None:
    """All that falls on the time has come, requests under way among it."""
    expected = "(expect (primitives (grab box)) (active (fetch box)))"
    assert passes(tmp_path, f"{LONG} (at 0 {expected})")
    assert passes(tmp_path, f"{SLOW} (at 0 {expected})")
    assert passes(tmp_path, f"{SLOW} (at 9 (expect (memory (not (have box)))))")
    done = "(expect (memory (have box)) (succeeds (fetch box)))"
    for given in (LONG, SLOW):
        assert passes(tmp_path, f"{given} (at 10 {done})")


def test_expectation_during_an_atomic_primitive_is_judged_after_it(
    tmp_path: Path,
) -> None:
    done = "(expect (memory (have box)) (succeeds (fetch box)))"
    assert passes(tmp_path, f"{LONG} (at 4 {done})")


def test_a_pending_at_keeps_the_run_going(tmp_path: Path) -> None:
    expected = "(trace (fact-asserted :fact (have cup) :time 50))"
    assert passes(tmp_path, f"(at 50 (asserts (have cup))) (expect {expected})")


def test_a_failure_at_a_time_shows_the_trace_up_to_it(tmp_path: Path) -> None:
    given = f"(script {GRAB}) (task (fetch box)) (at 0 (expect (memory (have box))))"
    outcome = run(tmp_path, given)
    assert happened(outcome) == ["no fact `have` is in memory"]
    assert outcome.trace[-1].endswith("method by-hand of fetch [1]")


# --- the end -------------------------------------------------------------------------


def test_messages_due_at_until_are_processed(tmp_path: Path) -> None:
    assert passes(tmp_path, f"{SLOW} (until 10) (expect (succeeds (fetch box)))")
    assert passes(tmp_path, f"{LONG} (until 10) (expect (succeeds (fetch box)))")
    call_at_end = "(at 7 (asserts (have cup))) (expect (memory (have cup)))"
    assert passes(tmp_path, f"(until 7) {call_at_end}")


def test_request_ending_after_until_stays_unended(tmp_path: Path) -> None:
    expected = """
      (expect (active (fetch box)) (primitives (grab box)) (memory (not (have box))))
    """
    for given in (LONG, SLOW):
        assert passes(tmp_path, f"{given} (until 9) {expected}")


def test_the_clock_stops_at_until_in_the_course_of_a_primitive(tmp_path: Path) -> None:
    aged = "(expect (memory (believe (where cup shelf) 10)))"
    assert passes(tmp_path, f"(facts (where cup shelf)) {LONG} (until 9) {aged}")


@pytest.mark.parametrize("limit", ["(until (cycles 3))", "(cycles 3)"])
def test_a_number_of_cycles(tmp_path: Path, limit: str) -> None:
    given = "(script ((say ?) okay)) (task (count-to 100))"
    expected = "(expect (trace (task-selected :cycle 3)) (active (count-to 100)))"
    assert passes(tmp_path, f"{given} {limit} {expected}")
    more = "(expect (trace (task-selected :cycle 4)))"
    assert not passes(tmp_path, f"{given} {limit} {more}")


def test_unreached_expectation_fails(tmp_path: Path) -> None:
    at = "(at 30 (expect (memory true)))"
    told = ["never reached: the run ended at time 20 (until)"]
    assert happened(run(tmp_path, f"(until 20) {at}")) == told
    told = ["never reached: the run ended at time 9 (until)"]
    within = "(at 5 (expect (memory true)))"
    assert happened(run(tmp_path, f"{LONG} (until 9) {within}")) == told
    assert passes(tmp_path, "(until 20) (at 30 (asserts (have cup)))")


def test_task_removed_after_the_run_is_not_judged(tmp_path: Path) -> None:
    gone = "(trace (task-removed :cause run-over))"
    outcome = run(tmp_path, f"(task (watch cup)) (until 5) (expect {gone})")
    assert outcome.status is Status.FAILED


def test_a_background_task_does_not_keep_the_test_going(tmp_path: Path) -> None:
    given = f"(script {GRAB}) (task (fetch box)) (task (watch cup) :background true)"
    expected = "(expect (active (watch cup)) (succeeds (fetch box)))"
    assert passes(tmp_path, f"{given} {expected}")


def test_a_deadline_is_absolute(tmp_path: Path) -> None:
    given = "(at 5 (task (watch cup) :deadline 8)) (at 9 (asserts (have hat)))"
    expected = "(expect (trace (deadline-missed :deadline 8)))"
    assert passes(tmp_path, f"{given} {expected}")


FOREVER = """
  (define-rap (forever)
    (repeat-while true) (succeed nil)
    (resources (counter ?n))
    (method (task-net (t1 (utter ?n) (counter-add ?n 1)))))
"""


def test_a_test_without_end_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rapc.testing.run.MOST_CYCLES", 500)
    clauses = "(script ((say ?) :takes 1)) (task (forever))"
    found = cases(tmp_path, f"{LIBRARY} {FOREVER} (define-test it {clauses})")
    assert happened(run_case(found["it"])) == [
        "the test was not over after 500 cycles; give a time with `(until time)`"
    ]


def test_a_test_without_end_is_stopped_in_the_time_of_its_world_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rapc.testing.run.LATEST", 60)
    clauses = "(script ((say ?) :takes 50)) (task (forever))"
    tests = f"(define-test it {clauses}) (define-test all {clauses} (cycles 9))"
    found = cases(tmp_path, f"{LIBRARY} {FOREVER} {tests}")
    assert happened(run_case(found["it"])) == [
        "the test was not over at time 60; give a time with `(until time)`"
    ]
    assert happened(run_case(found["all"])) == []


def test_test_with_an_unreached_time_is_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its task tries again and again, and no try takes any time."""
    monkeypatch.setattr("rapc.testing.run.MOST_CYCLES", 500)
    clauses = "(script ((say ?))) (task (forever)) (until 10)"
    found = cases(tmp_path, f"{LIBRARY} {FOREVER} (define-test it {clauses})")
    assert happened(run_case(found["it"])) == [
        "the test was not over after 500 cycles; it was only at time 0"
    ]
