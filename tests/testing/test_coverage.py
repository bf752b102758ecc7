"""What tests have exercised of a library, counted, summed up and told."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from rapc.cli.main import main
from rapc.testing import discover
from rapc.testing.coverage import (
    Coverage,
    FileCoverage,
    Share,
    as_json,
    share_in_all,
    table,
    verdict,
)
from rapc.testing.session import TestSession
from tests.cli.command import rapc as command

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


def test_table_fits_80_columns_and_lists_missing_values(tmp_path: Path) -> None:
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


@pytest.mark.parametrize("width", [40, 80])
def test_remarks_below_the_table_fit_the_terminal(
    width: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    _more(tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    size = os.terminal_size((width, 24))
    monkeypatch.setattr("shutil.get_terminal_size", lambda: size)
    with pytest.raises(SystemExit):
        main(["test", ".", "--coverage", "--color", "never"])
    said = capsys.readouterr().out
    told = said.split("queries asked", 1)[1].splitlines()
    assert "constraints of methods broken" in " ".join("".join(told).split())
    assert max(map(len, told)) <= width


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


MORE = """\
(declare-primitive go (?where) (okay))
(declare-memory-proposition at (?where))
(declare-memory-proposition shut (?where))
(define-query (open ?where) (not (shut ?where)))
(define-query (free ?where) (open ?where))
(define-query (unasked ?where) (at ?where))

(define-rap (visit ?where)
  (succeed (at ?where))
  (method walk (context (free ?where)) (constraints (free ?where))
    (task-net (t1 (step ?where))))
  (method wait (context otherwise) (task-net)))

(define-rap (step ?where)
  (succeed (at ?where))
  (method (primitive (go ?where))))

(define-agenda day (task (visit hall)) (task (visit attic) :at 5))
"""
MORE_TESTS = """\
(require "more")
(define-test one
  (agenda day) (until 3)
  (script ((go hall) :asserts ((shut hall))))
  (expect (never (go attic))))
"""


def _more(folder: Path) -> tuple[FileCoverage, ...]:
    (folder / "more.rap").write_text(MORE, encoding="utf-8")
    (folder / "more.test.rap").write_text(MORE_TESTS, encoding="utf-8")
    gathered = Coverage()
    (outcome,) = TestSession(coverage=gathered).run(discover.find([folder]).cases)
    assert outcome.failures == ()
    return gathered.files()


def test_queries_agendas_and_constraints_are_counted(tmp_path: Path) -> None:
    (file,) = _more(tmp_path)
    assert [(q.name, q.asked > 0) for q in file.queries] == [
        ("open", True),
        ("free", True),
        ("unasked", False),
    ]
    (day,) = file.agendas
    assert [(task.goal, task.given) for task in day.tasks] == [
        ("(visit hall)", 1),
        ("(visit attic)", 0),
    ]
    visit = file.raps[0]
    walk, wait = visit.methods
    assert walk.constraints_broken == 1
    assert wait.constraints_broken is None
    assert wait.context_true
    assert wait.context_false
    lines = list(table([file]))
    counted = [line for line in lines if line.startswith("queries asked")]
    assert counted == [
        "queries asked: 2/3; tasks of agendas given: 1/2; "
        "constraints of methods broken: 1/1"
    ]
    assert f"{file.file}:6 unasked: never asked" in lines
    assert f"{file.file}:18 day: never given (visit attic)" in lines
    told = json.loads(as_json([file]))
    assert told["covered"]["queries_asked"] == {"covered": 2, "of": 3}
    assert told["files"][0]["agendas"][0]["tasks"][1]["given"] == 0


OWN = """\
(define-rap (rest) (method (task-net)))
(define-test rests (task (rest)) (expect (succeeds (rest))))
"""


def test_how_much_is_covered_in_all(tmp_path: Path) -> None:
    files = _more(tmp_path)
    assert share_in_all(files) == Share(10, 12)
    assert verdict(files, 83) == (False, "coverage: 83.3 % (10 of 12)")
    assert verdict(files, 84) == (
        True,
        "coverage: 83.3 % (10 of 12), less than the 84 % that are asked for",
    )


def test_coverage_of_nothing_meets_no_minimum() -> None:
    said = "coverage: the tests run no library outside of test files"
    assert verdict((), 0) == (False, said)
    asked = f"{said}, less than the 100 % that are asked for"
    assert verdict((), 100) == (True, asked)


def test_less_coverage_than_asked_for_is_told_by_the_exit_status(
    tmp_path: Path,
) -> None:
    _more(tmp_path)
    done = command("test", ".", "--coverage-min", "83", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert "coverage: 83.3 % (10 of 12)\n" in done.stdout
    done = command("test", ".", "--coverage-min", "90", "-q", cwd=tmp_path)
    assert done.returncode == 1
    assert "less than the 90 % that are asked for" in done.stdout
    (tmp_path / "own.test.rap").write_text(OWN)
    done = command("test", "own.test.rap", "--coverage-min", "100", cwd=tmp_path)
    assert done.returncode == 1
    done = command("test", ".", "--coverage-min", "101", cwd=tmp_path)
    assert done.returncode == 2


@pytest.mark.slow
def test_pytest_tells_coverage_too(tmp_path: Path) -> None:
    _more(tmp_path)
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts =\n")
    ran = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-n0", "."]
    for least, status in (("80", 0), ("90", 1)):
        options = ["--rap-coverage", "all.json", "--rap-coverage-min", least]
        done = subprocess.run(
            [*ran, *options], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert done.returncode == status, done.stdout
        assert "coverage: 83.3 % (10 of 12)" in done.stdout
        assert json.loads((tmp_path / "all.json").read_text())["format"] == 1


HALL = """\
(declare-skill :drive () :events (:arrived :stuck))
(declare-event :arrived ())
(declare-event :stuck ())
(declare-event :bump ())
(declare-memory-proposition at (?where))
(define-rap (go)
  (method (primitive (enable (:drive))
    (wait-for (:arrived) :succeed) (wait-for (:stuck) :fail))))
(define-rap (trip)
  (method (task-net (t1 (go) (wait-for (:bump) :fail) (wait-for (:arrived) :succeed)))))
(define-memory-rule (go) :finish
  (match-result
    (succeed (rule (true (mem-add (at home)))))
    (stuck (rule (true (mem-add (at wall)))))))
(define-event-rule (:bump)
  (rule ((at home) (mem-del (at)))
        (true (mem-add (at nowhere)))))
"""

HALL_TESTS = """\
(require "hall")
(define-test arrives
  (script ((enable (:drive)) :after 2 :signals ((:arrived))))
  (task (trip))
  (expect (succeeds (trip))))
(define-test bumps
  (task (trip)) (at 1 (signals (:bump))) (until 2)
  (expect (memory (at nowhere))))
"""


def test_coverage_counts_ended_waits_and_active_rules(
    tmp_path: Path,
) -> None:
    (tmp_path / "hall.rap").write_text(HALL, encoding="utf-8")
    (tmp_path / "hall.test.rap").write_text(HALL_TESTS, encoding="utf-8")
    gathered = Coverage()
    found = discover.find([tmp_path])
    outcomes = list(TestSession(coverage=gathered).run(found.cases))
    assert [outcome.failures for outcome in outcomes] == [(), ()]
    (file,) = gathered.files()
    heard = {
        (rap.name, wait.signal): wait.heard
        for rap in file.raps
        for method in rap.methods
        for wait in method.waits
    }
    assert heard == {
        ("go", ":arrived"): 1,
        ("go", ":stuck"): 0,
        ("trip", ":bump"): 1,
        ("trip", ":arrived"): 1,
    }
    ran = [(rule.name, rule.row, rule.ran) for rule in file.rules]
    assert ran == [("go", 13, 1), ("go", 14, 0), (":bump", 16, 0), (":bump", 17, 1)]
    lines = list(table(gathered.files()))
    assert "awaited signals heard: 3/4; rules run: 2/4" in lines
    assert any(line.endswith("hall.rap:6 go: never heard :stuck") for line in lines)
    assert any(line.endswith("hall.rap:16 rule for :bump: never run") for line in lines)


def test_added_methods_count_in_their_own_file(tmp_path: Path) -> None:
    added = "(define-method step leap (context otherwise) (primitive (go ?where)))"
    test = '(require "added") (define-test two (task (step den)) (script ((go den))) '
    test += "(expect (never (go hall))))"
    (tmp_path / "added.rap").write_text(f'(require "more")\n{added}', encoding="utf-8")
    (tmp_path / "added.test.rap").write_text(test, encoding="utf-8")
    (tmp_path / "more.rap").write_text(
        MORE.replace("(method (primitive", "(method (context nil) (primitive"),
        encoding="utf-8",
    )
    gathered, found = Coverage(), discover.find([tmp_path])
    assert found.reports == ()
    (outcome,) = TestSession(coverage=gathered).run(found.cases)
    assert outcome.failures == ()
    added_file, more = gathered.files()
    (leap,) = added_file.methods
    assert (leap.rap, leap.name, leap.row, leap.chosen > 0) == ("step", "leap", 2, True)
    assert [method.name for method in more.raps[1].methods] == ["#1"]
    assert f"{added_file.file}:2 step: context never false leap" in table(
        gathered.files()
    )
    assert json.loads(as_json([added_file]))["files"][0]["methods"][0]["rap"] == "step"
