"""The names in the Python code of worlds, found without importing the code.

A name that the code of a world uses must not be renamed in a library alone. Text
constants and the names of functions count: `drive` for `"(drive kitchen)"` and for
`def drive`.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from importlib.machinery import PathFinder
from importlib.metadata import entry_points
from pathlib import Path

from rapc.base.files import read_text
from rapc.errors import LoadError
from rapc.worlds.registry import GROUP, OWN

_WORD = re.compile(r"[^\s()\"';,]+")


def names_in_code(
    worlds: Iterable[str], folder: Path, modules: Iterable[str] = ()
) -> Mapping[str, Path]:
    """Return the names in the code of worlds, each with the file that uses it.

    Args:
        worlds: the names of worlds, or `module:Class`.
        folder: the folder of modules that are not installed.
        modules: further modules, for example the `world-modules` of a configuration.
    """
    found: dict[str, Path] = {}
    for module in dict.fromkeys([*map(_module, worlds), *modules]):
        for file in _files(module, folder):
            for name in _names(file):
                found.setdefault(name, file)
    return found


def _module(world: str) -> str:
    """Return the module of a world; empty if the world is unknown."""
    place = OWN.get(world) or world
    if ":" not in place:
        points = entry_points(group=GROUP).select(name=world)
        place = next((point.value for point in points), "")
    return place.partition(":")[0]


def _files(module: str, folder: Path) -> Iterator[Path]:
    """Yield the files of a module, and of its package if it is in a package."""
    path: list[str] | None = None
    for part in module.split(".") if module else ():
        spec = PathFinder.find_spec(part, path)
        if spec is None and path is None:
            spec = PathFinder.find_spec(part, [str(folder)])
        if spec is None:
            return
        path = list(spec.submodule_search_locations or ())
        origin = spec.origin
    if not module:
        return
    if path:
        for place in path:
            yield from sorted(Path(place).rglob("*.py"))
    elif origin:
        yield Path(origin)


def _names(file: Path) -> Iterator[str]:
    """Yield the names in a file; a file that is not Python has none."""
    try:
        tree = ast.parse(read_text(file))
    except (LoadError, SyntaxError, ValueError, RecursionError):
        return
    docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            yield node.name.replace("_", "-")
        if isinstance(node, ast.Constant) and id(node) not in docs:
            text = node.value if isinstance(node.value, str) else ""
            yield from _WORD.findall(text.lower())
