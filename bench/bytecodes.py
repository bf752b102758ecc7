"""What a firing, a task and a cycle take, in bytecodes of Python.

    python -m bench.bytecodes

A count is the same on every machine and whatever else that does, for one version of
Python: so bars on it can be kept. It says nothing of what C takes, nor of memory.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

import rapc
from bench.common import Figure
from bench.profiles import adapter, firings
from rapc.base.gc_paused import gc_paused

MONITORS = 1000
BRANCHES, DEPTH = 3, 8


def count(work: Callable[[], object]) -> int:
    """Return how many bytecodes Python runs in `work`."""
    found = 0

    def trace(frame: FrameType, event: str, _: Any) -> Any:
        nonlocal found
        if event == "call":
            frame.f_trace_opcodes = True
            frame.f_trace_lines = False
        elif event == "opcode":
            found += 1
        return trace

    before = sys.gettrace()
    with gc_paused():  # its callbacks may be Python
        sys.settrace(trace)
        try:
            work()
        finally:
            sys.settrace(before)
    return found


def firing(monitors: int = MONITORS, times: int = 50) -> float:
    """Return the bytecodes of one firing among sleeping monitors, on average."""
    fire = firings(monitors, times)
    fire()
    return count(fire) / times


def task(depth: int = DEPTH) -> float:
    """Return the bytecodes of one task of a tree, all of its run counted."""
    made: Any = adapter()
    made.w4_setup(BRANCHES, depth)
    made.w4_run()
    tasks: int = sum(BRANCHES**level for level in range(depth + 1))
    return count(made.w4_run) / tasks


def cycle(seed: int = 1) -> float:
    """Return the bytecodes of a cycle of nine orders, in a library that has run."""
    library = rapc.load("rapc:truck")

    def begin() -> rapc.Interpreter:
        return library.start(world="truck", agenda="nine-orders", seed=seed)

    begin().run(until=20_000)
    run = begin()
    return count(lambda: run.run(until=20_000)) / run.recorder.cycle


def figures() -> Iterator[Figure]:
    """Return the three counts."""
    size = f"{MONITORS:,} monitors"
    yield Figure("bytecodes", "one firing (W3)", size, firing(), "bytecodes")
    size = f"{BRANCHES} branches, {DEPTH} levels"
    yield Figure("bytecodes", "one task (W4)", size, task(), "bytecodes")
    size = "nine orders, seed 1"
    yield Figure("bytecodes", "one cycle", size, cycle(), "bytecodes")


if __name__ == "__main__":
    for figure in figures():
        print(f"{figure.what} ({figure.size}): {figure.value:,.1f}")
