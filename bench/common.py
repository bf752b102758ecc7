"""What the benchmarks share: how time is taken, and how a figure is told.

A figure is the median of several rounds; each round repeats the work until it has
taken long enough for the clock. The clock is that of the CPU, so that others on the
machine disturb little. The collector stays on, as it is in use.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import msgspec

from rapc.analysis import driver
from rapc.base.diagnostics import Severity
from rapc.compiler.program import Program
from rapc.library.loader import Loaded

ROUND = 0.05
"""Seconds that a round takes at least."""

INPUTS = "RAPC_BENCH_INPUTS"
"""The environment variable that names the checkout whose libraries are read."""


def inputs() -> Path:
    """Return the checkout whose libraries are read: this one if nobody chooses."""
    return Path(os.environ.get(INPUTS) or Path(__file__).parents[1])


class Figure(msgspec.Struct, frozen=True):
    """One line of the results: what was done, to how much, how fast."""

    bench: str
    what: str
    size: str
    value: float
    unit: str


def seconds(work: Callable[[], object], rounds: int = 5) -> float:
    """The median CPU time of one call in seconds, after a first call to warm up."""
    work()
    times = []
    for _ in range(rounds):
        calls = 0
        start = now = time.process_time()
        while now - start < ROUND or calls == 0:
            work()
            calls += 1
            now = time.process_time()
        times.append((now - start) / calls)
    return statistics.median(times)


def compiled(loaded: Loaded) -> Program:
    """A loaded library without errors, compiled.

    Raises:
        ValueError: if an error was found in it; then the benchmark is wrong.
    """
    report = driver.check_library(loaded)
    if report.worst() is Severity.ERROR:
        raise ValueError([f.diagnostic.message for f in report.findings[:5]])
    return Program(loaded.library)


def table(figures: Iterable[Figure]) -> Iterator[str]:
    """Figures as the rows of a Markdown table."""
    yield "| bench | what | size | figure | unit |"
    yield "|---|---|---|---:|---|"
    for f in figures:
        yield f"| {f.bench} | {f.what} | {f.size} | {short(f.value)} | {f.unit} |"


def short(value: float) -> str:
    """Three figures that count, without a power of ten."""
    return f"{value:,.0f}" if value >= 100 else f"{value:.3g}"
