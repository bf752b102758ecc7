"""A requested batch: its points and seeds, and the missing runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

import msgspec

from rapc.base.files import STANDARD
from rapc.compiler.program import Program
from rapc.debug.costs import Pair
from rapc.experiments.definition import Experiment
from rapc.experiments.measures import Measures
from rapc.experiments.points import Point, command, points, unit
from rapc.experiments.run import PointConfig
from rapc.experiments.store import Store
from rapc.experiments.summary import PartSummary, summarize
from rapc.worlds.registry import find_world


class Batch:
    """An experiment, the parts to run, and the seeds.

    Args:
        made: the experiment.
        folder: the folder of its file.
        load: returns the checked library of a file or folder; called once for each.
        parts: the names of the parts; all parts if there are none.
        seeds: the number of runs of each point; None: as in the experiment.
        against: a library to compare with the library of the experiment.

    Raises:
        ExperimentError: for an unknown part, world, option, setting, RAP or task.
    """

    def __init__(
        self,
        made: Experiment,
        folder: Path,
        load: Callable[[str], Program],
        parts: Iterable[str] = (),
        seeds: int | None = None,
        against: str | None = None,
    ) -> None:
        chosen = [made.part_named(name) for name in parts] or made.part
        self.made = made
        self.chosen = frozenset(part.name for part in chosen)
        load, timed = cache(load), against is not None
        self.points = points(made, folder, load, timed=timed)
        #: For each point the point with the library to compare with, if there is one.
        self.before: tuple[Point, ...] = ()
        if against is not None:
            path = against if against.startswith(STANDARD) else Path(against).absolute()
            other = msgspec.structs.replace(made, library=str(path))
            self.before = points(other, folder, load, timed=timed)
        first = made.first_seed
        self.seeds = range(first, first + (seeds or made.seeds))

    def missing(self, store: Store | None) -> list[tuple[PointConfig, list[int]]]:
        """Return the configurations of the chosen points with their missing seeds.

        Without a store, all seeds are missing. Points of equal configuration are listed
        once.
        """
        lacking: dict[str, tuple[PointConfig, list[int]]] = {}
        for point in (*self.points, *self.before):
            if point.part in self.chosen and point.digest not in lacking:
                there = () if store is None else store.seeds(point.digest)
                seeds = [seed for seed in self.seeds if seed not in there]
                lacking[point.digest] = point.config, seeds
        return list(lacking.values())

    def summaries(self, store: Store) -> Iterator[PartSummary]:
        """Yield the chosen parts, and the other parts with complete stored results."""
        world = find_world(self.made.world)
        for part in self.made.part:
            summary = summarize(
                part,
                unit(world, part.vary or ""),
                [point for point in self.points if point.part == part.name],
                lambda digest: store.measures(digest, self.seeds),
                len(self.seeds),
            )
            if part.name in self.chosen or summary.complete:
                yield summary

    def point_of(self, config: PointConfig) -> Point:
        """Return the first point with a configuration."""
        digest = config.digest()
        every = (*self.points, *self.before)
        return next(point for point in every if point.digest == digest)

    def pairs(self, store: Store) -> Iterator[tuple[Point, Point, dict[int, Pair]]]:
        """Yield the chosen points with the runs of both libraries, by seed.

        Without a library to compare with, there are none.
        """
        for before, after in zip(self.before, self.points, strict=False):
            if after.part in self.chosen:
                stored = [store.measures(p.digest, self.seeds) for p in (before, after)]
                yield before, after, pairs_of(*stored)

    def command(self, point: Point, seed: int) -> str:
        """Return the command line that repeats one run of a point."""
        return command(self.made, point, seed)


def pairs_of(
    before: Mapping[int, Measures], after: Mapping[int, Measures]
) -> dict[int, Pair]:
    """Return the times of the seeds with timed runs on both sides, by seed."""
    return {
        seed: (one.times, after[seed].times)  # type: ignore[misc]  # both are present
        for seed, one in before.items()
        if one.times is not None and seed in after and after[seed].times is not None
    }
