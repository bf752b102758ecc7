"""The workloads shared with the peers, without the peers, in the form of `bench.run`.

    python -P bench/adapter_rows.py ADAPTER.PY

`bench.paired` has this done by the interpreter of each checkout, with the adapter of
that checkout: so this file imports nothing of rapc, and speaks of what adapters have
had from the first.
"""

from __future__ import annotations

import random
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

DEFINITIONS = 300
ITEMS = 10_000
PLACES = 500
MONITORS = 1000
DEPTH = 6
ROUNDS = 5

Row = tuple[str, str, str, float, str]
"""Bench, what, size, figure and unit, as in a row of `bench.run`."""


class Peer:
    """What the classes of an adapter are made from."""


def classes(adapter: Path) -> dict[str, Any]:
    """Return what an adapter defines, by name."""
    scope = {"__name__": "adapter", "Peer": Peer, "peer": lambda made: made}
    exec(compile(adapter.read_text(), str(adapter), "exec"), scope)  # noqa: S102
    return scope


def micros(work: Callable[[], object], number: int) -> float:
    """Return the median CPU time of `work` in microseconds, divided by `number`."""
    work()
    taken = []
    for _ in range(ROUNDS):
        start = time.process_time()
        work()
        taken.append(time.process_time() - start)
    return statistics.median(taken) / number * 1e6


def rows(adapter: Path) -> Iterator[Row]:
    """Measure W1 to W4 with the classes of an adapter."""
    made = classes(adapter)
    text = made["RapcLoad"]().w1_text(DEFINITIONS)
    for name, what in (
        ("Rapc", "text to lists and atoms"),
        ("RapcIr", "text to typed nodes"),
        ("RapcLoad", "text to a library to be run"),
    ):
        one = made[name]()
        used = micros(lambda one=one: one.w1(text), DEFINITIONS)  # type: ignore[misc]
        yield "W1", what, f"{DEFINITIONS} definitions", used, "us each"
    yield from _questions(made["Rapc"]())
    kinds = (("Rapc", ""), ("RapcTraced", ", kept"), ("RapcWritten", ", written"))
    for name, how in kinds:
        one = made[name]()
        one.fired = 0
        one.w3_setup(MONITORS)
        used = micros(lambda one=one: _fire(one), 2 * MONITORS)  # type: ignore[misc]
        yield "W3", f"one firing{how}", f"{MONITORS} asleep", used, "us"
    for name, how in (*kinds, ("RapcInputs", ", depth as input")):
        one = made[name]()
        one.w4_setup(3, DEPTH)
        tasks = one.w4_run()
        used = micros(one.w4_run, tasks)
        yield "W4", f"a task{how}", f"{DEPTH} levels", used, "us"


def _fire(one: Any) -> None:
    for number in range(2 * MONITORS):
        one.w3_fire(number % MONITORS)


def _questions(one: Any) -> Iterator[Row]:
    dice = random.Random("items")
    one.w2_setup(
        [
            (f"i{n}", f"p{dice.randrange(PLACES)}", "rock", "red", dice.randrange(9))
            for n in range(ITEMS)
        ]
    )
    places = [f"p{n}" for n in range(PLACES)] * 5
    size = f"{ITEMS} items"
    for what, ask in (("first answer", one.w2_first), ("all answers", one.w2_all)):
        used = micros(lambda ask=ask: [ask(p) for p in places], len(places))  # type: ignore[misc]
        yield "W2", what, size, used, "us"


if __name__ == "__main__":
    for row in rows(Path(sys.argv[1])):
        print("| " + " | ".join(map(str, row)) + " |", flush=True)
