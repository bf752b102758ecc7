"""What tests have exercised of a library, counted, summed up and told."""

from __future__ import annotations

import json
from pathlib import Path

from rapc.console.testing.coverage_table import as_json, table
from rapc.testing import discover
from rapc.testing.coverage import Coverage, FileCoverage
from rapc.testing.session import TestSession

ARMS = """\
(declare-primitive grab (?x) (okay dropped))
(declare-memory-proposition have (?x))
(declare-memory-property heavy (?x ?value) false)

(define-rap (fetch ?x)
  (succeed (have ?x))
  (method (context (heavy ?x)) (primitive (grab ?x)))
  (method lightly (context (not (heavy ?x))) (primitive (grab ?x)))
  (method (primitive (grab ?x))))

(define-rap (watch ?x)
  (monitor-state (heavy ?x))
  (method (task-net (t1 (fetch ?x)))))

(define-rap (unused) (monitor-state (have hat)) (method (task-net)))
"""

TESTS = """\
(require "arms")

(define-rap (own) (method (task-net)))

(define-test one
  (script ((grab ?x) dropped))
  (task (fetch cup)) (task (own))
  (expect (fails (fetch cup))))

(define-test two
  (script ((grab ?x) :asserts ((have ?x))))
  (task (watch box)) (at 3 (asserts (heavy box)))
  (expect (succeeds (watch box))))
"""


def _coverage(folder: Path) -> tuple[FileCoverage, ...]:
    (folder / "arms.rap").write_text(ARMS, encoding="utf-8")
    (folder / "arms.test.rap").write_text(TESTS, encoding="utf-8")
    found = discover.find([folder])
    gathered = Coverage()
    outcomes = list(TestSession(coverage=gathered).run(found.cases))
    assert [outcome.failures for outcome in outcomes] == [(), ()]
    return gathered.files()


def test_methods_contexts_monitors_and_failures_are_counted(tmp_path: Path) -> None:
    (file,) = _coverage(tmp_path)
    assert file.file == str(tmp_path / "arms.rap")
    fetch, watch, unused = file.raps
    first, lightly, last = fetch.methods
    assert (first.name, first.row) == ("#1", 7)
    assert (first.context_true, first.context_false) == (1, 5)
    assert (lightly.name, lightly.context_false) == ("lightly", 1)
    assert lightly.context_true == 5
    assert last.context_true is None
    assert first.chosen + lightly.chosen + last.chosen == 5
    assert first.ended_badly + lightly.ended_badly + last.ended_badly == 4
    assert (fetch.succeeded, fetch.failed) == (1, {"futile-loop": 1})
    assert fetch.monitor is None
    assert watch.monitor is not None
    assert (watch.monitor.blocked, watch.monitor.woken) == (1, 1)
    assert unused.monitor is not None
    assert (unused.monitor.blocked, unused.monitor.woken) == (0, 0)


def test_the_table_fits_80_columns_and_says_what_is_lacking(tmp_path: Path) -> None:
    lines = list(table(_coverage(tmp_path)))
    assert all(len(line) <= 80 for line in lines[:2])
    assert lines[0].split() == [
        "coverage",
        "methods",
        "true",
        "false",
        "bad",
        "end",
        "woken",
        "failed",
    ]
    assert lines[1].split()[2:] == ["2/2", "2/2", "2/5", "1/2", "1/3"]
    assert lines[2] == "tasks failed: futile-loop 1"
    assert lines[-1].endswith(":15 unused: never chosen #1; monitor never woken")


def test_the_json_holds_everything(tmp_path: Path) -> None:
    told = json.loads(as_json(_coverage(tmp_path)))
    assert told["format"] == 1
    (file,) = told["files"]
    assert told["covered"] == file["covered"]
    assert file["covered"]["monitors_woken"] == {"covered": 1, "of": 2}
    assert file["covered"]["raps_failed"] == {"covered": 1, "of": 3}
    assert [rap["name"] for rap in file["raps"]] == ["fetch", "watch", "unused"]
    assert file["raps"][0]["failed"] == {"futile-loop": 1}
    assert file["raps"][0]["methods"][2]["context_true"] is None


def test_without_a_library_there_is_nothing_to_cover(tmp_path: Path) -> None:
    assert list(table(())) == [
        "coverage: the tests run no library outside of test files"
    ]
    assert json.loads(as_json(()))["files"] == []
