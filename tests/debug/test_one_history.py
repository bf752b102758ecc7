"""A run is put at other moments in one place: no other module restores states."""

from __future__ import annotations

import ast
from pathlib import Path

import rapc

ROOT = Path(rapc.__file__).parent

ALLOWED = {
    "debug/acts.py": {"save", "restore", "enclose"},
    "debug/reload.py": {"save"},
    "debug/saved_state.py": {"save", "restore"},
}
"""Acts that make a run another, a world put behind one, and files of states."""


def _calls(path: Path) -> set[str]:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    calls = [node.func for node in ast.walk(tree) if isinstance(node, ast.Call)]
    return {one.attr for one in calls if isinstance(one, ast.Attribute)}


def test_states_are_saved_and_restored_by_the_history_alone() -> None:
    own = {"save", "restore", "enclose"}
    for package in ("debug", "repl"):
        for path in (ROOT / package).rglob("*.py"):
            name = path.relative_to(ROOT).as_posix()
            if name != "debug/history.py":
                assert _calls(path) & own <= ALLOWED.get(name, set()), name


def test_moments_are_gone_to_by_one_class() -> None:
    having = [
        f"{path.stem}.{node.name}"
        for path in (ROOT / "debug").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
        for part in node.body
        if isinstance(part, ast.FunctionDef) and part.name == "goto"
    ]
    assert sorted(having) == ["history.History", "recording.Playback"]
