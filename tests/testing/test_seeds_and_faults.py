"""Tests under many seeds, and with requests that fail as told."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from rapc.base.values import Text
from rapc.errors import TextError
from rapc.testing.faults import read_fault
from rapc.testing.run import Status
from rapc.testing.session import TestSession, exit_status, summary
from rapc.world import World
from rapc.worlds.faults import FaultyWorld, InjectedFault

from .small_suite import GRAB, LIBRARY, cases, happened, run

CHANCE = """
(define-rap (guess)
  (method heads (primitive (say heads)))
  (method tails (primitive (say tails))))
(define-test it (script ((say ?))) (task (guess)) (expect (primitives (say heads))))
"""
"""A test that holds under some seeds only."""


def test_each_seed_gives_a_run_of_its_own(tmp_path: Path) -> None:
    case = cases(tmp_path, LIBRARY + CHANCE)["it"]
    found = {
        TestSession(range(seed, seed + 1)).run_one(case).status for seed in range(10)
    }
    assert found == {Status.PASSED, Status.FAILED}
    outcome = TestSession(range(10)).run_one(case)
    assert outcome.status is Status.FAILED
    again = TestSession(range(outcome.seed, 10)).run_one(case)
    assert (again.seed, again.trace) == (outcome.seed, outcome.trace)
    passing = TestSession(range(outcome.seed))
    assert not outcome.seed or passing.run_one(case).status is Status.PASSED


def test_many_outcomes_in_a_line(tmp_path: Path) -> None:
    good = run(tmp_path, "")
    bad = run(tmp_path, "(expect (memory false))")
    wrong = run(tmp_path, "(world nowhere)")
    assert summary([good], 1) == "1 test: 1 passed"
    assert summary([good, bad, good], 20) == (
        "3 tests, each under 20 seeds: 2 passed, 1 failed"
    )
    assert summary([wrong, bad], 1) == "2 tests: 1 failed, 1 in error"
    assert exit_status([good]) == 0
    assert exit_status([good, bad]) == 1
    assert exit_status([good, bad, wrong]) == 2


# --- faults --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("(grab ?x) dropped", InjectedFault(("grab", "?x"), "dropped")),
        ("(GRAB Box) Dropped p=1", InjectedFault(("grab", "box"), "dropped")),
        (
            '(say "a (b" 2.5) no p=0.25 from=10 until=20.5',
            InjectedFault(("say", Text("a (b"), 2.5), "no", 0.25, 10, 20.5),
        ),
    ],
)
def test_faults_are_read(text: str, fault: InjectedFault) -> None:
    assert read_fault(text) == fault


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("(grab ?x)", "missing result after (grab ?x)"),
        ("(grab ?x) p=1", "missing result after (grab ?x)"),
        ("(:rang) late=5", "missing kind of signal fault after (:rang)"),
        (
            "(enable (:hum)) refused",
            "a skill cannot fail; for a fault of its signals write `(:signal) lost`",
        ),
        ("(grab ?x) dropped p=2", "`p` is a chance, from 0 to 1"),
        ("(grab ?x) dropped p=often", "`p` takes a number, not `often`"),
        ("(grab ?x) dropped from=-1", "`from` takes a number, not `-1`"),
        ("(grab ?x) dropped until=nan", "`until` takes a number, not `nan`"),
        (
            "(grab ?x) dropped form=1",
            "unknown option `form=1` of a fault; did you mean `from=`?",
        ),
        (
            "(grab ?x) dropped always",
            "unknown option `always` of a fault; expected p, from, until or by",
        ),
        (
            "(grab (+ 1 2)) dropped",
            "a request must not contain computed terms: (grab (+ 1 2))",
        ),
    ],
)
def test_invalid_faults(text: str, message: str) -> None:
    with pytest.raises(TextError) as raised:
        read_fault(text)
    assert str(raised.value) == message


@pytest.mark.parametrize("text", ["", "grab", "(grab", "() x", "grab dropped"])
def test_faults_without_a_request(text: str) -> None:
    with pytest.raises(TextError):
        read_fault(text)


def _run(
    folder: Path, clauses: str, faults: Sequence[InjectedFault], seed: int = 0
) -> list[str]:
    def wrap(world: World, seed: int) -> World:
        return FaultyWorld(world, faults, seed)

    return happened(run(folder, clauses, seed, wrap))


def test_a_fault_takes_the_time_of_the_row_and_its_place(tmp_path: Path) -> None:
    given = f"(script {GRAB}) (task (fetch box))"
    expected = """
      (expect (fails (fetch box) dropped) (memory (not (have box)))
              (primitives (grab box) (grab box))
              (trace (primitive-ended :result dropped :time 2 :data ())
                     (primitive-ended :result dropped :time 4)))
    """
    assert (
        _run(tmp_path, given + expected, [InjectedFault(("grab", "?x"), "dropped")])
        == []
    )


def test_a_fault_leaves_other_requests_and_other_times_alone(tmp_path: Path) -> None:
    given = f"(script {GRAB}) (task (tidy))"
    expected = "(expect (fails (fetch box) dropped) (succeeds (fetch cup)))"
    fault = InjectedFault(("grab", "box"), "dropped")
    assert _run(tmp_path, given + expected, [fault]) == []
    both = "(expect (succeeds (tidy)))"
    for stop, start in ((1, 0), (None, 3)):
        fault = InjectedFault(("grab", "box"), "dropped", 1, start, stop)
        assert _run(tmp_path, given + both, [fault]) == []
    retried = "(expect (succeeds (tidy)) (method fetch by-hand 3 times))"
    fault = InjectedFault(("grab", "?x"), "dropped", 1, 2, 2)
    assert _run(tmp_path, given + retried, [fault]) == []


def test_a_fault_may_lie(tmp_path: Path) -> None:
    """It says `okay`, and nothing has happened."""
    given = f"(script {GRAB}) (task (fetch box))"
    expected = "(expect (fails (fetch box)) (memory (not (have box))))"
    assert (
        _run(tmp_path, given + expected, [InjectedFault(("grab", "?"), "okay")]) == []
    )


def test_faults_are_drawn_from_their_own_stream(tmp_path: Path) -> None:
    """With a chance of 0 everything is as if there were no fault."""
    given = f"(script {GRAB}) (task (tidy))"
    never = [InjectedFault(("grab", "?"), "dropped", 0.0)]
    assert _run(tmp_path, f"{given} (expect (succeeds (tidy)))", never) == []
    some = [InjectedFault(("grab", "?"), "dropped", 0.5)]
    clauses = f"{given} (expect (method fetch by-hand 2 times))"
    found = [bool(_run(tmp_path, clauses, some, seed)) for seed in range(20)]
    assert found == [bool(_run(tmp_path, clauses, some, seed)) for seed in range(20)]
    assert set(found) == {True, False}


def test_a_fault_in_the_course_of_other_primitives(tmp_path: Path) -> None:
    """The end of the one that is under way comes after, with its own effects."""
    given = """
      (script ((grab cup) okay :after 5 :asserts ((have cup)))
              ((grab box) okay :takes 6))
      (task (fetch cup)) (at 1 (task (fetch box)))
    """
    expected = """
      (expect (memory (have cup)) (fails (fetch box) dropped)
              (trace (primitive-ended :result dropped :time 7 :request (grab box))
                     (primitive-ended :request (grab cup) :time 7)))
    """
    faults = [InjectedFault(("grab", "box"), "dropped")]
    assert _run(tmp_path, given + expected, faults) == []


def test_faults_without_a_request_are_reported(tmp_path: Path) -> None:
    found = list(cases(tmp_path, LIBRARY + "(define-test it)").values())
    faults = (
        InjectedFault(("grab", "?x"), "dropped"),
        InjectedFault(("grabs", "?x"), "dropped"),
        InjectedFault(("grab", "?x"), "droped"),
        InjectedFault(("grab",), "dropped"),
    )
    assert list(TestSession(faults=faults).useless(found)) == [
        "(grabs ?x): unknown primitive `grabs`; did you mean `grab`?",
        "(grab ?x): `droped` is not a result of `grab`; did you mean `dropped`?",
        "(grab): `grab` takes 1 argument, not 0",
    ]
