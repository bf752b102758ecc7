"""Measure the tests of rapc: seeded one-line mutants of its code, killed or survived.

    python -m bench.mutants --count 200 --seed 1 --jobs 2
    python -m bench.mutants --tree ../before --count 200 --seed 1

A mutant is the code of rapc with one expression or statement changed. The tests of its
package (`TESTS`) run against it; a mutant that no test fails for has survived. One that
takes three times as long as the code itself counts as killed. Mutants are made in git
worktrees of the last commit of `--tree`, so the checkout stays as it is, and an older
checkout is measured with its own tests.

`bench.mutation` changes RAP libraries in the same way, to measure the checker.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import os
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from itertools import count
from pathlib import Path
from queue import SimpleQueue

import msgspec

PACKAGES = ("rapc/analysis", "rapc/compiler", "rapc/runtime")
"""The packages that are mutated."""

TESTS: Mapping[str, tuple[str, ...]] = {
    "rapc/analysis": ("tests/analysis",),
    "rapc/compiler": ("tests/compiler", "tests/runtime"),
    "rapc/runtime": ("tests/runtime",),
    "rapc/runtime/memory": ("tests/memory", "tests/recognition", "tests/runtime"),
    "rapc/runtime/monitors": ("tests/runtime", "tests/reference"),
    "rapc/runtime/tasks": ("tests/runtime", "tests/reference"),
}
"""The folders of tests by package; the longest name that fits counts."""

SLOWER = 3
"""A mutant is killed when its tests take so many times as long as without it."""

LEAST = 30.0
"""It has so many seconds in any case."""

PASSED, FAILED, STOPPED = 0, 1, 2
"""Exit statuses of pytest: a test failed; the tests could not be collected."""


class Mutant(msgspec.Struct, frozen=True):
    """A piece of one line of a file, and what is put in its place."""

    file: str
    line: int
    #: The columns, in bytes.
    start: int
    end: int
    kind: str
    content: str

    def apply(self, source: str) -> str:
        """Return the source of the file with the mutant in it."""
        lines = source.encode().splitlines(keepends=True)
        line = lines[self.line - 1]
        lines[self.line - 1] = b"".join(
            (line[: self.start], self.content.encode(), line[self.end :])
        )
        return b"".join(lines).decode()


class Verdict(msgspec.Struct, frozen=True):
    """What became of a mutant."""

    mutant: Mutant
    survived: bool
    diff: str


_COMPARED: Mapping[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
_COMPUTED: Mapping[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Add,
    ast.BitOr: ast.BitAnd,
    ast.BitAnd: ast.BitOr,
}


def mutants(file: str, source: str) -> Iterator[Mutant]:
    """Yield the mutants of a module, each of them valid Python."""
    for node in _code(ast.parse(source)):
        for kind, target, changed in _changes(node):
            line, end = target.lineno, target.end_lineno
            if line == end and target.end_col_offset is not None:
                content = changed if isinstance(changed, str) else ast.unparse(changed)
                if isinstance(changed, ast.expr):
                    content = f"({content})"
                start, stop = target.col_offset, target.end_col_offset
                yield Mutant(file, line, start, stop, kind, content)


def _code(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes that run: no annotation, docstring, text or decorator."""
    yield node
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases", "type_comment"):
            continue
        for child in value if isinstance(value, list) else [value]:
            typing_only = (
                isinstance(child, ast.If)
                and isinstance(child.test, ast.Name)
                and child.test.id == "TYPE_CHECKING"
            )
            text = isinstance(child, ast.JoinedStr) or (
                isinstance(child, ast.Expr) and isinstance(child.value, ast.Constant)
            )
            if isinstance(child, ast.AST) and not (typing_only or text):
                yield from _code(child)


Change = tuple[str, ast.expr | ast.stmt, ast.expr | str]
"""The kind of a change, the node that is replaced, and what by."""


def _changes(node: ast.AST) -> Iterator[Change]:
    """Yield the changes of one node."""
    match node:
        case ast.Compare(ops=[op]) if type(op) in _COMPARED:
            flipped = ast.Compare(node.left, [_COMPARED[type(op)]()], node.comparators)
            yield "comparison", node, flipped
        case ast.BoolOp(op, values):
            other = ast.Or() if isinstance(op, ast.And) else ast.And()
            yield "and-or", node, ast.BoolOp(other, values)
        case ast.BinOp() if type(node.op) in _COMPUTED and not _is_text(node):
            changed = ast.BinOp(node.left, _COMPUTED[type(node.op)](), node.right)
            yield "operator", node, changed
        case ast.UnaryOp(op=ast.Not()):
            yield "negation", node, node.operand
        case ast.If() | ast.While() | ast.IfExp():
            yield "condition", node.test, ast.UnaryOp(ast.Not(), node.test)
        case ast.comprehension():
            for condition in node.ifs:
                yield "condition", condition, ast.UnaryOp(ast.Not(), condition)
        case ast.Constant(value=bool() as value):
            yield "constant", node, ast.Constant(not value)
        case ast.Constant(value=int() | float() as value):
            yield "constant", node, ast.Constant(value + 1)
        case ast.Constant(value=str() as value) if value and " " not in value:
            yield "constant", node, ast.Constant(value + "-x")
        case ast.Return(value=ast.expr() as value) if not _is_none(value):
            yield "result", value, ast.Constant(None)
        case ast.stmt() if _can_be_dropped(node):
            yield "statement", node, "pass"


def _can_be_dropped(node: ast.stmt) -> bool:
    """Whether the names that a statement binds are bound without it."""
    match node:
        case ast.Expr(value=ast.Call() | ast.Yield() | ast.YieldFrom()):
            return True
        case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]):
            return True
    dropped = (ast.AugAssign, ast.Break, ast.Continue, ast.Delete, ast.Raise)
    return isinstance(node, dropped)


def _is_none(node: ast.expr) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _is_text(node: ast.BinOp) -> bool:
    """Whether texts are put together, which has one operator alone."""
    sides = (node.left, node.right)
    return any(
        isinstance(side, ast.JoinedStr)
        or (isinstance(side, ast.Constant) and isinstance(side.value, str))
        for side in sides
    )


def chosen(tree: Path, number: int, seed: int) -> list[Mutant]:
    """Return so many mutants of a checkout, drawn by a seed, in the order of files."""
    found: list[Mutant] = []
    for package in PACKAGES:
        for path in sorted((tree / package).rglob("*.py")):
            name = path.relative_to(tree).as_posix()
            found += mutants(name, path.read_text(encoding="utf-8"))
    rng = random.Random(f"{seed}:mutants")
    drawn = rng.sample(range(len(found)), min(number, len(found)))
    return [found[index] for index in sorted(drawn)]


def folders_of(file: str) -> tuple[str, ...]:
    """Return the folders of the tests of a module."""
    package = max((name for name in TESTS if file.startswith(name + "/")), key=len)
    return TESTS[package]


class Copy:
    """A git worktree in which one mutant at a time is tried."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._writes = count(1)

    def run(self, tests: Sequence[str], limit: float | None = None) -> bool:
        """Return whether tests pass, within so many seconds.

        Raises:
            RuntimeError: if pytest could not run them.
        """
        folders = [name for name in tests if (self.folder / name).exists()]
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", *folders]
        env = {**os.environ, "PYTHONPATH": str(self.folder)}
        process = subprocess.Popen(
            command,
            cwd=self.folder,
            env=env,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        try:
            told, _ = process.communicate(timeout=limit)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            process.communicate()
            return False
        if process.returncode not in (PASSED, FAILED, STOPPED):
            raise RuntimeError(f"pytest cannot run {' '.join(folders)}:\n{told}")
        return process.returncode == PASSED

    def try_mutant(self, mutant: Mutant, limit: float) -> Verdict:
        """Run the tests of a mutant's package against it."""
        path = self.folder / mutant.file
        before = path.read_text(encoding="utf-8")
        after = mutant.apply(before)
        try:
            self._write(path, after)
            survived = self.run(folders_of(mutant.file), limit)
        finally:
            self._write(path, before)
        lines = difflib.unified_diff(
            before.splitlines(), after.splitlines(), mutant.file, mutant.file, "", "", 1
        )
        return Verdict(mutant, survived, "\n".join(line.rstrip() for line in lines))

    def _write(self, path: Path, text: str) -> None:
        """Write a module with a time of its own, so that no old bytecode serves it."""
        path.write_text(text, encoding="utf-8")
        os.utime(path, (1_000_000_000 + 10 * next(self._writes),) * 2)


@contextmanager
def copies(tree: Path, number: int) -> Iterator[list[Copy]]:
    """Make worktrees of the last commit of a checkout, and remove them in the end."""
    git = ["git", "-C", str(tree), "worktree"]
    with tempfile.TemporaryDirectory() as place, ExitStack() as stack:
        made = []
        for index in range(number):
            folder = Path(place) / f"copy-{index}"
            _command([*git, "add", "-q", "--detach", str(folder), "HEAD"])
            stack.callback(_command, [*git, "remove", "--force", str(folder)])
            made.append(Copy(folder))
        yield made


def _command(command: Sequence[str]) -> None:
    subprocess.run(command, check=True)


def limits(copy: Copy, groups: set[tuple[str, ...]]) -> dict[tuple[str, ...], float]:
    """Return how long the tests of mutants may take, by their folders.

    Raises:
        RuntimeError: if tests fail without any mutant.
    """
    found: dict[tuple[str, ...], float] = {}
    for tests in sorted(groups):
        start = time.monotonic()
        if not copy.run(tests):
            raise RuntimeError(f"{' '.join(tests)} fail without a mutant")
        found[tests] = max(LEAST, SLOWER * (time.monotonic() - start))
    return found


def measure(
    tree: Path, drawn: Sequence[Mutant], jobs: int, tell: Callable[[Verdict], None]
) -> list[Verdict]:
    """Try mutants of a checkout, and tell the verdicts in their order."""
    verdicts: list[Verdict] = []
    with copies(tree, jobs) as made, ThreadPoolExecutor(jobs) as pool:
        free: SimpleQueue[Copy] = SimpleQueue()
        allowed = limits(made[0], {folders_of(mutant.file) for mutant in drawn})
        for copy in made:
            free.put(copy)

        def judge(mutant: Mutant) -> Verdict:
            copy = free.get()
            try:
                return copy.try_mutant(mutant, allowed[folders_of(mutant.file)])
            finally:
                free.put(copy)

        for verdict in pool.map(judge, drawn):
            tell(verdict)
            verdicts.append(verdict)
    return verdicts


def _tell(verdict: Verdict) -> None:
    word, mutant = "survived" if verdict.survived else "killed", verdict.mutant
    print(f"{word} {mutant.file}:{mutant.line} {mutant.kind}\n{verdict.diff}\n")
    sys.stdout.flush()


def main() -> None:
    """Try mutants, and print how many the tests killed."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.mutants", description=__doc__
    )
    here = Path(__file__).resolve().parent.parent
    parser.add_argument("--tree", type=Path, default=here, help="the checkout")
    parser.add_argument("--count", type=int, default=200, help="how many mutants")
    parser.add_argument("--seed", type=int, default=1, help="which of them")
    parser.add_argument("--jobs", type=int, default=2, help="how many at a time")
    given = parser.parse_args()
    tree = given.tree.resolve()
    verdicts = measure(tree, chosen(tree, given.count, given.seed), given.jobs, _tell)
    killed, tried = Counter[str](), Counter[str]()
    for verdict in verdicts:
        package = next(p for p in PACKAGES if verdict.mutant.file.startswith(p + "/"))
        for group in (package, verdict.mutant.kind, "together"):
            tried[group] += 1
            killed[group] += not verdict.survived
    for group, number in sorted(tried.items(), key=lambda item: item[0] == "together"):
        share = round(100 * killed[group] / number)
        print(f"{killed[group]:5} of {number:4} killed  {share:3} %  {group}")


if __name__ == "__main__":
    main()
