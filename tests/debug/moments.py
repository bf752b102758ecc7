"""Runs that are taken back to random moments, and go on from there as they did.

    python -m tests.debug.moments --points 1000

goes to that many random moments of a run of the truck, with enemies, shuffled items and
nine orders, of one of the hallway, with people, doors and a tour, and of a shift of the
courier, with claims that stand in each other's way. At each the state
is held against the one that was there: tasks, memory, items, world, random streams,
byte for byte. The run goes on from there for a while, from some to its end, and what is
told must be what was told at first.
"""

from __future__ import annotations

import argparse
import hashlib
import random
from collections.abc import Callable, Mapping
from time import process_time

import msgspec

import rapc
from rapc.debug.history import History
from rapc.events import Event
from tests.runtime.saving import HARD, tasks

_AHEAD = 60
"""How many cycles a run goes on for from a moment, at most."""

_TO_THE_END = 100
"""From one in so many moments the run goes on to its end."""


class Checked(msgspec.Struct):
    """What came of a run that was taken back."""

    cycles: int
    points: int
    #: The moments whose state, or whose future, was another.
    differ: list[int]


def truck(cycles: int) -> History:
    """Return a run of the truck in a hard world, that many cycles long."""
    library = rapc.load("stdlib/truck")
    session = History.open(
        library, "truck", tasks=list(tasks()), seed=3, options=HARD[3]
    )
    session.checks["end"] = lambda: "end" if session.cycle >= cycles else None
    return session


def hallway(cycles: int) -> History:
    """Return a tour of the hallway, that many cycles long."""
    library = rapc.load("stdlib/hallway")
    session = History.open(library, "hallway", agenda="sightseeing", seed=5)
    session.checks["end"] = lambda: "end" if session.cycle >= cycles else None
    return session


def courier(cycles: int) -> History:
    """Return a shift of the courier, that many cycles long if it lasts."""
    library = rapc.load("examples/courier")
    session = History.open(library, "courier", agenda="shift", seed=4)
    session.checks["end"] = lambda: "end" if session.cycle >= cycles else None
    return session


RUNS: Mapping[str, Callable[[int], History]] = {
    "truck": truck,
    "hallway": hallway,
    "courier": courier,
}


def _state(session: History) -> bytes:
    return hashlib.sha256(session.run.save()).digest()


def check(session: History, points: int, seed: int = 0) -> Checked:
    """Run to the end, go to random moments, and compare.

    Args:
        session: a run that has not made a step.
        points: how many moments.
        seed: the seed of their choice.
    """
    states = [_state(session)]
    while session.step().kind == "asked":
        states.append(_state(session))
    if session.cycle == len(states):
        states.append(_state(session))
    told, last = [*session.scan()], session.cycle
    chance, differ = random.Random(seed), []
    repeated = 0

    def hear(event: Event) -> None:
        nonlocal repeated
        repeated += event == told[event.n].event()

    session.run.listen(hear)
    for point in range(points):
        cycle = chance.randrange(last)
        session.goto(cycle)
        same = _state(session) == states[cycle]
        ahead = min(cycle + chance.randrange(1, _AHEAD), last)
        ahead = last if point % _TO_THE_END == 0 else ahead
        first, repeated = session.serial, 0
        while session.cycle < ahead and not session.over:
            session.step()
        same = same and _state(session) == states[ahead]
        same = same and repeated == session.serial - first
        if not same:
            differ.append(cycle)
    return Checked(last, points, differ)


def asked_for(doc: str | None, *, points: int, cycles: int) -> argparse.Namespace:
    """Return how many moments and cycles the command line wants; or these."""
    parser = argparse.ArgumentParser(description=doc)
    parser.add_argument("--points", type=int, default=points)
    parser.add_argument("--cycles", type=int, default=cycles)
    return parser.parse_args()


def main() -> None:
    """Check both runs and tell what came of them."""
    given = asked_for(__doc__, points=1000, cycles=3000)
    failed = False
    for name, make in RUNS.items():
        start = process_time()
        found = check(make(given.cycles), given.points)
        print(
            f"{name}: {found.cycles} cycles, {found.points} points, "
            f"{len(found.differ)} differ, {process_time() - start:.0f} s of CPU",
            flush=True,
        )
        failed |= bool(found.differ)
    raise SystemExit(failed)


if __name__ == "__main__":
    main()
