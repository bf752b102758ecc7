"""What is added in one place is known everywhere: a clause and an event.

A clause `(give-up formula)` and an event `task-given-up` are added to a copy of the
package: a task fails where the formula holds. Of the clause its syntax, its row in
`rapc.ir.clauses` and its one use in a cycle are written, of the event its record and
the place that emits it. Checker, compiler, saved library, traces and tests know them.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import rapc

EDITS = (
    ("language/rap.lark", "monitor_state\n", "monitor_state | give_up\n"),
    (
        "language/rap.lark",
        "// [T 4.6]\n",
        "//: when it fails\n//: takes: one formula\n"
        'give_up: "(" "give-up" formula ")"\n// [T 4.6]\n',
    ),
    (
        "ir/nodes.py",
        "    succeed: Formula | None\n",
        "    succeed: Formula | None\n    give_up: Formula | None\n",
    ),
    (
        "ir/clauses.py",
        '    Clause("monitor-state"',
        '    Clause("give-up", "give_up", "select", required=False),\n'
        '    Clause("monitor-state"',
    ),
    (
        "runtime/tasks/cycle.py",
        "        succeed(run, task, found)\n        return\n",
        "        succeed(run, task, found)\n        return\n"
        "    given_up = plan.clauses.get('give-up')\n"
        "    run.context.task = task\n"
        "    if given_up and given_up.holds(run.context, task.env):\n"
        "        kind, why = events.TaskGivenUp, ('lost', plan.name)\n"
        "        run.recorder.emit(kind, task=task.number, why=why)\n"
        "        fail(run, task, 'given-up', None)\n        return\n",
    ),
    (
        "runtime/tasks/cycle.py",
        "from rapc.events import",
        "from rapc import events\nfrom rapc.events import",
    ),
    (
        "events.py",
        "class TaskRemoved(",
        "class TaskGivenUp(Event, frozen=True, kw_only=True):\n"
        "    task: int\n"
        "    why: Fact\n\n"
        "    def line(self) -> str:\n"
        "        return f'    ... given up [{self.task}]'\n\n\n"
        "class TaskRemoved(",
    ),
)

LIBRARY = """\
(declare-memory-proposition lost (?thing))
(declare-memory-property colour-of (?thing ?colour) unknown)
(declare-primitive look (?thing) (okay))
(define-rap (find ?thing)
  (succeed (colour-of ?thing red))
  (give-up {})
  (method (primitive (look ?thing))))
"""

WRONG = {
    "unbound-variable": "(and (lost ?thing) (> ?colour 3))",
    "undeclared-predicate": "(los ?thing)",
    "contradiction": "(and (lost ?thing) (not (lost ?thing)))",
    "wrong-fact-arity": "(lost ?thing ?thing ?thing)",
}


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a copy of the package that has the clause."""
    folder = tmp_path_factory.mktemp("package")
    copy = folder / "rapc"
    ignored = shutil.ignore_patterns("__pycache__", "*.so")
    shutil.copytree(Path(rapc.__file__).parent, copy, ignore=ignored)
    for name, old, new in EDITS:
        text = (copy / name).read_text("utf-8")
        assert text.count(old) == 1, name
        (copy / name).write_text(text.replace(old, new), "utf-8")
    _python(folder, "-m", "rapc.language.build")
    return folder


def _python(folder: Path, *args: str, stdin: str = "") -> str:
    done = subprocess.run(
        [sys.executable, *args],
        input=stdin,
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode in (0, 1), done.stderr
    return done.stdout


def _rapc(folder: Path, *args: str, stdin: str = "") -> str:
    main = "from rapc.cli.main import main; main()"
    return _python(folder, "-c", main, *args, stdin=stdin)


def test_checker_knows_a_new_clause(package: Path) -> None:
    for rule, formula in WRONG.items():
        text = LIBRARY.format(formula)
        found = _rapc(package, "check", "--output-format", "json", "-", stdin=text)
        rows = {(one["name"], one["location"]["row"]) for one in json.loads(found)}
        assert (rule, 6) in rows, (rule, found)


def test_new_clause_is_laid_out_compiled_run_and_explained(package: Path) -> None:
    (package / "find.rap").write_text(LIBRARY.format("(lost ?thing)"), "utf-8")
    shown = _rapc(package, "fmt", "-", stdin=LIBRARY.format("(lost   ?thing)"))
    assert "(give-up (lost ?thing))" in shown
    _rapc(package, "compile", "find.rap", "-o", "find.rapc")
    plan = _rapc(package, "compile", "find.rapc", "--explain", "find")
    assert "give-up" in plan
    test = (
        '(require "find") (define-test gives-up (facts (lost cup))'
        " (script) (task (find cup)) (expect (fails (find cup) ?result)"
        " (trace (task-given-up :why (lost find)))))"
    )
    (package / "find.test.rap").write_text(test, "utf-8")
    assert "1 passed" in _rapc(package, "test", "find.test.rap")


def test_new_event_is_written_found_and_checked(package: Path) -> None:
    library = LIBRARY.format("(not (lost ?thing))")
    library = library.replace("(declare-primitive look (?thing) (okay))\n", "")
    library = library.replace("(primitive (look ?thing))", "(task-net)")
    (package / "find.rap").write_text(library, "utf-8")
    script = ("repl", "find.rap", "--task", "(find cup)", "-c", ":run")
    shown = _rapc(package, *script, "-c", ":find back task-given-up")
    assert shown.count("given up [1]") == 2
    assert "in cycle 1" in shown
    written = package / "run.jsonl"
    _rapc(package, *script, "-c", f":record {written}")
    rows = [json.loads(line) for line in written.read_text("utf-8").splitlines()]
    assert [r["why"] for r in rows if r["event"] == "task-given-up"] == ["(lost find)"]
    again = _rapc(package, "repl", str(written), "-c", ":find task-given-up")
    assert "given up [1]" in again
    test = '(require "find") (define-test x (task (find cup)) (expect (trace {})))'
    (package / "b.test.rap").write_text(test.format("(task-given-up :what 1)"), "utf-8")
    assert "unknown key `what`" in _rapc(package, "check", "b.test.rap")
