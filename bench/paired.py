"""This checkout beside another one: every bench in both, in turn, and the ratios.

    python -m bench.paired --against PATH [--rounds N] [--compiled] [NAME]...

Each checkout runs its own benches, so the other may be of any age; both with one
interpreter, that of the other's `.venv` if it has one: what is installed beside rapc
costs time at start. Both read the other's `stdlib`, for a library that has grown is no
slowness; only a run has its own, which fits its world. The two take turns, and who
begins changes with each round; a ratio is that of times, ours to theirs, the median
over the rounds. Above 1.05 is slower than noise on a quiet machine explains: such rows
are marked. With `--compiled` both are built with compiled modules first, which takes a
C compiler and a minute each. Three rounds take some eight minutes.
"""

from __future__ import annotations

import argparse
import os
import re
import statistics
import subprocess
import sys
import tempfile
import zipfile
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import msgspec

from bench.child import take
from bench.common import INPUTS, short

CHECKOUT = Path(__file__).parents[1]

BENCHES: Mapping[str, Sequence[str]] = {
    "parse": (),
    "compiled": (),
    "queries": (),
    "monitors": (),
    "agenda": (),
    "order": (),
    "chapter6": ("--quick",),
    "memory": ("--quick",),
}
"""The benches, and with which of them a small size must do.

That of saved runs is left out: older checkouts cannot save a run.
"""

COMMANDS: Mapping[str, Sequence[str]] = {
    "rapc --help": ("--help",),
    "rapc check stdlib": ("check", "stdlib"),
    "rapc run, an order": (
        *("run", "examples/rock-order.rap", "--world", "truck", "--quiet"),
        *("--task", "(fill-order red 4 factory-1)"),
    ),
}
TIMES = 7
"""How often each command is run in a round."""

LIMIT = 1.05
MARK = "slower"

_ROW = re.compile(
    r"^\| ([^|]+) \| ([^|]+) \| ([^|]+) \| ([\d.,e-]+) \| ([^|]+) \|$", re.M
)

Key = tuple[str, str, str, str]
"""Bench, what, size and unit of a row."""

Figures = dict[Key, list[float]]
"""What was measured of each row, a figure for each round."""


class Side(msgspec.Struct, frozen=True):
    """A checkout, or what is built of it: who runs the benches, and where."""

    python: str
    tree: Path
    bytecode: Path
    #: The checkout that has the libraries which both sides read.
    inputs: Path

    def command(self) -> tuple[str, ...]:
        """What begins the command `rapc`, as its installed script does."""
        own = self.tree / "rapc" / "cli" / "start.py"
        module = "start" if own.exists() else "main"
        run = f"from rapc.cli.{module} import main; main()"
        return (self.python, "-P", "-c", run)

    def environment(self) -> dict[str, str]:
        """The environment in which `tree` has the rapc that is imported."""
        kept = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        return {
            **kept,
            "PYTHONPATH": str(self.tree),
            "PYTHONPYCACHEPREFIX": str(self.bytecode),
            "PYTHONHASHSEED": "0",
            INPUTS: str(self.inputs),
        }


def interpreter(checkout: Path) -> str:
    """Return the Python of a checkout's own environment, or the one that runs this."""
    own = checkout / ".venv" / "bin" / "python"
    return str(own) if own.exists() else sys.executable


def built(checkout: Path, folder: Path) -> Path:
    """Build a checkout with compiled modules; return a tree that has them.

    Raises:
        CalledProcessError: if it cannot be built.
    """
    folder.mkdir()
    command = [sys.executable, "-m", "build", "--outdir", str(folder), str(checkout)]
    environment = {**os.environ, "HATCH_BUILD_HOOK_ENABLE_MYPYC": "1"}
    subprocess.run(command, env=environment, stdout=subprocess.DEVNULL, check=True)
    [wheel] = folder.glob("*.whl")
    tree = folder / "tree"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tree)
    for name in ("bench", "tests", "stdlib", "examples"):
        (tree / name).symlink_to(checkout / name)
    return tree


def both(other: Path, scratch: Path, *, compiled: bool) -> list[Side]:
    """Return another checkout and this one, to be run alike; files go to `scratch`.

    Raises:
        CalledProcessError: if one is to be `compiled` and cannot be built.
    """
    sides = []
    for name, checkout in (("theirs", other), ("ours", CHECKOUT)):
        tree = built(checkout, scratch / name) if compiled else checkout
        sides.append(Side(interpreter(other), tree, scratch / f"{name}.pyc", other))
    return sides


def read_rows(printed: str) -> dict[Key, float]:
    """Return the figures in the rows of a table, as `bench.run` prints it."""
    return {
        (bench, what, size, unit): float(figure.replace(",", ""))
        for bench, what, size, figure, unit in _ROW.findall(printed)
    }


def _of_bench(name: str, more: Sequence[str]) -> Callable[[Side], dict[Key, float]]:
    def measure(side: Side) -> dict[Key, float]:
        return read_rows(_run(side, "-m", "bench.run", name, *more))

    return measure


def _of_adapter(side: Side) -> dict[Key, float]:
    script = str(CHECKOUT / "bench" / "adapter_rows.py")
    adapter = str(side.tree / "bench" / "rapc_adapter.py")
    return read_rows(_run(side, "-P", script, adapter))


def _run(side: Side, *words: str) -> str:
    """Run Python in a tree and return what it prints.

    Raises:
        CalledProcessError: if it fails; its standard error is shown.
    """
    return subprocess.run(
        [side.python, *words],
        cwd=side.tree,
        env=side.environment(),
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    ).stdout


def _commands(sides: Sequence[Side]) -> Iterator[tuple[Side, dict[Key, float]]]:
    """Run each command in both, one after the other, several times; give medians."""
    taken: dict[tuple[Side, Key], list[float]] = defaultdict(list)
    here = Path.cwd()
    for name, words in COMMANDS.items():
        for turn in range(TIMES + 1):
            for side in sides:
                os.chdir(side.inputs)
                used = take([*side.command(), *words], side.environment())
                if turn:  # the first time writes the bytecode
                    taken[side, ("start", name, "", "s")].append(used["cpu"])
                    taken[side, ("start", name, "peak", "MB")].append(used["peak"])
    os.chdir(here)
    for (side, key), values in taken.items():
        yield side, {key: statistics.median(values)}


def measure(sides: Sequence[Side], rounds: int, wanted: Sequence[str]) -> list[Figures]:
    """Measure both sides in turn, `rounds` times, and return the figures of each."""
    found: list[Figures] = [defaultdict(list) for _ in sides]
    works = {name: _of_bench(name, more) for name, more in BENCHES.items()}
    works["W"] = _of_adapter
    for number in range(rounds):
        order = sides if number % 2 == 0 else sides[::-1]
        told: list[tuple[Side, dict[Key, float]]] = []
        for name in (name for name in works if not wanted or name in wanted):
            print(f"round {number + 1}: {name}", file=sys.stderr, flush=True)
            told += [(side, works[name](side)) for side in order]
        if not wanted or "start" in wanted:
            print(f"round {number + 1}: start", file=sys.stderr, flush=True)
            told += _commands(order)
        for side, figures in told:
            for key, value in figures.items():
                found[sides.index(side)][key].append(value)
    return found


def ratio(unit: str, ours: Sequence[float], theirs: Sequence[float]) -> float | None:
    """Return the median ratio of times, ours to theirs; None if there is none.

    A rate, by the second, is turned round: above 1 is slower or more, always.
    """
    if not all(ours) or not all(theirs):
        return None
    found = statistics.median(a / b for a, b in zip(ours, theirs, strict=True))
    return 1 / found if unit.endswith("/s") else found


def add_older(ours: Figures, theirs: Figures) -> None:
    """Hold the passes of fewer rules against all that an older checkout has."""
    for key in ours.keys() - theirs.keys():
        bench, what, size, unit = key
        older = theirs.get((bench, ALL_PASSES, size, unit))
        if what in FEWER_PASSES and older is not None:
            theirs[key] = older


ALL_PASSES = "all passes over it"
FEWER_PASSES = (
    "the passes of the 67 oldest rules over it",
    "the passes that find errors over it",
)


def table(ours: Figures, theirs: Figures) -> Iterator[str]:
    """The rows of both as a Markdown table, and a line that sums them up."""
    yield "| bench | what | size | theirs | ours | unit | ratio | |"
    yield "|---|---|---|---:|---:|---|---:|---|"
    slower = 0
    for key in (key for key in ours if key in theirs):
        bench, what, size, unit = key
        found = ratio(unit, ours[key], theirs[key])
        mark = MARK if found is not None and found > LIMIT else ""
        slower += bool(mark)
        medians = (short(statistics.median(each[key])) for each in (theirs, ours))
        told = "" if found is None else f"{found:.3f}"
        cells = (bench, what, size, *medians, unit, told, mark)
        yield f"| {' | '.join(cells)} |"
    yield ""
    for name, only in (
        ("ours", ours.keys() - theirs),
        ("theirs", theirs.keys() - ours),
    ):
        for key in sorted(only):
            yield f"only {name}: {', '.join(part for part in key if part)}"
    ratios = _ratios(ours, theirs)
    yield f"{slower} of {len(ratios)} rows are above {LIMIT}; median {_middle(ratios)}"


def _ratios(ours: Figures, theirs: Figures) -> list[float]:
    pairs = ((key, ours[key], theirs[key]) for key in ours if key in theirs)
    found = (ratio(key[3], mine, other) for key, mine, other in pairs)
    return [each for each in found if each is not None]


def _middle(values: Iterable[float]) -> str:
    every = list(values)
    return f"{statistics.median(every):.3f}" if every else "none"


def main() -> None:
    """Read the command line, measure, and print."""
    parser = argparse.ArgumentParser(description="Two checkouts, measured in turn.")
    names = [*BENCHES, "W", "start"]
    parser.add_argument("bench", nargs="*", help=f"some of: {', '.join(names)}")
    parser.add_argument("--against", type=Path, required=True, help="other checkout")
    parser.add_argument("--rounds", type=int, default=3, help="3 if not given")
    parser.add_argument("--compiled", action="store_true", help="with compiled modules")
    args = parser.parse_args()
    unknown = set(args.bench) - set(names)
    if unknown:
        parser.error(f"no such bench: {', '.join(sorted(unknown))}")
    if not (args.against / "bench" / "run.py").is_file() or args.rounds < 1:
        parser.error("--against takes a checkout of rapc, --rounds a number from 1")
    with tempfile.TemporaryDirectory() as scratch:
        sides = both(args.against.resolve(), Path(scratch), compiled=args.compiled)
        theirs, ours = measure(sides, args.rounds, args.bench)
    add_older(ours, theirs)
    for line in table(ours, theirs):
        print(line)


if __name__ == "__main__":
    main()
