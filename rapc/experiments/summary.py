"""What the runs of a part come to: for each point the averages, and how they spread.

A run that the world ended is a disaster: it is counted, and left out of the averages.
Tasks that were given up or are pending are not (T 6.3.1).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import msgspec

from rapc.experiments.definition import Part, Reference, Value
from rapc.experiments.measures import LABELS, Measures, numbers_of, with_time_each
from rapc.experiments.points import Point


class Spread(msgspec.Struct, frozen=True):
    """An average, with the least and the greatest number that went into it."""

    mean: float
    low: float
    high: float


class Row(msgspec.Struct, frozen=True):
    """What the runs of one point come to.

    `runs` counts those with results, of `wanted`; `disasters` are seeds by what the
    world said, `stopped` seeds by why a run was over though tasks were left and the
    world had not ended it. A measure that no run has is not among the figures.
    """

    value: Value | None
    runs: int
    wanted: int
    disasters: Mapping[str, tuple[int, ...]]
    stopped: Mapping[str, tuple[int, ...]]
    figures: Mapping[str, Spread]

    @property
    def lost(self) -> int:
        """How many runs ended in a disaster."""
        return sum(map(len, self.disasters.values()))


class Summary(msgspec.Struct, frozen=True):
    """A part with its rows; `unit` is that of what it varies."""

    part: Part
    unit: str
    measures: tuple[str, ...]
    rows: tuple[Row, ...]

    @property
    def complete(self) -> bool:
        """Whether every run that is wanted has a result."""
        return all(row.runs == row.wanted for row in self.rows)

    def reference(self, value: Value | None) -> Mapping[str, float]:
        """Figures from elsewhere for a value, with those that follow from them."""
        reference = self.part.reference
        if reference is None:
            return {}
        return with_time_each(_figures_at(reference, value))


def summarize(
    part: Part,
    unit: str,
    points: Sequence[Point],
    found: Callable[[str], Mapping[int, Measures]],
    wanted: int,
) -> Summary:
    """What the runs of a part come to.

    Args:
        part: the part.
        unit: the unit of what it varies.
        points: its points, in order.
        found: the measures by seed that there are of a configuration, by its hash.
        wanted: how many runs a point is to have.
    """
    counts = tuple(points[0].config.count)
    rows = tuple([_row(p.value, found(p.digest), wanted) for p in points])
    return Summary(part, unit, (*LABELS, *counts), rows)


def _row(value: Value | None, found: Mapping[int, Measures], wanted: int) -> Row:
    disasters = _seeds({seed: m.disaster for seed, m in found.items()})
    stopped = _seeds({seed: _stopped(m) for seed, m in found.items()})
    told = [numbers_of(m) for m in found.values() if m.disaster is None]
    names = dict.fromkeys(name for numbers in told for name in numbers)
    figures = {n: _spread(many[n] for many in told if n in many) for n in names}
    return Row(value, len(found), wanted, disasters, stopped, figures)


def _stopped(measures: Measures) -> str | None:
    over = measures.reason == "done" or measures.disaster is not None
    return None if over else measures.reason


def _seeds(told: Mapping[int, str | None]) -> dict[str, tuple[int, ...]]:
    """Seeds by what is told of them."""
    seeds: dict[str, tuple[int, ...]] = {}
    for seed, what in told.items():
        if what is not None:
            seeds[what] = (*seeds.get(what, ()), seed)
    return seeds


def _spread(values: Iterable[float]) -> Spread:
    known = list(values)
    return Spread(sum(known) / len(known), min(known), max(known))


def _figures_at(reference: Reference, value: Value | None) -> dict[str, float]:
    at = (None,) if value is None else reference.at
    if value not in at:
        return {}
    place = at.index(value)
    return {name: figures[place] for name, figures in reference.figures.items()}
