"""Count the lines of logic in rapc, its import chains and the names it offers to users.

    python -m bench.structure lines            # lines of logic by package
    python -m bench.structure imports          # cycles; longest chain within a package
    python -m bench.structure surface > before.json
    python -m bench.structure surface --against before.json

A line of logic is no docstring, comment, blank line, import, `__all__` or `def` header.
The surface is all that users type or read by name: commands with their options, rules,
events with their fields, commands of the debugger, public Python names, worlds.
"""

from __future__ import annotations

import argparse
import ast
import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import msgspec

PACKAGE = Path(__file__).resolve().parent.parent / "rapc"


def lines_of_logic(source: str) -> int:
    """Return how many lines of a module are logic."""
    other: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(
            node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
        ):
            first = node.body[0] if node.body else None
            if (
                isinstance(first, ast.Expr)
                and isinstance(first.value, ast.Constant)
                and isinstance(first.value.value, str)
            ):
                other.update(range(first.lineno, (first.end_lineno or 0) + 1))
            if first and isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                other.update(range(node.lineno, first.lineno))
        elif isinstance(node, ast.Import | ast.ImportFrom) or (
            isinstance(node, ast.Assign)
            and any(isinstance(n, ast.Name) and n.id == "__all__" for n in node.targets)
        ):
            other.update(range(node.lineno, (node.end_lineno or 0) + 1))
    return sum(
        bool(text) and not text.startswith("#") and number not in other
        for number, text in enumerate(map(str.strip, source.splitlines()), 1)
    )


def print_lines() -> None:
    """Print the lines of logic of each package, and their sum."""
    found: Counter[str] = Counter()
    for path in PACKAGE.rglob("*.py"):
        folders = path.relative_to(PACKAGE).parts[:-1][:2]
        found["/".join(("rapc", *folders))] += lines_of_logic(path.read_text("utf-8"))
    for package, lines in found.most_common():
        print(f"{lines:6} {package}")
    print(f"{sum(found.values()):6} together")


def imports() -> dict[str, set[str]]:
    """Return for each module of rapc the modules that it imports outside functions."""
    modules = {_name(path): path for path in PACKAGE.rglob("*.py")}
    return {
        name: {
            target
            for target in _imported(ast.parse(path.read_text("utf-8")), modules)
            if target != name
        }
        for name, path in modules.items()
    }


def _name(path: Path) -> str:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _imported(tree: ast.Module, modules: dict[str, Path]) -> Iterator[str]:
    blocks = [node for node in tree.body if isinstance(node, ast.If)]
    for node in [*tree.body, *(one for block in blocks for one in block.body)]:
        if isinstance(node, ast.ImportFrom) and node.module in modules:
            for alias in node.names:
                full = f"{node.module}.{alias.name}"
                yield full if full in modules else node.module
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)


def chains(graph: dict[str, set[str]], package: str) -> list[str]:
    """Return the longest chain of imports between the parts of a package.

    A part is a module of the package or one of its folders.

    Raises:
        RecursionError: if the parts import each other in a cycle.
    """
    prefix = package + "."
    depth = prefix.count(".") + 1

    def part(module: str) -> str:
        return ".".join(module.split(".")[:depth])

    arrows: dict[str, set[str]] = {}
    for module, targets in graph.items():
        if module.startswith(prefix):
            own = arrows.setdefault(part(module), set())
            own |= {part(t) for t in targets if t.startswith(prefix)} - {part(module)}

    @cache
    def longest(name: str) -> list[str]:
        below = [longest(target) for target in sorted(arrows.get(name, ()))]
        return [name, *max(below, key=len, default=[])]

    return max([longest(name) for name in sorted(arrows)], key=len)


def print_imports() -> None:
    """Print the modules that import each other in a cycle, and the longest chains."""
    graph = imports()
    for name in sorted(graph):
        if name in _reached(graph, graph[name]):
            print(f"in a cycle: {name}")
    for package in ("rapc", "rapc.runtime", "rapc.analysis", "rapc.debug"):
        found = chains(graph, package)
        print(f"{package}: {len(found)} parts: {' > '.join(found)}")


def _reached(graph: dict[str, set[str]], names: set[str]) -> set[str]:
    found: set[str] = set()
    left = list(names)
    while left:
        name = left.pop()
        if name not in found:
            found.add(name)
            left += graph.get(name, ())
    return found


def surface() -> dict[str, list[str]]:
    """Return the names that users type or read, by kind."""
    import rapc  # noqa: PLC0415  # the other commands read texts alone
    from rapc.cli.main import cli  # noqa: PLC0415

    kinds = [
        one
        for one in vars(rapc.events).values()
        if isinstance(one, type) and issubclass(one, rapc.events.Event)
    ]
    rules = json.loads(_answer("rule", "--all", "--format", "json"))
    return {
        "public": sorted(name for name in dir(rapc) if not name.startswith("_")),
        "events": sorted({f"{k.__name__} {' '.join(_fields(k))}" for k in kinds}),
        "commands": sorted(_commands(cli)),
        "rules": sorted(f"{rule['code']} {rule['name']}" for rule in rules),
        "debugger": sorted(set(re.findall(r"^ *(:[a-z-]+)", _answer(*_HELP), re.M))),
        "worlds": sorted(_answer("worlds").splitlines()),
    }


_HELP = ("repl", "-c", ":help")


def _answer(*args: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", "from rapc.cli.main import main; main()", *args],
        check=True,
        capture_output=True,
        text=True,
    )
    return done.stdout


def _fields(event: type[msgspec.Struct]) -> list[str]:
    return sorted(field.encode_name for field in msgspec.structs.fields(event))


def _commands(command: object) -> Iterator[str]:
    import click  # noqa: PLC0415

    left: list[tuple[str, click.Command]] = [("rapc", command)]  # type: ignore[list-item]
    while left:
        path, one = left.pop()
        for option in one.params:
            yield " ".join((path, *option.opts, *option.secondary_opts))
        if isinstance(one, click.Group):
            context = click.Context(one)
            for name in one.list_commands(context):
                found = one.get_command(context, name)
                assert found is not None
                left.append((f"{path} {name}", found))


def print_surface(against: Path | None) -> None:
    """Print the surface as JSON, or what differs from another one."""
    found = surface()
    if against is None:
        print(json.dumps(found, indent=1))
        return
    before = json.loads(against.read_text("utf-8"))
    lost = False
    for kind, names in found.items():
        for name in sorted(set(before[kind]) - set(names)):
            lost = True
            print(f"- {kind}: {name}")
        for name in sorted(set(names) - set(before[kind])):
            print(f"+ {kind}: {name}")
    sys.exit(lost)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("lines", "imports", "surface"))
    parser.add_argument("--against", type=Path, help="an earlier surface")
    asked = parser.parse_args()
    if asked.what == "lines":
        print_lines()
    elif asked.what == "imports":
        print_imports()
    else:
        print_surface(asked.against)


if __name__ == "__main__":
    main()
