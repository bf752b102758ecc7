"""A question is a function in `rapc.debug.questions`; nobody else makes its rows."""

from __future__ import annotations

import ast
import importlib
import pkgutil
from pathlib import Path

import rapc.debug.questions
import rapc.repl
from rapc.debug.answer import Command
from rapc.repl.commands.table import commands
from rapc.repl.complete import next_words
from tests.debug.sessions import truck
from tests.repl.shells import truck_shell

ROWS = {"acting", "stopping", "travelling", "helping"}
"""Commands whose tables list what belongs to the shell: options, breakpoints, help."""


def _modules(package: object) -> list[object]:
    path, name = package.__path__, package.__name__  # type: ignore[attr-defined]
    found = [one.name for one in pkgutil.iter_modules(path)]
    return [importlib.import_module(f"{name}.{one}") for one in found]


def test_all_questions_of_the_package_are_commands() -> None:
    asked = {one.does for one in commands() if one.asks}
    written = {
        one.does
        for module in _modules(rapc.debug.questions)
        for one in vars(module).values()
        if isinstance(one, Command)
    }
    assert asked == written
    assert len(asked) > 20


def test_rows_of_answers_are_made_by_questions() -> None:
    for path in Path(rapc.repl.__path__[0]).rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        calls = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call)]
        names = {one.id for one in calls if isinstance(one, ast.Name)}
        assert "table" not in names or path.stem in (*ROWS, "shell"), path


def test_python_returns_the_shown_table() -> None:
    shell, history = truck_shell(), truck()
    history.goto(60)
    shell.answer(":goto 60")
    for one in commands():
        if one.asks and not one.examples[0].partition(" ")[2]:
            shown = shell.answer(f":{one.name}")
            assert one(history) == shown, one.name


def test_completion_offers_the_words_of_the_help() -> None:
    why = next(one for one in commands() if one.name == "why")
    assert why.takes == "[TASK] [in CYCLE] | failed [TASK] | end"
    assert list(next_words(why.takes, [])) == [
        ("TASK", ""),
        ("failed", "TASK"),
        ("end", ""),
    ]
    assert list(next_words(why.takes, ["12"])) == [("in", "CYCLE")]
    assert list(next_words(why.takes, ["12", "in"])) == [("CYCLE", "")]
    assert ("TASK", "") in next_words(why.takes, ["failed"])
    ways = list(next_words("CYCLE | at TIME | end", []))
    assert ways == [("CYCLE", ""), ("at", "TIME"), ("end", "")]


def test_clauses_are_asked_in_parts_by_one_function() -> None:
    calling = [
        path.name
        for path in Path(rapc.__path__[0]).rglob("*.py")
        if "context.next_part()" in path.read_text(encoding="utf-8")
    ]
    assert calling == ["causes.py"]
