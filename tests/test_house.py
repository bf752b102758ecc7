"""House rules that neither ruff, mypy nor import-linter can hold us to.

Which way imports may point is in pyproject.toml, `[tool.importlinter]`; why, in
docs/architecture.md.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[1]
MODULES = tuple(sorted((CHECKOUT / "rapc").rglob("*.py")))
NOT_CLI = tuple(m for m in MODULES if m.parent != CHECKOUT / "rapc" / "cli")
"""A command may import late what it needs, for the start-up time of the others."""

LONGEST_MODULE = 400
LONGEST_FUNCTION = 60

Function = ast.FunctionDef | ast.AsyncFunctionDef
Definition = Function | ast.ClassDef


DATA = ("rapc/ir/nodes.py", "rapc/language/grammar.py")
"""Modules that hold data alone, one row after the other."""


def _name(path: Path) -> str:
    return path.relative_to(CHECKOUT).as_posix()


@pytest.fixture(params=MODULES, ids=_name)
def module(request: pytest.FixtureRequest) -> Path:
    """Each module of the package in turn."""
    assert isinstance(request.param, Path)
    return request.param


def _functions(tree: ast.AST) -> Iterator[Function]:
    return (node for node in ast.walk(tree) if isinstance(node, Function))


def _public(tree: ast.Module | ast.ClassDef) -> Iterator[tuple[str, Definition]]:
    """Public functions, classes and their public methods, with their full names.

    What sets a property is described where the property is.
    """
    for node in tree.body:
        if isinstance(node, Definition) and not node.name.startswith("_"):
            if any(ast.unparse(d).endswith(".setter") for d in node.decorator_list):
                continue
            yield node.name, node
            if isinstance(node, ast.ClassDef):
                yield from ((f"{node.name}.{name}", d) for name, d in _public(node))


def test_there_are_modules_to_look_at() -> None:
    assert len(MODULES) > 50


def test_module_and_public_names_are_documented(module: Path) -> None:
    tree = ast.parse(module.read_text(encoding="utf-8"))
    assert ast.get_docstring(tree), "the module does not say what it is for"
    bare = [name for name, node in _public(tree) if not ast.get_docstring(node)]
    assert bare == []


def test_module_and_functions_are_short(module: Path) -> None:
    text = module.read_text(encoding="utf-8")
    assert text.count("\n") <= LONGEST_MODULE or _name(module) in DATA
    long = [
        node.name
        for node in _functions(ast.parse(text))
        if (node.end_lineno or 0) - node.lineno >= LONGEST_FUNCTION
    ]
    assert long == []


@pytest.mark.parametrize("module", NOT_CLI, indirect=True, ids=_name)
def test_no_import_hides_in_a_function(module: Path) -> None:
    hidden = [
        f"{function.name}, line {node.lineno}"
        for function in _functions(ast.parse(module.read_text(encoding="utf-8")))
        for node in ast.walk(function)
        if isinstance(node, ast.Import | ast.ImportFrom)
    ]
    assert hidden == []
