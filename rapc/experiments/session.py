"""A requested batch: its points and seeds, and the missing runs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path

from rapc.compiler.program import Program
from rapc.experiments.definition import Experiment
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
    ) -> None:
        chosen = [made.part_named(name) for name in parts] or made.part
        self.made = made
        self.chosen = frozenset(part.name for part in chosen)
        self.points = points(made, folder, cache(load))
        first = made.first_seed
        self.seeds = range(first, first + (seeds or made.seeds))

    def missing(self, store: Store) -> list[tuple[PointConfig, list[int]]]:
        """Return the configurations of the chosen points with their missing seeds.

        Points of equal configuration are listed once.
        """
        lacking: dict[str, tuple[PointConfig, list[int]]] = {}
        for point in self.points:
            if point.part in self.chosen and point.digest not in lacking:
                there = store.seeds(point.digest)
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
        return next(point for point in self.points if point.digest == digest)

    def command(self, point: Point, seed: int) -> str:
        """Return the command line that repeats one run of a point."""
        return command(self.made, point, seed)
