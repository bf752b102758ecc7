"""Handlers of worlds in Python, found in the text by `ast`; no module is imported.

A handler stands in a dictionary by the name of its primitive or datum:
`Handlers(results={"drive": driven})`. The offer of a world has the same names.
"""

from __future__ import annotations

import ast
import os
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path

from lsprotocol import types
from pygls.uris import from_fs_path

from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.lsp.positions import Text
from rapc.lsp.project import configuration
from rapc.lsp.workspace import View, Workspace, name_of
from rapc.worlds.source_names import names_in_code

_WORLDS = Path(__file__).parents[1] / "worlds"

_MOST = 1000
"""The number of Python files that are searched."""

Place = tuple[int, int, int, int]
"""Row and column, from 0, of the start and the end of a word; columns in bytes."""


def handlers(
    workspace: Workspace, name: str, worlds: bool = True
) -> list[types.Location]:
    """Return the handlers of a primitive or datum; without handlers, its offers.

    The Python files of the workspace count. If they have no result, the worlds of rapc
    count, unless `worlds` is false.
    """
    for folders in (workspace.folders, [str(_WORLDS)] if worlds else []):
        called: list[types.Location] = []
        offered: list[types.Location] = []
        for file in _python_files(folders):
            functions, offers = _names(file, _stamp(file))
            places = functions.get(name, ())
            called += [_location(workspace, file, place) for place in places]
            places = offers.get(name, ())
            offered += [_location(workspace, file, place) for place in places]
        if called or offered:
            return called or offered
    return []


def declarations(
    workspace: Workspace, uri: str, position: types.Position
) -> list[types.Location]:
    """Return the declaration of the primitive or datum named in Python at a position.

    Args:
        workspace: the libraries that may declare the names.
        uri: the Python file.
        position: a position in a string, or in the name of a handler.
    """
    file = name_of(uri)
    functions, offers = _names(file, _stamp(file))
    text = _text(workspace, file)
    offset = text.offset(position)
    names = {
        name
        for name, places in (*functions.items(), *offers.items())
        if any(_covers(text, _range(text, place), offset) for place in places)
    }
    found: dict[Span, types.Location] = {}
    for snapshot in workspace.snapshots.values():
        for part in snapshot.parts:
            for name in sorted(names):
                for table in (part.library.primitives, part.library.data):
                    form: nodes.Node | None = table.get(name)
                    if form is not None:
                        view = View(workspace, snapshot, part, form.span.file)
                        found[form.span] = view.location(form.span)
    return list(found.values())


def worlds_of(view: View) -> set[str]:
    """Return the worlds that the tests of a library name."""
    return {
        test.world
        for part in view.snapshot.parts
        for test in part.library.tests
        if test.world is not None
    }


def names_in_worlds(view: View) -> Mapping[str, Path]:
    """Return the names in the code of the worlds of a library, each with its file."""
    worlds = worlds_of(view)
    found: dict[str, Path] = {}
    for folder in view.workspace.folders:
        modules = configuration(folder).config.world_modules
        found |= names_in_code(worlds, Path(folder), modules)
    return found


def _covers(text: Text, place: types.Range, offset: int) -> bool:
    start, end = text.stretch(place)
    return start <= offset <= end


def _python_files(folders: Sequence[str]) -> Iterator[str]:
    """Yield the Python files below folders."""
    count = 0
    for folder in folders:
        for here, inner, files in os.walk(folder):
            inner[:] = sorted(
                name
                for name in inner
                if not name.startswith((".", "_")) and name != "node_modules"
            )
            for name in sorted(files):
                if name.endswith(".py"):
                    count += 1
                    if count > _MOST:
                        return
                    yield os.path.join(here, name)


def _stamp(file: str) -> tuple[int, int]:
    try:
        status = os.stat(file)
    except OSError:  # the file has been removed
        return 0, 0
    return status.st_mtime_ns, status.st_size


_Places = Mapping[str, list[Place]]


@lru_cache(maxsize=2 * _MOST)
def _names(file: str, stamp: tuple[int, int]) -> tuple[_Places, _Places]:
    """Return the handlers and the other keys of dictionaries of a Python file."""
    functions: dict[str, list[Place]] = {}
    offers: dict[str, list[Place]] = {}
    try:
        tree = ast.parse(Path(file).read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError):  # no Python to search
        return functions, offers
    defined = {
        one.name: one
        for one in ast.walk(tree)
        if isinstance(one, ast.FunctionDef | ast.AsyncFunctionDef)
    }
    for table in ast.walk(tree):
        for key, value in _items(table):
            if isinstance(value, ast.Name) and value.id in defined:
                function = defined[value.id]
                start = function.col_offset + len("def ")
                row, size = function.lineno - 1, len(value.id)
                place = (row, start, row, start + size)
                functions.setdefault(str(key.value), []).append(place)
            else:
                offers.setdefault(str(key.value), []).append(_place(key))
    return functions, offers


def _items(table: ast.AST) -> Iterator[tuple[ast.Constant, ast.expr]]:
    if isinstance(table, ast.Dict):
        for key, value in zip(table.keys, table.values, strict=True):
            if isinstance(key, ast.Constant) and isinstance(key.value, str):
                yield key, value


def _place(node: ast.expr) -> Place:
    end_row = node.end_lineno or node.lineno
    end = node.col_offset if node.end_col_offset is None else node.end_col_offset
    return node.lineno - 1, node.col_offset, end_row - 1, end


def _text(workspace: Workspace, file: str) -> Text:
    document = workspace.document(file)
    if document is not None:
        return document.text
    try:
        text = Path(file).read_text(encoding="utf-8", errors="replace")
    except OSError:  # the file has been removed
        text = ""
    return Text(file, text, workspace.wide)


def _location(workspace: Workspace, file: str, place: Place) -> types.Location:
    uri = from_fs_path(file) or file
    return types.Location(uri, _range(_text(workspace, file), place))


def _range(text: Text, place: Place) -> types.Range:
    """Return the range of a place whose columns count bytes."""
    row, column, end_row, end_column = place
    return text.range(_offset(text, row, column), _offset(text, end_row, end_column))


def _offset(text: SourceFile, row: int, column: int) -> int:
    line = text.line(row + 1)
    start = text.line_starts[min(row, len(text.line_starts) - 1)]
    return start + len(line.encode()[:column].decode(errors="ignore"))
