"""Tests in a simulator: seed, options and agenda, without a script."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.testing.discover import find
from rapc.testing.faults import read_fault
from rapc.testing.run import Case, Outcome, Status, run_case
from rapc.testing.session import TestSession

from .small_suite import happened

COURIER = Path(__file__).parents[2] / "examples" / "courier"

DELIVERED = "(succeeds (deliver meals ward-4))"


def outcome_of(folder: Path, clauses: str, seed: int = 0) -> Outcome:
    """The outcome of a test of the courier's library in its world."""
    return run_case(written(folder, clauses), seed)


def written(folder: Path, clauses: str) -> Case:
    """A test of the courier's library in its world, beside a copy of the library."""
    for file in COURIER.glob("*.rap"):
        if not file.name.endswith(".test.rap"):
            (folder / file.name).write_bytes(file.read_bytes())
    path = folder / "it.test.rap"
    text = f'(require "shift") (define-test it (world courier) {clauses})'
    path.write_text(text, encoding="utf-8")
    found = find([path])
    assert found.reports == ()
    return found.cases[0]


def test_agenda_runs_in_the_world_with_the_seed_of_the_test(tmp_path: Path) -> None:
    clauses = "(seed 4) (agenda shift) (until 3000) (expect {})"
    for expected, status in (
        (f"(ends-by 1236 (deliver meals ward-4)) {DELIVERED}", Status.PASSED),
        ("(ends-by 1235 (deliver meals ward-4))", Status.FAILED),
    ):
        for seed in (0, 1):
            outcome = outcome_of(tmp_path, clauses.format(expected), seed)
            assert (outcome.status, outcome.seed) == (status, 4), happened(outcome)


def test_options_change_the_world_of_the_run(tmp_path: Path) -> None:
    clauses = "(options (battery {})) (until 0) (task (deliver linen ward-1)) "
    clauses += "(expect (memory (battery 33)))"
    assert outcome_of(tmp_path, clauses.format(33)).status is Status.PASSED
    assert outcome_of(tmp_path, clauses.format(34)).status is Status.FAILED


def test_expectations_at_a_time_precede_the_next_request(tmp_path: Path) -> None:
    """At time 0 the robot is at the base; later it is elsewhere."""
    clauses = "(seed 4) (agenda shift) (until 3000) (at {} (expect {}))"
    known = "(memory (robot-at base))"
    assert outcome_of(tmp_path, clauses.format(0, known)).status is Status.PASSED
    late = outcome_of(tmp_path, clauses.format(200, "(memory (robot-at base))"))
    assert late.status is Status.FAILED


def test_faults_reach_the_simulator(tmp_path: Path) -> None:
    clauses = f"(seed 4) (agenda shift) (until 3000) (expect {DELIVERED})"
    session = TestSession(faults=(read_fault("(hand-over ? ?) nobody-there"),))
    case = written(tmp_path, clauses)
    assert TestSession().run_one(case).status is Status.PASSED
    assert session.run_one(case).status is Status.FAILED


@pytest.mark.parametrize(
    ("clauses", "message"),
    [
        ("(options (batery 3))", "the world `courier` has no option `batery`"),
        ("(options (battery full))", "`courier.battery` takes one integer"),
    ],
)
def test_invalid_option_of_a_simulator_is_an_error(
    tmp_path: Path, clauses: str, message: str
) -> None:
    outcome = outcome_of(tmp_path, f"{clauses} (agenda shift)")
    assert outcome.status is Status.ERROR
    assert happened(outcome)[0].startswith(message)
