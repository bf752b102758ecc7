"""Each expectation: when it holds, and what is said when it does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from rapc.testing.run import Status

from .small_suite import GRAB, happened, run

FETCH = f"(script {GRAB}) (task (fetch box))"
DROP = "(script ((grab ?x) dropped :takes 1)) (task (fetch box))"
RETRY = f"(script ((grab ?x) dropped :times 1) {GRAB}) (task (fetch box))"
FIND = "(script ((look mug) okay :asserts ((where mug shelf)))) (task (find mug))"
TIDY = f"(script {GRAB}) (task (tidy))"

HOLDS = [
    (FETCH, "(succeeds (fetch box))"),
    (FETCH, "(succeeds (fetch ?))"),
    (FETCH, "(succeeds (fetch ?what))"),
    (TIDY, "(succeeds (fetch cup)) (succeeds (fetch box)) (succeeds (tidy))"),
    (FIND, "(succeeds (find mug) shelf)"),
    (FIND, "(succeeds (find ?x) ?place)"),
    (FIND, "(succeeds (find mug))"),
    (DROP, "(fails (fetch box))"),
    (DROP, "(fails (fetch box) dropped)"),
    (DROP, "(fails (fetch ?) ?result)"),
    (f"{FETCH} (until 1)", "(active (fetch box))"),
    (FETCH, "(primitives (grab box))"),
    (FETCH, "(primitives (grab ?x))"),
    ("", "(primitives)"),
    (TIDY, "(primitives (grab cup) (grab box))"),
    (TIDY, "(primitives-include (grab box))"),
    (TIDY, "(primitives-include (grab cup) (grab ?))"),
    (TIDY, "(never (grab mug)) (never (look ?))"),
    (FETCH, "(memory (have box))"),
    (FETCH, "(memory (and (have ?x) (not (have cup))))"),
    (FETCH, "(memory (believe (have box) 1))"),
    (FETCH, "(method fetch by-hand) (method fetch by-hand 1 times)"),
    (FIND, "(method find #1) (method find #1 1) (method fetch by-hand 0 times)"),
    (DROP, "(method fetch by-hand 2 times)"),
    (TIDY, "(selected-before (tidy) (fetch cup))"),
    (TIDY, "(selected-before (fetch cup) (fetch box))"),
    (FETCH, "(ends-by 2 (fetch box))"),
    (DROP, "(trace (task-failed))"),
    (RETRY, "(succeeds (fetch box)) (fails-at-most 1)"),
    (DROP, "(fails-at-most 0)"),
    (DROP, "(trace (method-chosen) (primitive-ended :result dropped) (task-failed))"),
]


@pytest.mark.parametrize(("given", "expected"), HOLDS)
def test_it_holds(tmp_path: Path, given: str, expected: str) -> None:
    outcome = run(tmp_path, f"{given} (expect {expected})")
    assert happened(outcome) == []
    assert outcome.status is Status.PASSED


FAILED = "(fetch box) [1] failed at time 2 (futile-loop) - dropped"
WHY = [
    "  because of method `by-hand` of `fetch` at it.test.rap:11: with ?x box, "
    "chosen 2 times with the same bindings",
    "  because of primitive of `fetch` at it.test.rap:11: (grab ?x) with ?x box, "
    "the world answered `dropped`",
]
DONE = "(fetch box) [1] succeeded at time 2"

FAILS = [
    (
        RETRY,
        "(fails-at-most 0)",
        ["mended failures: 1", "  fetch                1 dropped"],
    ),
    (DROP, "(succeeds (fetch box))", [FAILED, *WHY]),
    (
        DROP,
        "(succeeds (fetch cup))",
        ["no task (fetch cup) was made, but", FAILED],
    ),
    (
        DROP,
        "(succeeds (find cup))",
        ["no task (find cup) was made, nor any other of `find`"],
    ),
    (
        FIND,
        "(succeeds (find mug) floor)",
        ["(find mug => shelf) [1] succeeded at time 0"],
    ),
    (FETCH, "(fails (fetch box))", [DONE]),
    (DROP, "(fails (fetch box) nothing)", [FAILED, *WHY]),
    (FETCH, "(active (fetch box))", [DONE]),
    (f"{FETCH} (until 1)", "(succeeds (fetch box))", ["(fetch box) [1] is active"]),
    (
        "(task (watch box)) (until 1)",
        "(succeeds (watch box))",
        ["(watch box) [1] waits for (where box here)"],
    ),
    (
        TIDY,
        "(primitives (grab cup))",
        ["unexpected requests:", "(grab box)"],
    ),
    (
        TIDY,
        "(primitives (grab box) (grab cup))",
        [
            "request 1 was (grab cup), not (grab box); all requests:",
            "(grab cup)",
            "(grab box)",
        ],
    ),
    (
        FETCH,
        "(primitives (grab box) (grab box))",
        ["(grab box) did not follow; all requests:", "(grab box)"],
    ),
    (
        "",
        "(primitives-include (grab box))",
        ["(grab box) did not come; all requests:", "no primitive was requested"],
    ),
    (
        TIDY,
        "(primitives-include (grab box) (grab cup))",
        [
            "(grab cup) did not come after those before it; all requests:",
            "(grab cup)",
            "(grab box)",
        ],
    ),
    (
        TIDY,
        "(never (grab box))",
        ["(grab box) was requested at time 2 by (fetch box) [3]"],
    ),
    (FETCH, "(memory (have cup))", ["in memory: (have box)"]),
    (
        FETCH,
        "(memory (and (have box) (where box ?p) (n= ?p unknown)))",
        ["in memory: (have box)", "no fact `where` is in memory"],
    ),
    (FETCH, "(memory (= 1 2))", ["it does not hold"]),
    (FETCH, "(method find #1)", ["no method of `find` was chosen"]),
    (
        DROP,
        "(method fetch by-hand 1 times)",
        ["method by-hand was chosen 2 times"],
    ),
    (FETCH, "(method fetch by-hand 0 times)", ["method by-hand was chosen once"]),
    (
        TIDY,
        "(selected-before (fetch box) (fetch cup))",
        [
            "(fetch box) [3] was first selected in cycle 4, at time 2",
            "(fetch cup) [2] was first selected in cycle 2, at time 0",
        ],
    ),
    (
        f"{TIDY} (until 1)",
        "(selected-before (fetch cup) (fetch box))",
        [
            "(fetch cup) [2] was first selected in cycle 2, at time 0",
            "(fetch box) [3] was never selected",
        ],
    ),
    (
        FETCH,
        "(selected-before (fetch box) (tidy))",
        [
            "(fetch box) [1] was first selected in cycle 1, at time 0",
            "no task (tidy) was made, nor any other of `tidy`",
        ],
    ),
    (FETCH, "(ends-by 1.5 (fetch box))", [DONE]),
    (
        FETCH,
        "(trace (task-failed))",
        ["no event fits pattern 1", "there was no event `task-failed`"],
    ),
    (
        DROP,
        "(trace (task-failed) (method-ended))",
        [
            "no event fits pattern 2 after the first 1",
            "(method-ended :task 1 :method by-hand :result dropped) at time 1",
            "(method-ended :task 1 :method by-hand :result dropped) at time 2",
        ],
    ),
]


@pytest.mark.parametrize(("given", "expected", "told"), FAILS)
def test_it_does_not_hold(
    tmp_path: Path, given: str, expected: str, told: list[str]
) -> None:
    outcome = run(tmp_path, f"{given} (expect {expected})")
    found = [line.replace(f"{tmp_path}/", "") for line in happened(outcome)]
    assert found == told
    assert outcome.status is Status.FAILED


def test_a_failure_points_at_its_expectation(tmp_path: Path) -> None:
    outcome = run(tmp_path, f"{FETCH} (expect (succeeds (fetch box)) (active (tidy)))")
    (failure,) = outcome.failures
    source = outcome.case.library.library.files[failure.span.file]
    assert source.text[failure.span.start : failure.span.end] == "(active (tidy))"


def test_many_tasks_are_not_all_listed(tmp_path: Path) -> None:
    tasks = "".join(f"(task (fetch box{n}))" for n in range(20))
    outcome = run(tmp_path, f"(script {GRAB}) {tasks} (expect (fails (fetch ?)))")
    lines = happened(outcome)
    assert len(lines) == 9
    assert lines[-1] == "and 12 more"


def test_one_of_several_tasks_is_enough(tmp_path: Path) -> None:
    rows = "((grab box) dropped :times 2) ((grab box) okay :asserts ((have box)))"
    tasks = "(task (fetch box)) (at 5 (task (fetch box)))"
    expected = "(expect (fails (fetch box)) (succeeds (fetch box)))"
    outcome = run(tmp_path, f"(script {rows}) {tasks} {expected}")
    assert outcome.status is Status.PASSED
