"""What is wrong with a test itself: found before it is run, and with its place."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest

from rapc.base.source import place
from rapc.testing.run import Status, run_case

from .small_suite import GRAB, LIBRARY, cases, happened, run

PROBLEMS = [
    ("(facts (hold box))", "unknown predicate `hold`"),
    ("(facts (have box cup))", "`have` takes 1 argument, not 2"),
    ("(script ((grip box)))", "unknown primitive `grip`"),
    ("(script ((grab box cup)))", "`grab` takes 1 argument, not 2"),
    ("(script ((grab box) broken))", "`broken` is not a result of `grab`"),
    ("(script ((grab box) :asserts ((have ?x))))", "`?x` is not bound here"),
    ("(script ((grab box) :asserts ((hold box))))", "unknown predicate `hold`"),
    ("(script ((grab box) :erases ((hold))))", "unknown predicate `hold`"),
    ("(script ((grab box) :moves ((?x box))))", "`?x` is not bound here"),
    ("(script ((grab box) :loses (?x)))", "`?x` is not bound here"),
    ("(script ((grab box) :signals ((:crash))))", "unknown event `:crash`"),
    ("(script ((grab box) :data ((noise))))", "unknown sensor datum `noise`"),
    (
        "(script ((grab box) :data ((sighting box))))",
        "datum `sighting` has no handler",
    ),
    (
        "(script ((look box) :after 3))",
        "`look` is declared atomic and cannot end `:after` its request",
    ),
    (
        "(script ((look box) :every 3))",
        "only a skill emits signals with waits between them, or repeatedly",
    ),
    ("(script ((enable (:roll 1))))", "unknown skill `:roll`"),
    ("(at 1 (asserts (hold box)))", "unknown predicate `hold`"),
    ("(at 1 (erases (hold)))", "unknown predicate `hold`"),
    (
        "(at 1 (signals (:dump)))",
        "unknown event `:dump`; did you mean `:bump`?",
    ),
    ("(at 1 (signals (:bump)))", "`:bump` takes 1 argument, not 0"),
    ("(at 1 (task (fetsh a)))", "unknown RAP `fetsh`; did you mean `fetch`?"),
    ("(at 1 (cancel (fetch)))", "`fetch` has 1 input, not 0"),
    ("(task (fetch a b))", "`fetch` has 1 input, not 2"),
    (
        "(expect (never (grabs x)))",
        "unknown primitive `grabs`; did you mean `grab`?",
    ),
    ("(expect (primitives (grab)))", "`grab` takes 1 argument, not 0"),
    ("(expect (fails (fetch ? ?)))", "`fetch` has 1 input, not 2"),
    ("(expect (succeeds (find x) a b))", "`find` has 1 output, not 2"),
    ("(expect (memory (hold box)))", "unknown predicate `hold`"),
    ("(expect (memory (not (where box))))", None),
    (
        "(expect (method fetch by-foot 0 times))",
        "unknown method `by-foot` of `fetch`",
    ),
    (
        "(expect (method find #2))",
        "unknown method `#2` of `find`",
    ),
    (
        "(expect (trace (task-fails)))",
        "unknown event `task-fails`; did you mean `task-failed`?",
    ),
    (
        "(expect (trace (task-failed :gaol ?)))",
        "unknown key `gaol` of `task-failed`; did you mean `goal`?",
    ),
    ("(world trukc)", "unknown world `trukc`; did you mean `truck`?"),
]


@pytest.mark.parametrize(("clauses", "message"), PROBLEMS)
def test_a_test_with_something_wrong_is_in_error(
    tmp_path: Path, clauses: str, message: str | None
) -> None:
    outcome = run(tmp_path, clauses)
    if message is None:
        assert outcome.status is not Status.ERROR
        return
    assert happened(outcome) == [message]
    assert outcome.status is Status.ERROR


def test_all_errors_are_reported_at_their_position(tmp_path: Path) -> None:
    outcome = run(tmp_path, "(facts (hold box))\n (expect (never (grip box)))")
    rows = len(LIBRARY.splitlines())
    files = outcome.case.library.library.files
    places = [place(failure.span, files) for failure in outcome.failures]
    ends = [each.removeprefix(str(tmp_path / "it.test.rap")) for each in places]
    assert ends == [f":{rows + 2}:25", f":{rows + 3}:18"]


def test_unchecked_fact_is_refused_before_the_run(
    tmp_path: Path,
) -> None:
    """A program may make a case of a test that was not checked."""
    found = cases(tmp_path, f"{LIBRARY}\n(define-test it (facts (hold box)))")["it"]
    told: list[object] = []
    unchecked = msgspec.structs.replace(found, faults=())
    outcome = run_case(unchecked, listener=told.append)
    assert outcome.status is Status.ERROR
    assert happened(outcome) == ["unknown predicate `hold`"]
    assert told == []


def test_a_request_without_an_answer_fails_the_test(tmp_path: Path) -> None:
    outcome = run(tmp_path, "(script ((grab cup))) (task (fetch box)) (expect)")
    assert happened(outcome) == ["no row of the script answers (grab box)"]
    assert outcome.status is Status.FAILED
    assert "considering (fetch box) [1]" in "".join(outcome.trace)


def test_rows_are_used_up(tmp_path: Path) -> None:
    script = "(script ((grab ?x) dropped :times 1))"
    outcome = run(tmp_path, f"{script} (task (fetch box))")
    assert happened(outcome) == ["no row of the script answers (grab box)"]


def test_library_with_functions_requires_a_world(tmp_path: Path) -> None:
    library = "(declare-memory-function louder (?a ?b))"
    found = cases(tmp_path, f"{library} (define-test it (expect (memory true)))")
    outcome = run_case(found["it"])
    assert outcome.status is Status.ERROR
    assert happened(outcome)[0].endswith("unknown function `louder`")


def test_data_go_through_the_handlers_of_a_world(tmp_path: Path) -> None:
    text = """
      (declare-primitive check-gauges () (okay))
      (declare-sensor-datum fuel-level (?fuel))
      (declare-memory-proposition truck-fuel (?fuel))
      (define-rap (check) (method (primitive (check-gauges))))
      (define-test it
        (world truck)
        (script ((check-gauges) :data ((fuel-level 7))))
        (task (check))
        (expect (memory (truck-fuel 7))
                (trace (primitive-ended :data ((fuel-level 7))))))
    """
    outcome = run_case(cases(tmp_path, text)["it"])
    assert happened(outcome) == []


def test_each_test_has_a_run_of_its_own(tmp_path: Path) -> None:
    clauses = f"(script {GRAB}) (task (fetch box)) (expect (primitives (grab box)))"
    text = f"{LIBRARY} (define-test one {clauses}) (define-test two {clauses})"
    outcomes = [run_case(case) for case in cases(tmp_path, text).values()]
    assert [outcome.status for outcome in outcomes] == [Status.PASSED] * 2
