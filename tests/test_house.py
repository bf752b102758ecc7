"""House rules that neither ruff, mypy nor import-linter can hold us to.

Which way imports may point is in pyproject.toml, `[tool.importlinter]`; why, in
docs/architecture.md.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
import pytest

CHECKOUT = Path(__file__).parents[1]
TESTS = CHECKOUT / "tests"
LANGUAGE = CHECKOUT / "docs" / "language"

LONGEST_MODULE = 400
"""Lines of a module that holds one idea."""

LONGER = {
    "rapc/ir/nodes.py": "data: a record for each thing that a text can say",
    "rapc/runtime/interpreter.py": "one class: all that a host may ask of a run",
    "rapc/runtime/memory/recognition/recognizer.py": "one algorithm, told at its head",
}
"""Modules that would be harder to read in two, with the reason."""

LONGEST_FUNCTION = 60

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


OPENERS = {"as", "how", "it", "such", "so", "what", "where", "when", "who", "why"}
"""Words that are neither verb nor noun: what a function returns is not in them."""


def test_docstrings_of_functions_begin_with_a_verb_or_a_noun(
    modules: Sequence[Module],
) -> None:
    """That there are docstrings is seen to by ruff."""
    vague = [
        f"{module.name}: {node.name}"
        for module in modules
        for node in module.functions
        if (ast.get_docstring(node, clean=False) or "Nothing").split()[0].lower()
        in OPENERS
    ]
    assert vague == []


def test_modules_and_functions_are_short(modules: Sequence[Module]) -> None:
    long = [
        module.name
        for module in modules
        if (module.text.count("\n") > LONGEST_MODULE) is not (module.name in LONGER)
    ]
    long += [
        f"{module.name}: {node.name}"
        for module in modules
        for node in module.functions
        if (node.end_lineno or 0) - node.lineno >= LONGEST_FUNCTION
    ]
    assert long == []


def test_files_of_tests_are_short() -> None:
    long = [
        path.relative_to(CHECKOUT).as_posix()
        for path in TESTS.rglob("*.py")
        if path.read_text(encoding="utf-8").count("\n") > LONGEST_MODULE
    ]
    assert long == []


def test_no_import_hides_in_a_function(modules: Sequence[Module]) -> None:
    """What few runs need is imported late by `rapc.base.later`."""
    hidden = [
        f"{module.name}: {function.name}, line {node.lineno}"
        for module in modules
        if re.search(r"^ +(from|import)\b", module.text, re.M)
        for function in module.functions
        for node in _statements(function)
        if isinstance(node, ast.Import | ast.ImportFrom)
    ]
    assert hidden == []


def test_all_runs_begin_in_one_way(modules: Sequence[Module]) -> None:
    """A run is made by `rapc.runtime.prepare`, or of another run (save, fork)."""
    makers = [m.name for m in modules if re.search(r"\bInterpreter\(", m.text)]
    assert makers == ["rapc/runtime/interpreter.py", "rapc/runtime/prepare.py"]


def test_no_two_helpers_of_tests_have_one_name() -> None:
    helpers = Counter(
        path.name
        for path in TESTS.rglob("*.py")
        if not path.name.startswith(("test_", "__", "conftest."))
    )
    assert len(helpers) > 20
    assert [name for name, count in helpers.items() if count > 1] == []


def _python_files() -> list[Path]:
    rooms = ("rapc", "tests", "bench")
    return [path for room in rooms for path in sorted((CHECKOUT / room).rglob("*.py"))]


def _sentences() -> set[str]:
    return {
        number
        for page in LANGUAGE.glob("*.md")
        for number in re.findall(
            r"^- \*\*(\d+\.\d+)\*\*", page.read_text(encoding="utf-8"), re.M
        )
    }


def test_references_name_sentences_of_the_language() -> None:
    """L with two numbers is a sentence of docs/language, with one a page."""
    sentences = _sentences()
    known = sentences | {page.name[0] for page in LANGUAGE.glob("*.md")}
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


SHARED = {
    "Event": "of a run, and of a network of skills",
    "Datum": "a form, and the message that it declares",
    "Signal": "a form, and the message that it declares",
    "Goal": "in a text, and of a task",
    "Position": "in a text, and the event of a skill that says where the robot is",
    "MethodChosen": "what a test expects, and the event",
    "ResourceChange": "an annotation, and the event",
    "Map": "of the hallway, and of the truck's roads",
    "MapError": "of the hallway, and of the truck's roads",
}
"""Names of two classes each, one and the same word of the field in two rooms."""


def test_a_name_stands_for_one_class(modules: Sequence[Module]) -> None:
    """Nodes apart: these are called as the grammar has them, and written `nodes.X`."""
    where: dict[str, list[str]] = {}
    for module in modules:
        for name in re.findall(r"^class ([A-Z]\w*)", module.text, re.M):
            where.setdefault(name, []).append(module.name)
    twice = {
        name: places
        for name, places in where.items()
        if len([p for p in places if p != "rapc/ir/nodes.py"]) > 1
    }
    assert {name: twice[name] for name in twice if name not in SHARED} == {}
    assert [name for name in SHARED if len(where[name]) != 2] == []
    bare = [
        f"{module.name}: {name}"
        for module in modules
        for found in re.findall(
            r"^from rapc\.ir\.nodes import (\([^)]*\)|[^\n]*)", module.text, re.M
        )
        for name in re.findall(r"\w+", found)
        if len(where.get(name, ())) > 1
    ]
    assert bare == []
