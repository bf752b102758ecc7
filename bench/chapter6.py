"""Runs of T chapter 6: nine orders, in the still world and at every point of it.

What `rapc experiment chapter6` has its processes do, in this one, without the library's
being read: that is done once a process.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator

import msgspec

from bench.common import Figure
from rapc.experiments import definition
from rapc.experiments.measures import Measures
from rapc.experiments.run import PointConfig, measure
from rapc.experiments.session import Batch
from rapc.host import load


class Run(msgspec.Struct, frozen=True):
    """What a run took, in seconds, and what came of it."""

    wall: float
    cpu: float
    measures: Measures


def run(config: PointConfig, seed: int) -> Run:
    """One run; the first in a process reads the library too."""
    wall, cpu = time.perf_counter(), time.process_time()
    measures = measure(config, seed)
    return Run(time.perf_counter() - wall, time.process_time() - cpu, measures)


def session() -> Batch:
    """The experiment that comes with rapc, ready to be run."""
    file = definition.experiment_file("chapter6")
    made = definition.read_experiment(file)
    return Batch(made, file.parent, lambda path: load(path).program)


def figures(quick: bool = False) -> Iterator[Figure]:
    """Medians over seeds in the still world; and the sum of one run at each point."""
    chapter = session()
    configs = {point.digest: point.config for point in chapter.points}
    still = chapter.points[0].config
    run(still, 0)
    runs = [run(still, seed) for seed in range(1 if quick else 20)]
    size = f"{len(runs)} seeds, median"
    rows = {
        "wall time": (statistics.median(one.wall for one in runs), "s"),
        "CPU time": (statistics.median(one.cpu for one in runs), "s"),
        "simulated time": (
            statistics.median(one.measures.time for one in runs),
            "time units",
        ),
    }
    for what, (value, unit) in rows.items():
        yield Figure("chapter6", f"{what} of a still run", size, value, unit)
    points = list(configs.values())[: 2 if quick else None]
    spent = sum(run(config, 0).cpu for config in points)
    size = f"{len(points)} points, seed 0"
    yield Figure("chapter6", "CPU time of a run at each point", size, spent, "s")
