"""What the runs of a part come to: for each point the averages, and how they spread.

A run that the world ended is a disaster: it is counted, and left out of the averages.
Tasks that were given up or are pending are not (T 6.3.1).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from statistics import stdev

import msgspec

from rapc.experiments.definition import Reference, Series
from rapc.experiments.draws import Value
from rapc.experiments.measures import Measures, TaskTold, numbers_of, with_time_each
from rapc.experiments.points import Point


class Spread(msgspec.Struct, frozen=True):
    """An average, and how far apart the numbers lie that went into it."""

    mean: float
    low: float
    high: float
    #: The standard deviation; 0 of one number.
    deviation: float
    #: What a tenth of the numbers lies below, and nine tenths of them.
    tenth: float
    ninetieth: float


class TaskRow(msgspec.Struct, frozen=True):
    """What became of the task that came first, or second and so on, in all runs."""

    #: What it is; None if it is not the same in all runs.
    goal: str | None
    runs: int
    completed: int
    given_up: int
    #: When it came, and when it succeeded in the runs in which it did.
    came: Spread
    ended: Spread | None


class PointSummary(msgspec.Struct, frozen=True):
    """What the runs of one point come to."""

    value: Value | None
    #: How many have results, and how many are wanted.
    runs: int
    wanted: int
    #: Seeds by what the world said that ended their runs.
    disasters: Mapping[str, tuple[int, ...]]
    #: Seeds by why a run was over though tasks were left and the world went on.
    stopped: Mapping[str, tuple[int, ...]]
    #: A measure that no run has is not among them.
    figures: Mapping[str, Spread]
    #: How many tasks failed, by why; the most frequent first.
    reasons: Mapping[str, int]
    #: The tasks that are counted, in the order in which they come.
    tasks: tuple[TaskRow, ...]

    @property
    def lost(self) -> int:
        """Return how many runs ended in a disaster."""
        return sum(map(len, self.disasters.values()))


class PartSummary(msgspec.Struct, frozen=True):
    """A part with what its points come to."""

    part: Series
    #: The unit of what the part varies.
    unit: str
    #: What is counted besides, and the world's figures, by name.
    told: tuple[str, ...]
    #: Those of `told` that are counted.
    counted: tuple[str, ...]
    rows: tuple[PointSummary, ...]

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
    part: Series,
    unit: str,
    points: Sequence[Point],
    found: Callable[[str], Mapping[int, Measures]],
    wanted: int,
) -> PartSummary:
    """Return what the runs of a part come to.

    Args:
        part: the part.
        unit: the unit of what it varies.
        points: its points, in order.
        found: the measures by seed that there are of a configuration, by its hash.
        wanted: how many runs a point is to have.
    """
    counted = tuple(points[0].config.count)
    told = (*counted, *points[0].config.figures)
    rows = tuple([_row(p.value, found(p.digest), wanted) for p in points])
    return PartSummary(part, unit, told, counted, rows)


def _row(
    value: Value | None, found: Mapping[int, Measures], wanted: int
) -> PointSummary:
    disasters = _seeds({seed: m.disaster for seed, m in found.items()})
    stopped = _seeds({seed: _stopped(m) for seed, m in found.items()})
    told = [numbers_of(m) for m in found.values() if m.disaster is None]
    names = dict.fromkeys(name for numbers in told for name in numbers)
    figures = {n: _spread(many[n] for many in told if n in many) for n in names}
    if "time-each" in figures:
        figures["time-each"] = _total(figures["time-each"], told)
    kept = [m.tasks for m in found.values() if m.disaster is None]
    why = Counter(task.reason for tasks in kept for task in tasks if task.reason)
    return PointSummary(
        value=value,
        runs=len(found),
        wanted=wanted,
        disasters=disasters,
        stopped=stopped,
        figures=figures,
        reasons=dict(sorted(why.items(), key=lambda item: (-item[1], item[0]))),
        tasks=tuple(_task_rows(kept)),
    )


def _total(each: Spread, told: Sequence[Mapping[str, float]]) -> Spread:
    """The time for each task over all runs: a run that completes one weighs little."""
    time = sum(numbers["time"] for numbers in told)
    done = sum(numbers["completed"] for numbers in told)
    return msgspec.structs.replace(each, mean=time / done)


def _task_rows(runs: Sequence[Sequence[TaskTold]]) -> Iterator[TaskRow]:
    for place in range(max(map(len, runs), default=0)):
        told = [tasks[place] for tasks in runs if len(tasks) > place]
        goals = {task.goal for task in told}
        done = [task.ended for task in told if task.outcome == "succeeded"]
        yield TaskRow(
            goal=goals.pop() if len(goals) == 1 else None,
            runs=len(told),
            completed=len(done),
            given_up=sum(task.outcome == "failed" for task in told),
            came=_spread(task.came for task in told),
            ended=_spread(time for time in done if time is not None) if done else None,
        )


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
    known = sorted(values)
    return Spread(
        mean=sum(known) / len(known),
        low=known[0],
        high=known[-1],
        deviation=stdev(known) if len(known) > 1 else 0.0,
        tenth=_quantile(known, 0.1),
        ninetieth=_quantile(known, 0.9),
    )


def _quantile(known: Sequence[float], part: float) -> float:
    """Return the quantile of sorted numbers, between two of them in proportion."""
    place = part * (len(known) - 1)
    below = int(place)
    above = min(below + 1, len(known) - 1)
    return known[below] + (known[above] - known[below]) * (place - below)


def _figures_at(reference: Reference, value: Value | None) -> dict[str, float]:
    at = (None,) if value is None else reference.at
    if value not in at:
        return {}
    place = at.index(value)
    return {name: figures[place] for name, figures in reference.figures.items()}
