"""House rules that neither ruff, mypy nor import-linter can hold us to.

Which way imports may point is in pyproject.toml, `[tool.importlinter]`; why, in
docs/developers/architecture.md.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import pytest

CHECKOUT = Path(__file__).parents[1]
TESTS = CHECKOUT / "tests"
LANGUAGE = CHECKOUT / "docs" / "language"

pytestmark = pytest.mark.xdist_group("house")

Function = ast.FunctionDef | ast.AsyncFunctionDef


class Module(msgspec.Struct, frozen=True):
    """A module of the package: where it is, its text, and its functions as trees."""

    name: str
    text: str
    functions: Sequence[Function]


@pytest.fixture(scope="module")
def modules() -> Sequence[Module]:
    """All modules of the package, read once."""
    found = []
    for path in sorted((CHECKOUT / "rapc").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        name = path.relative_to(CHECKOUT).as_posix()
        found.append(Module(name, text, _functions(ast.parse(text))))
    assert len(found) > 50
    return found


def _functions(tree: ast.AST) -> list[Function]:
    return [node for node in _statements(tree) if isinstance(node, Function)]


def _statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield what stands below a tree, but for expressions: most nodes are such."""
    for block in ("body", "orelse", "finalbody", "handlers", "cases"):
        for node in getattr(tree, block, ()):
            yield node
            yield from _statements(node)


LATE = ("rapc/cli/",)
"""Where a function may import a module of rapc: a command imports what it needs."""


def test_no_import_hides_in_a_function(modules: Sequence[Module]) -> None:
    """Third parties may be imported where they are first used."""
    hidden = [
        f"{module.name}: {function.name}, line {node.lineno}"
        for module in modules
        if re.search(r"^ +(from|import)\b", module.text, re.M)
        for function in module.functions
        for node in _statements(function)
        if isinstance(node, ast.Import | ast.ImportFrom)
        if _is_of_rapc(node) and not module.name.startswith(LATE)
    ]
    assert hidden == []


BY_NAME = {
    "rapc/__init__.py": "a public name is imported when it is asked for",
    "rapc/analysis/registry.py": "a pass is imported when one of its rules is wanted",
    "rapc/host.py": "the planner is imported when a plan is wanted",
    "rapc/cli/main.py": "a command is imported when it is typed",
    "rapc/testing/pytest_plugin.py": "pytest loads the plug-in in every run",
    "rapc/worlds/registry.py": "a world is a module of anybody's",
}
"""Where modules are imported by their names, and why."""


def test_modules_are_imported_by_name_in_few_places(modules: Sequence[Module]) -> None:
    """An import that linters cannot see needs a reason; there are no proxies."""
    found = {module.name for module in modules if "import_module" in module.text}
    assert found == {*BY_NAME}


def _is_of_rapc(node: ast.Import | ast.ImportFrom) -> bool:
    if isinstance(node, ast.ImportFrom):
        return (node.module or "").startswith("rapc")
    return any(alias.name.startswith("rapc") for alias in node.names)


def test_all_runs_begin_in_one_way(modules: Sequence[Module]) -> None:
    """A run is prepared, or made of another run (save, fork)."""
    makers = [m.name for m in modules if re.search(r"\b(Interpreter|Run)\(", m.text)]
    assert makers == ["rapc/runtime/interpreter.py"]


def _python_files() -> list[Path]:
    rooms = ("rapc", "tests", "bench")
    return [path for room in rooms for path in sorted((CHECKOUT / room).rglob("*.py"))]


def _sentences() -> set[str]:
    return {
        number
        for page in LANGUAGE.glob("[0-9]*.md")
        for number in re.findall(
            r'<a id="(\d+\.\d+)"></a>', page.read_text(encoding="utf-8")
        )
    }


def test_references_name_sentences_of_the_language() -> None:
    """L with two numbers is a sentence of docs/language, with one a page."""
    sentences = _sentences()
    known = sentences | {
        page.name.partition("-")[0] for page in LANGUAGE.glob("[0-9]*.md")
    }
    unknown = [
        f"{path.relative_to(CHECKOUT).as_posix()}: [L {number}]"
        for path in _python_files()
        for cited in re.findall(r"\[L (\d[^\]]*)\]", path.read_text(encoding="utf-8"))
        for number in re.split(r",\s+", cited)
        if number not in known
    ]
    assert len(sentences) > 100
    assert unknown == []


def test_nothing_cites_a_paper_that_is_not_here() -> None:
    """The language is told in docs/language: "semantics 3" is no place to look at."""
    old = re.compile(r"\bsemantics(\.md|,? (section )?\d)", re.I)
    citing = [
        f"{path.relative_to(CHECKOUT).as_posix()}: {found.group()}"
        for path in (*_python_files(), *(CHECKOUT / "docs").rglob("*.md"))
        if path != Path(__file__)
        for found in old.finditer(path.read_text(encoding="utf-8"))
    ]
    assert citing == []
