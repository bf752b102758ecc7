"""Pairs of runs: two libraries under equal seeds, on this machine."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import msgspec

from rapc.base.code_digest import digest_of_code
from rapc.base.version import VERSION
from rapc.compiler.program import Program
from rapc.debug.costs import Pair
from rapc.experiments.batch import jobs, run_batch
from rapc.experiments.local import LocalWorkers, cores
from rapc.experiments.measures import Measures
from rapc.experiments.run import PointConfig, run_job
from rapc.experiments.session import pairs_of
from rapc.spec import RunSpec
from rapc.worlds.registry import find_world


def timed_config(library: Program, spec: RunSpec) -> PointConfig:
    """Return the configuration of timed runs of a library."""
    world = find_world(spec.world_class or spec.world)
    return PointConfig(
        rapc=VERSION,
        code=digest_of_code(world),
        spec=msgspec.structs.replace(spec, library=library.name),
        sources=tuple((f.name, f.text) for f in library.library.files.values()),
        counted=(),
        count={},
        timed=True,
    )


def run_pairs(
    libraries: Sequence[Program],
    spec: RunSpec,
    seeds: Sequence[int],
    processes: int | None = None,
    time_limit: float = 120,
    advance: Callable[[int], object] = lambda more: None,
) -> tuple[dict[int, Pair], list[str]]:
    """Run two libraries under each seed.

    Args:
        libraries: the two libraries, checked.
        spec: the start of the runs, without faults.
        seeds: the seeds.
        processes: the number of processes; default: one for each core.
        time_limit: the time limit of a run, in seconds.
        advance: called with each number of runs that have ended.

    Returns:
        The times of both runs by seed, and a line for each run without a result.

    Raises:
        WorkersLost: if no workers are left.
    """
    configs = [timed_config(library, spec) for library in libraries]
    found: list[dict[int, Measures]] = [{}, {}]
    faults = []
    count = min(processes or cores(), 2 * len(seeds))
    with LocalWorkers(count, run_job, time_limit) as workers:
        work = jobs([(config, seeds) for config in configs], workers.chunk)
        for done in run_batch(workers, work):
            advance(len(done.results))
            for side, config in enumerate(configs):
                if done.config is config:
                    for result in done.results:
                        if result.measures is None:
                            told = f"{config.spec.library}, seed {result.seed}"
                            faults.append(f"{told}: {result.fault}")
                        else:
                            found[side][result.seed] = result.measures
    return dict(sorted(pairs_of(*found).items())), faults
