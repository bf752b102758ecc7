"""Summary of the runs of a part: for each point the averages and spreads.

A run that the world ended is a disaster: it is counted, and left out of the averages.
Runs with failed or pending tasks are included (T 6.3.1).
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
    """An average, and the spread of its numbers."""

    mean: float
    low: float
    high: float
    #: The standard deviation; 0 for one number.
    deviation: float
    #: The tenth and the ninetieth percentile.
    tenth: float
    ninetieth: float


class TaskRow(msgspec.Struct, frozen=True):
    """The results, over all runs, of the task with one position of arrival."""

    #: The goal; None if it is not equal in all runs.
    goal: str | None
    runs: int
    completed: int
    given_up: int
    #: The time of its arrival, and the time of its success in the successful runs.
    came: Spread
    ended: Spread | None


class PointSummary(msgspec.Struct, frozen=True):
    """The results of the runs of one point."""

    value: Value | None
    #: The number of results, and the number of requested runs.
    runs: int
    wanted: int
    #: Seeds by the world's reason for ending their runs.
    disasters: Mapping[str, tuple[int, ...]]
    #: Seeds by the reason why a run ended with tasks left and without the world.
    stopped: Mapping[str, tuple[int, ...]]
    #: The measures that at least one run has.
    figures: Mapping[str, Spread]
    #: The number of failed tasks by reason; most frequent first.
    reasons: Mapping[str, int]
    #: The counted tasks, in the order of arrival.
    tasks: tuple[TaskRow, ...]

    @property
    def lost(self) -> int:
        """Return the number of runs that ended in a disaster."""
        return sum(map(len, self.disasters.values()))


class PartSummary(msgspec.Struct, frozen=True):
    """A part with the results of its points."""

    part: Series
    #: The unit of the varied setting.
    unit: str
    #: The names of other counts, and of the world's figures.
    told: tuple[str, ...]
    #: The names in `told` that are counts.
    counted: tuple[str, ...]
    rows: tuple[PointSummary, ...]

    @property
    def complete(self) -> bool:
        """Return whether every requested run has a result."""
        return all(row.runs == row.wanted for row in self.rows)

    def reference(self, value: Value | None) -> Mapping[str, float]:
        """Return the reference figures for a value, with derived figures."""
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
    """Return the summary of the runs of a part.

    Args:
        part: the part.
        unit: the unit of the varied setting.
        points: its points, in order.
        found: returns the stored measures of a configuration, by its hash; by seed.
        wanted: the number of requested runs of a point.
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
    """Return the time for each task over all runs, weighted by completed tasks."""
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
    """Return seeds by their reason."""
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
    """Return the quantile of sorted numbers, interpolated linearly."""
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
