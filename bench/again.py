"""What a check costs after nothing, or one file, has changed: seconds and megabytes.

    python -m bench.again [--raps N] [--rounds N]

The library of `bench.parse`, in files of a hundred RAPs, is checked by `rapc check` as
a command: the start of Python is part of it. Seconds are those of the processor, of
which the least of some rounds counts; megabytes are the most that a check held.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

import msgspec

from bench.parse import DECLARATIONS, DEFINITION

IN_A_FILE = 100
"""How many RAPs stand in a file."""

AGENDA = "(define-agenda day (task (pickup-2 left-arm box) :priority 2))\n"
"""What stands behind the declarations."""

EDITS: Mapping[str, tuple[int, str, str]] = {
    "a number in a context": (4051, "(> ?size {n})", "(> ?size 7)"),
    "the same, of what others ask for": (51, "(> ?size {n})", "(> ?size 7)"),
    "another step": (4051, "(pickup-{half} ", "(pickup-7 "),
    "another goal": (4051, "(arm-holding ?arm ?thing)", "(at ?arm)"),
    "a slip: a variable unbound": (4051, "(t1 (go-to ?place)", "(t1 (go-to ?spot)"),
    "another goal, of what many ask for": (
        51,
        "(arm-holding ?arm ?thing)",
        "(at ?arm)",
    ),
    "a RAP that is not there": (4051, "(pickup-{half} ", "(pickup-none "),
    "a parenthesis is missing": (4051, "(task-net", "task-net"),
    "the priority of a task": (0, ":priority 2", ":priority 4"),
    "a declaration": (0, "(okay road-closed)", "(okay road-closed lost)"),
}
"""Changes: in which RAP, or in the declarations, and what for what."""


class Cost(msgspec.Struct, frozen=True):
    """What one check took."""

    seconds: float
    megabytes: float


def measure(raps: int, rounds: int) -> Iterator[tuple[str, Cost]]:
    """Yield what is checked with what it takes at least.

    Args:
        raps: how many RAPs the library has.
        rounds: how often each check is made.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write(folder / "lib", raps)
        yield (
            "nothing is kept",
            _least([_check(folder, "--no-cache") for _ in range(rounds)]),
        )
        _check(folder)
        yield "nothing has changed", _least([_check(folder) for _ in range(rounds)])
        for what, (number, before, after) in EDITS.items():
            if number < raps:
                costs = [_edited(folder, number, before, after) for _ in range(rounds)]
                yield what, _least(costs)


def _write(folder: Path, raps: int) -> None:
    folder.mkdir()
    (folder / "a.rap").write_text(DECLARATIONS + AGENDA, encoding="utf-8")
    for first in range(1, raps + 1, IN_A_FILE):
        numbers = range(first, min(first + IN_A_FILE, raps + 1))
        forms = [DEFINITION.format(n=n, other=n // 2) for n in numbers]
        _file(folder, first).write_text("".join(forms), encoding="utf-8")


def _file(folder: Path, number: int) -> Path:
    return folder / f"p{(number - 1) // IN_A_FILE:03}.rap"


def _edited(folder: Path, number: int, before: str, after: str) -> Cost:
    """Make a change, check, and take the change back."""
    lib = folder / "lib"
    file = _file(lib, number) if number else lib / "a.rap"
    text = file.read_text(encoding="utf-8")
    at = text.index(f"(pickup-{number} ") if number else 0
    was = before.format(n=number, half=number // 2)
    changed = text[:at] + text[at:].replace(was, after, 1)
    if changed == text:
        raise ValueError(f"nothing is changed by {after}")
    file.write_text(changed, encoding="utf-8")
    cost = _check(folder)
    file.write_text(text, encoding="utf-8")
    _check(folder)
    return cost


def _check(folder: Path, *options: str) -> Cost:
    start = "from rapc.cli.start import main; main()"
    command = [sys.executable, "-c", start, "check", "-q", *options, "lib"]
    kept = {"RAPC_CACHE_DIR": str(folder / "kept")}
    environment = {**os.environ, **kept, "PYTHONPYCACHEPREFIX": str(folder / "pyc")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    process = subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.DEVNULL
    )
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1):
        raise ValueError(f"the check ended with {process.returncode}")
    return Cost(used.ru_utime + used.ru_stime, used.ru_maxrss / 1000)


def _least(costs: list[Cost]) -> Cost:
    return Cost(
        min(cost.seconds for cost in costs), max(cost.megabytes for cost in costs)
    )


def main() -> None:
    """Print a row for each change."""
    parser = argparse.ArgumentParser(prog="python -m bench.again")
    parser.add_argument("--raps", type=int, default=5000)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    for what, cost in measure(given.raps, given.rounds):
        print(f"{what:36} {cost.seconds:6.2f} s {cost.megabytes:6.0f} MB")


if __name__ == "__main__":
    main()
