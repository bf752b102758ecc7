"""rapc's interpreter and the reference make the same trace, event for event.

Seeds 0 to 39 by default, to 479 among the slow tests, to 1599 nightly; more by hand
with `python -m tests.reference.compare`.
"""

from __future__ import annotations

from collections import Counter

import msgspec
import pytest

from rapc.events import Event, TaskResult
from rapc.runtime.interpreter import Interpreter
from tests.effort import first
from tests.reference.case import (
    Case,
    begin,
    interpreter_of,
    run_reference,
    stepwise,
)
from tests.reference.compare import compare, kind_of, report, rows
from tests.reference.generate import generate
from tests.reference.vocabulary import UNBROKEN

CHUNK = 40
CHUNKS = 40
IN_CI = 12

OFTEN = (
    "data-received",
    "deadline-missed",
    "fact-asserted",
    "fact-erased",
    "family-switched",
    "method-chosen",
    "method-ended",
    "method-suspended",
    "primitive-cancelled",
    "primitive-ended",
    "primitive-requested",
    "query-faulted",
    "refused",
    "request-refused",
    "resource-changed",
    "run-ended broken",
    "run-ended cycles",
    "run-ended done",
    "run-ended runaway",
    "run-ended stuck",
    "run-ended until",
    "signal",
    "solver-called",
    "task-blocked",
    "task-created",
    "task-failed futile-loop",
    "task-failed interference",
    "task-failed no-method",
    "task-failed signal",
    "task-removed cancelled",
    "task-removed parent-removed",
    "task-removed run-over",
    "task-removed sibling-failed",
    "task-removed signal",
    "task-removed until",
    "task-selected",
    "task-succeeded",
    "task-woken",
)
"""What must come up in some twelve hundred runs, or the comparison says little."""


@pytest.mark.parametrize("chunk", first(1, range(CHUNKS), IN_CI))
def test_both_interpreters_make_the_same_trace(chunk: int) -> None:
    for seed in range(chunk * CHUNK, (chunk + 1) * CHUNK):
        case = generate(seed)
        outcome = compare(case)
        assert outcome.verdict == "agree", report(case, outcome)


@pytest.mark.slow
def test_the_runs_compared_are_eventful() -> None:
    counts: Counter[str] = Counter()
    for seed in range(600):
        trace = rows(run_reference(generate(seed)), msgspec.to_builtins)
        counts.update(kind_of(row) for row in trace)
    assert [kind for kind in OFTEN if counts[kind] < 3] == []
    assert counts["task-selected"] > 600 * 8


def test_a_seed_makes_one_case_only() -> None:
    assert generate(7) == generate(7)
    assert generate(7) != generate(8)


def _after_some_cycles(case: Case, listening: bool) -> object:
    """How a run stands after some cycles, with a listener or without."""
    run = interpreter_of(case)
    if listening:
        heard: list[Event] = []
        run.listen(heard.append)
    begin(case, run)
    for _ in range(60):
        run.step()
    asked = [run.memory.query(name, None, None) for name in "pq"]
    return run.agenda(), _outcomes(run), run.now, run.reason, run.succeeded, asked


def _outcomes(run: Interpreter) -> list[TaskResult]:
    """What has become of the tasks given: why one failed is told to listeners alone."""
    return [msgspec.structs.replace(one, because=None) for one in run.results()]


@pytest.mark.parametrize("chunk", first(1, range(CHUNKS), IN_CI))
def test_run_does_the_same_with_and_without_listeners(chunk: int) -> None:
    for seed in range(chunk * CHUNK, (chunk + 1) * CHUNK):
        case = stepwise(generate(seed, UNBROKEN))
        told, silent = [_after_some_cycles(case, told) for told in (True, False)]
        assert told == silent, f"seed {seed}"
