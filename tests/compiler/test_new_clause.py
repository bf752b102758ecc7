"""A clause with a formula is one row of `rapc.ir.clauses`, its syntax and its use.

A clause `(give-up formula)` is added to a copy of the package: a task fails where the
formula holds. Nothing but its syntax, its row and its one use in a cycle is written;
the checker, the compiler, the saved library and the debugger must know it then.
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
        'repeat_while:  "("',
        'give_up: "(" "give-up" formula ")"\nrepeat_while:  "("',
    ),
    (
        "language/words.py",
        '    "repeat_while": Words(',
        '    "give_up": Words("when it fails", "one formula", "[T 4]"),\n'
        '    "repeat_while": Words(',
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
        "    if found is not None:\n        succeed(machine, task, found)\n",
        "    given_up = plan.clauses.get('give-up')\n"
        "    machine.context.task = task\n"
        "    if found is not None:\n        succeed(machine, task, found)\n"
        "    elif given_up and given_up.holds(machine.context, task.env):\n"
        "        fail(machine, task, 'given-up', None)\n",
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
        " (script) (task (find cup)) (expect (fails (find cup) ?result)))"
    )
    (package / "find.test.rap").write_text(test, "utf-8")
    assert "1 passed" in _rapc(package, "test", "find.test.rap")
