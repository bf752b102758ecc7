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
import tempfile
from collections.abc import Mapping
from pathlib import Path

from bench.paired import CHECKOUT, LIMIT, MARK, Side, built, interpreter

WORKS: Mapping[str, tuple[str, int, int]] = {
    "W1 lists": ("text to lists and atoms", 1, 3),
    "W1 nodes": ("text to typed nodes", 1, 3),
    "W1 library": ("text to a library to be run", 1, 2),
    "W2 first": ("first answers, 1,000 items", 2, 6),
    "W2 all": ("all answers, 1,000 items", 2, 6),
    "W3": ("firings among 200 monitors", 2, 5),
    "W3 kept": ("firings, events kept", 2, 5),
    "W4": ("a tree of tasks, 6 levels", 1, 3),
    "W4 inputs": ("the same, depth as input", 1, 3),
    "W4 kept": ("the same, events kept", 1, 2),
    "monitors 1": ("firings stepped one by one, 100 asleep", 1, 4),
    "agenda 0": ("steps in order, 9,841 tasks", 0, 1),
    "agenda 2": ("steps in any order, 11,111 tasks", 0, 1),
    "queries 0": ("first answers, site bound, 100 items", 5, 20),
    "queries 3": ("all answers, crowded place, 100 items", 5, 20),
    "queries 4": ("assert and erase, `color` of a new item", 2, 6),
    "queries 5": ("assert and erase, `location` of a new item", 2, 6),
    "chapter6": ("a still run of the truck", 0, 1),
}
"""What each piece of work is, and the two numbers of repetitions."""

_COUNTED = re.compile(r"I\s+refs:\s+([\d,]+)")


def _count(side: Side, work: str, times: int) -> int:
    """Count the instructions of a process that does a piece of work so often.

    Raises:
        CalledProcessError: if it fails.
    """
    script = str(CHECKOUT / "bench" / "counted.py")
    valgrind = ("valgrind", "--tool=cachegrind", "--cache-sim=no")
    command = (*valgrind, "--cachegrind-out-file=/dev/null", side.python, "-P", script)
    told = subprocess.run(
        [*command, work, str(times)],
        cwd=side.tree,
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
    subprocess.run(  # writes the bytecode
        [side.python, "-P", script, work, "0"],
        cwd=side.tree,
        env=side.environment(),
        check=True,
    )
    spent = _count(side, work, more) - _count(side, work, fewer)
    return spent // (more - fewer)


def main() -> None:
    """Read the command line, count, and print."""
    parser = argparse.ArgumentParser(description="Two checkouts, in instructions.")
    parser.add_argument("work", nargs="*", help=f"some of: {', '.join(WORKS)}")
    parser.add_argument("--against", type=Path, required=True, help="other checkout")
    parser.add_argument("--compiled", action="store_true", help="with compiled modules")
    args = parser.parse_args()
    unknown = set(args.work) - set(WORKS)
    if unknown:
        parser.error(f"no such work: {', '.join(sorted(unknown))}")
    if not (args.against / "bench" / "run.py").is_file():
        parser.error("--against takes a checkout of rapc")
    with tempfile.TemporaryDirectory() as scratch:
        sides = []
        for name, checkout in (("theirs", args.against.resolve()), ("ours", CHECKOUT)):
            place = Path(scratch, name)
            tree = built(checkout, place) if args.compiled else checkout
            bytecode = Path(scratch, f"{name}.pyc")
            sides.append(Side(interpreter(checkout), tree, bytecode))
        print("| work | what | theirs | ours | ratio | |")
        print("|---|---|---:|---:|---:|---|")
        for work in args.work or WORKS:
            theirs, ours = (counted(side, work) for side in sides)
            ratio = ours / theirs
            mark = MARK if ratio > LIMIT else ""
            millions = " | ".join(f"{n / 1e6:,.3f} M" for n in (theirs, ours))
            cells = f"{work} | {WORKS[work][0]} | {millions} | {ratio:.3f} | {mark}"
            print(f"| {cells} |", flush=True)


if __name__ == "__main__":
    main()
