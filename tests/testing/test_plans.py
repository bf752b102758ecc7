"""The expectations about plans: `plans` and `plans-none`."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.testing.run import Status, run_case
from tests.testing.small_suite import cases, happened

LIBRARY = """\
(declare-kind room (hall lab yard))
(declare-kind tool (saw drill))
(declare-primitive go (?room) (okay))
(declare-primitive take (?tool) (okay))
(declare-memory-property at ((?room room)) hall)
(declare-memory-proposition kept ((?tool tool) (?room room)))
(declare-memory-proposition held ((?tool tool)))
(declare-memory-proposition swept ((?room room)))

(define-rap (visit (?room room))
  (succeed (at ?room))
  (effects (at ?room))
  (method (primitive (go ?room))))

(define-rap (pick-up (?tool tool))
  (preconditions (and (kept ?tool ?room) (at ?room)))
  (succeed (held ?tool))
  (effects (held ?tool))
  (method (primitive (take ?tool))))

(define-rap (fetch-both)
  (succeed (and (held saw) (held drill)))
  (plan))

(define-rap (sweep (?room room))
  (succeed (swept ?room))
  (plan))
"""
SCRIPT = """(script ((go ?room) okay :takes 1 :asserts ((at ?room)))
                    ((take ?tool) okay :takes 1 :asserts ((held ?tool))))"""


def told(folder: Path, task: str, expectation: str) -> list[str]:
    facts = "(facts (kept saw yard) (kept drill yard))"
    test = f"(define-test it {facts} {SCRIPT} (task {task}) (expect {expectation}))"
    outcome = run_case(cases(folder, f"{LIBRARY}\n{test}")["it"], 0, None)
    lines = happened(outcome)
    assert (outcome.status is Status.PASSED) == (not lines)
    return lines


@pytest.mark.parametrize(
    "expectation",
    [
        "(plans (fetch-both))",
        "(plans (fetch-both) (visit yard) (pick-up saw) (pick-up drill))",
        "(plans (fetch-both) (visit yard) (pick-up drill) (pick-up saw))",
        "(plans (fetch-both) (visit ?) (pick-up ?) (pick-up saw))",
        "(plans-none (visit ?))",
    ],
)
def test_plan_has_these_steps_in_an_allowed_order(
    tmp_path: Path, expectation: str
) -> None:
    assert told(tmp_path, "(fetch-both)", expectation) == []


PLAN = [
    "plan-1 for (fetch-both): 3 steps [1] at time 0",
    "  t1 (visit yard)  for t2: (at yard); for t3: (at yard)",
    "  t2 (pick-up drill)  for the goal: (held drill)",
    "  t3 (pick-up saw)  for the goal: (held saw)",
]


@pytest.mark.parametrize(
    "steps",
    [
        "(visit yard) (pick-up saw)",
        "(pick-up saw) (visit yard) (pick-up drill)",
        "(visit yard) (pick-up saw) (pick-up saw)",
        "(visit lab) (pick-up saw) (pick-up drill)",
    ],
)
def test_other_steps_or_orders_fail_and_list_the_plan(
    tmp_path: Path, steps: str
) -> None:
    assert told(tmp_path, "(fetch-both)", f"(plans (fetch-both) {steps})") == PLAN


def test_goal_without_a_plan_is_expected_by_plans_none(tmp_path: Path) -> None:
    assert told(tmp_path, "(sweep lab)", "(plans-none (sweep lab))") == []
    assert told(tmp_path, "(sweep lab)", "(plans (sweep ?))") == [
        "no plan for (sweep lab): unsolvable (swept lab) [1] at time 0"
    ]
    assert told(tmp_path, "(fetch-both)", "(plans-none (fetch-both))") == PLAN[:1]


def test_task_that_never_needed_a_plan_is_named(tmp_path: Path) -> None:
    assert told(tmp_path, "(visit lab)", "(plans (sweep lab))") == [
        "the planner was not asked for (sweep lab)"
    ]


def test_pattern_of_the_event_matches_steps(tmp_path: Path) -> None:
    expectation = "(trace (plan-made :steps ?steps) (plan-made :method plan-9))"
    assert told(tmp_path, "(fetch-both)", expectation)[0] == (
        "no event fits pattern 2 after the first 1"
    )
