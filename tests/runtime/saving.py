"""Runs of the truck that are saved on the way and taken up again, here and elsewhere.

    python -m tests.runtime.saving --points 1000

saves runs with enemies, demons and nine orders at that many random points, takes each
up in another run (a part of them in another process, with another hash seed), and
compares the rest of the trace byte for byte.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from time import perf_counter

import msgspec

from rapc.base.values import Atom
from rapc.compiler.program import Program
from rapc.events import Event
from rapc.library.loader import load
from rapc.runtime.events.trace import record
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest, read_task_request
from rapc.worlds.registry import build_world
from rapc.worlds.truck import TruckWorld

UNTIL = 3000
"""The time at which these runs are broken off."""

_STDLIB = Path(__file__).parents[2] / "stdlib" / "truck"

HARD: Sequence[Mapping[str, Atom | bool]] = (
    {},
    {"shuffle-interval": 8, "shuffle-efficiency": 100},
    {"shuffle-interval": 20, "enemy-interval": 150},
    {
        "shuffle-interval": 8,
        "shuffle-efficiency": 100,
        "shuffle-tools": True,
        "enemy-interval": 40,
    },
)
"""How hard the world is, by the seed modulo 4."""

_STANDING = (
    "(wake-up) :priority 9",
    "(fuel-up) :priority 4",
    "(watch-fuel) :priority 4 :background true",
    "(watch-surroundings) :priority 8 :background true",
    "(ready-weapon) :priority 3",
    "(handle-enemy-troops) :priority 6 :background true",
)

_encode = msgspec.json.Encoder().encode


@cache
def library() -> Program:
    """Return the truck's library."""
    return Program(load([_STDLIB]).library, "truck")


def tasks() -> Iterator[TaskRequest]:
    """The standing tasks of the truck, and nine orders."""
    yield from map(read_task_request, _STANDING)
    colors = (("red", 1), ("blue", 2), ("yellow", 3)) * 3
    for number, (color, factory) in enumerate(colors):
        goal = f"(fill-order {color} 4 factory-{factory})"
        yield read_task_request(f"{goal} :priority 2 :at {120 + 60 * number}")


class Truck:
    """A run of the truck, with the trace of all that happens in it."""

    def __init__(self, seed: int, saved: bytes | None = None) -> None:
        options: dict[str, Atom | bool] = {"fuel-spread": 0, **HARD[seed % 4]}
        world = build_world(TruckWorld, seed, options)
        self.run = Interpreter(library(), world, seed)
        self.trace: list[bytes] = []
        self.run.listen(self._write)
        if saved is not None:
            self.run.restore(saved)
            return
        for task in tasks():
            self.run.submit(task)

    def _write(self, event: Event) -> None:
        self.trace.append(_encode(record(event)))

    def finish(self) -> Truck:
        """Run to the end, and return this."""
        while self.run.now < UNTIL and self.run.step():
            pass
        return self

    def digest(self, start: int = 0) -> str:
        """Return the digest of the trace from a line on."""
        return hashlib.sha256(b"\n".join(self.trace[start:])).hexdigest()


def saved_at(seed: int, cycles: Sequence[int]) -> tuple[Truck, list[tuple[int, bytes]]]:
    """Return a whole run, and what it was saved as after so many cycles of it.

    With each save comes the number of lines that the trace had by then.
    """
    truck, saves, wanted = Truck(seed), [], set(cycles)
    cycle = 0
    while truck.run.now < UNTIL and truck.run.step():
        cycle += 1
        if cycle in wanted:
            saves.append((len(truck.trace), truck.run.save()))
    return truck, saves


def unsaved(seed: int) -> tuple[int, str]:
    """Return how many cycles a run takes that nobody saves, and its digest."""
    truck, cycles = Truck(seed), 0
    while truck.run.now < UNTIL and truck.run.step():
        cycles += 1
    return cycles, truck.digest()


def elsewhere(seed: int, saves: Sequence[bytes]) -> list[str]:
    """Take runs up in another process; return the digests of what they come to."""
    with tempfile.TemporaryDirectory() as folder:
        for number, saved in enumerate(saves):
            (Path(folder) / f"{number:06}").write_bytes(saved)
        asked = [sys.executable, "-m", "tests.runtime.saving", "--finish", folder]
        done = subprocess.run(
            [*asked, "--seed", str(seed)],
            capture_output=True,
            check=True,
            text=True,
            cwd=Path(__file__).parents[2],
            env={**os.environ, "PYTHONHASHSEED": str(seed + 1)},
        )
    return done.stdout.split()


def _finish(folder: Path, seed: int) -> None:
    for path in sorted(folder.iterdir()):
        print(Truck(seed, path.read_bytes()).finish().digest())


def compare(seed: int, points: int, far: int) -> int:
    """Save a run at random points, take it up, compare; return how many differ.

    The first `far` points are taken up in another process.
    """
    dice = random.Random(f"saving:{seed}")
    most, alone = unsaved(seed)
    cycles = sorted(dice.sample(range(1, most), min(points, most - 1)))
    truck, saves = saved_at(seed, cycles)
    assert truck.digest() == alone, "saving has changed the run"
    expected = [truck.digest(line) for line, _ in saves]
    found = elsewhere(seed, [saved for _, saved in saves[:far]]) if far else []
    found += [Truck(seed, s).finish().digest() for _, s in saves[far:]]
    bad = [
        c for c, one, other in zip(cycles, expected, found, strict=True) if one != other
    ]
    for cycle in bad:
        print(f"seed {seed}: not the same after cycle {cycle}")
    return len(bad)


def timed(
    seed: int = 5, cycle: int = 3000, times: int = 20
) -> tuple[float, float, int]:
    """Return the milliseconds to save and to restore, medians, and the bytes."""
    truck = Truck(seed)
    for _ in range(cycle):
        truck.run.step()
    saves, restores = [], []
    saved = truck.run.save()
    for _ in range(times):
        start = perf_counter()
        saved = truck.run.save()
        middle = perf_counter()
        truck.run.restore(saved)
        saves.append(middle - start)
        restores.append(perf_counter() - middle)
    return (
        sorted(saves)[times // 2] * 1000,
        sorted(restores)[times // 2] * 1000,
        len(saved),
    )


def main() -> int:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--points", type=int, default=100)
    parser.add_argument("--each", type=int, default=25, help="points in one run")
    parser.add_argument("--seed", type=int, default=0, help="the first seed")
    parser.add_argument("--time", action="store_true", help="only take the time")
    parser.add_argument("--finish", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.finish is not None:
        _finish(given.finish, given.seed)
        return 0
    if given.time:
        save, restore, size = timed()
        print(f"save {save:.2f} ms, restore {restore:.2f} ms, {size} bytes")
        return 0
    bad = done = 0
    seed = given.seed
    while done < given.points:
        points = min(given.each, given.points - done)
        bad += compare(seed, points, far=points // 5)
        done, seed = done + points, seed + 1
        print(f"{done} points, {bad} differ", flush=True)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
