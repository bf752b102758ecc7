"""This checkout beside another one, in instructions: what no other load can disturb.

    python -m bench.instructions --against PATH [--compiled] [WORK]...

Valgrind counts the instructions of the processor that a piece of work takes in each of
the two; each counts twice, with fewer and with more repetitions, and the difference is
that of the work alone. So the ratio is the same whatever else the machine does, though
a count takes some fifty times as long as the work. Neither checkout may be edited
meanwhile: Python would compile what has changed within one of the counts. Waiting for
memory is not counted: for that there is `bench.paired`, on a machine that does nothing
else.
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import msgspec

from bench.paired import CHECKOUT, LIMIT, MARK, Side, both
from bench.paired import COMMANDS as COMMANDS_TIMED

WORKS: Mapping[str, tuple[str, int, int]] = {
    "W1 lists": ("text to lists and atoms", 1, 3),
    "W1 nodes": ("text to typed nodes", 1, 3),
    "W1 library": ("text to a library to be run", 1, 2),
    "parse 2": ("text to linked library, 100 RAPs", 1, 3),
    "parse 3": ("all passes over it", 1, 3),
    "passes oldest": ("the passes of the 67 oldest rules", 1, 3),
    "passes errors": ("the passes that find errors", 1, 3),
    "W2 first": ("first answers, 1,000 items", 2, 6),
    "W2 all": ("all answers, 1,000 items", 2, 6),
    "W3": ("firings among 200 monitors", 2, 5),
    "W3 kept": ("firings, events kept", 2, 5),
    "W3 written": ("firings, events written", 2, 5),
    "W4": ("a tree of tasks, 6 levels", 1, 3),
    "W4 inputs": ("the same, depth as input", 1, 3),
    "W4 kept": ("the same, events kept", 1, 2),
    "W4 written": ("the same, events written", 1, 2),
    "monitors 1": ("firings stepped one by one, 100 asleep", 1, 4),
    "agenda 0": ("steps in order, 9,841 tasks", 0, 1),
    "agenda 1": ("the same, traced as JSON", 0, 1),
    "agenda 2": ("steps in any order, 11,111 tasks", 0, 1),
    "queries 0": ("first answers, site bound, 100 items", 5, 20),
    "queries 3": ("all answers, crowded place, 100 items", 5, 20),
    "queries 4": ("assert and erase, `color` of a new item", 2, 6),
    "queries 5": ("assert and erase, `location` of a new item", 2, 6),
    "compiled 1": ("read a compiled library, 100 RAPs", 2, 12),
    "compiled 2": ("the same, and each RAP", 2, 6),
    "compiled 4": ("read a compiled library, stdlib/truck", 2, 12),
    "compiled 5": ("the same, and each RAP", 2, 6),
    "memory alike": ("recognise among 100 drums", 0, 1),
    "memory different": ("the same, all different", 0, 1),
    "order": ("an order of four rocks", 0, 2),
    "chapter6": ("a still run of the truck", 0, 1),
}
"""What each piece of work is, and the two numbers of repetitions."""

COMMANDS: Mapping[str, tuple[str, Sequence[str]]] = {
    "help": ("`rapc --help`", ("--help",)),
    "check": ("`rapc check` of one RAP", ("check", "one.rap")),
    "check stdlib": ("`rapc check stdlib`", ("check", "stdlib")),
    "run": ("`rapc run`, an order", COMMANDS_TIMED["rapc run, an order"]),
}
"""Commands that are counted whole, Python's own start among it, in one environment."""

ONE_RAP = """\
(declare-memory-property ready (?state) unknown "Whether all is ready.")
(declare-primitive nothing () (okay))
(define-rap (begin)
  (succeed (ready yes))
  (method
    (context (ready no))
    (primitive (nothing))))
"""
"""The file that `rapc check` reads."""

_COUNTED = re.compile(r"I\s+refs:\s+([\d,]+)")


def _count(side: Side, command: Sequence[str], folder: Path) -> int:
    """Count the instructions of a command that is run in a folder.

    Raises:
        CalledProcessError: if it fails.
    """
    valgrind = ("valgrind", "--tool=cachegrind", "--cache-sim=no")
    told = subprocess.run(
        [*valgrind, "--cachegrind-out-file=/dev/null", *command],
        cwd=folder,
        env=side.environment(),
        capture_output=True,
        text=True,
        check=True,
    ).stderr
    found = _COUNTED.search(told)
    assert found is not None, told
    return int(found[1].replace(",", ""))


def counted(side: Side, work: str) -> int:
    """Return how many instructions a piece of work takes in a checkout."""
    _, fewer, more = WORKS[work]
    script = str(CHECKOUT / "bench" / "counted.py")
    run = (side.python, "-P", script, work)
    # The first writes the bytecode.
    subprocess.run([*run, "0"], cwd=side.tree, env=side.environment(), check=True)
    twice = [_count(side, (*run, str(times)), side.tree) for times in (more, fewer)]
    return (twice[0] - twice[1]) // (more - fewer)


def of_command(side: Side, words: Sequence[str]) -> int:
    """Return how many instructions `rapc` takes when its bytecode is at hand."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "one.rap").write_text(ONE_RAP, encoding="utf-8")
        for name in ("stdlib", "examples"):
            Path(folder, name).symlink_to(side.inputs / name)
        here = msgspec.structs.replace(side, python=sys.executable)
        return [_count(here, (*here.command(), *words), Path(folder)) for _ in "ab"][1]


def rows(sides: Sequence[Side], wanted: Sequence[str]) -> Iterator[str]:
    """The rows of the table: what each piece of work takes, theirs and ours."""
    for work in wanted:
        if work in COMMANDS:
            what, words = COMMANDS[work]
            theirs, ours = (of_command(side, words) for side in sides)
        else:
            what = WORKS[work][0]
            theirs, ours = (counted(side, work) for side in sides)
        ratio = ours / theirs
        mark = MARK if ratio > LIMIT else ""
        millions = " | ".join(f"{n / 1e6:,.3f} M" for n in (theirs, ours))
        yield f"| {work} | {what} | {millions} | {ratio:.3f} | {mark} |"


def main() -> None:
    """Read the command line, count, and print."""
    parser = argparse.ArgumentParser(description="Two checkouts, in instructions.")
    every = (*WORKS, *COMMANDS)
    parser.add_argument("work", nargs="*", help=f"some of: {', '.join(every)}")
    parser.add_argument("--against", type=Path, required=True, help="other checkout")
    parser.add_argument("--compiled", action="store_true", help="with compiled modules")
    args = parser.parse_args()
    unknown = set(args.work) - set(every)
    if unknown:
        parser.error(f"no such work: {', '.join(sorted(unknown))}")
    if not (args.against / "bench" / "run.py").is_file():
        parser.error("--against takes a checkout of rapc")
    with tempfile.TemporaryDirectory() as scratch:
        sides = both(args.against.resolve(), Path(scratch), compiled=args.compiled)
        print("| work | what | theirs | ours | ratio | |")
        print("|---|---|---:|---:|---:|---|")
        for row in rows(sides, args.work or every):
            print(row, flush=True)


if __name__ == "__main__":
    main()
