"""The results of an experiment as one page, with links to pages of runs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from statistics import fmean, stdev
from typing import Any, NamedTuple

from rapc.base.values import typed
from rapc.experiments.measures import LABELS, Measures, numbers_of
from rapc.experiments.points import Point
from rapc.experiments.session import Batch
from rapc.experiments.store import Store
from rapc.experiments.summary import PartSummary
from rapc.view.page import EXPERIMENT, composed, json_element

FOLDER = "runs"
"""The folder of the pages of runs, beside the page of the results."""

_SCRIPTS = ("model.js", "dom.js", "experiment.js")


class Chosen(NamedTuple):
    """A run that gets a page: its point and seed."""

    point: Point
    seed: int

    @property
    def file(self) -> str:
        """The name of the file of the page."""
        return f"{self.point.digest}-{self.seed}.html"


def chosen_runs(session: Batch, store: Store, most: int) -> list[Chosen]:
    """Return the runs that get a page: of each point in turn the least usual run.

    Runs that the world ended come first, then runs with tasks given up or pending, then
    runs by the distance of their time from the mean of the point.
    """
    points = {p.digest: p for p in session.points if p.part in session.chosen}
    ranked = []
    for point in points.values():
        found = store.measures(point.digest, session.seeds)
        order = sorted(found, key=lambda seed: _rank(found[seed], found.values()))
        ranked.append([Chosen(point, seed) for seed in order])
    turns = zip_longest(*ranked)
    return [one for turn in turns for one in turn if one is not None][:most]


def _rank(one: Measures, others: Any) -> tuple[bool, int, float]:
    times = [float(other.time) for other in others]
    spread = stdev(times) if len(times) > 1 else 0
    off = abs(one.time - fmean(times)) / spread if spread else 0
    return one.disaster is None, -(one.given_up + one.pending), -off


def results_page(
    session: Batch,
    store: Store,
    summaries: Sequence[PartSummary],
    pages: Mapping[tuple[str, int], str],
) -> str:
    """Return the page of the results.

    Args:
        session: the experiment.
        store: the results.
        summaries: the parts to show.
        pages: the address of each page of a run, by the digest of its point and its
            seed.
    """
    data = {
        "title": session.made.title or session.made.name,
        "parts": [_part(session, store, one, pages) for one in summaries],
    }
    element = json_element("experiment", data)
    return composed(EXPERIMENT, _SCRIPTS, "experiment.html", [element])


def _part(
    session: Batch,
    store: Store,
    summary: PartSummary,
    pages: Mapping[tuple[str, int], str],
) -> dict[str, Any]:
    part = summary.part
    points = [point for point in session.points if point.part == part.name]
    rows = []
    for point, row in zip(points, summary.rows, strict=True):
        found = store.measures(point.digest, session.seeds)
        rows.append(
            {
                "label": "all" if row.value is None else typed(row.value),
                "value": row.value,
                "wanted": row.wanted,
                "spreads": {
                    name: (s.mean, s.deviation, s.tenth, s.ninetieth)
                    for name, s in row.figures.items()
                },
                "reference": summary.reference(row.value),
                "reasons": row.reasons,
                "runs": [
                    {
                        "seed": seed,
                        "end": _end(one),
                        "numbers": numbers_of(one),
                        "page": pages.get((point.digest, seed)),
                        "command": _command(session, point, seed),
                    }
                    for seed, one in found.items()
                ],
            }
        )
    return {
        "name": part.name,
        "title": " ".join(part.title.split()),
        "vary": part.vary,
        "unit": summary.unit,
        "reference": "" if part.reference is None else part.reference.title,
        "measures": dict(_measures(summary)),
        "points": rows,
    }


def _measures(summary: PartSummary) -> Iterator[tuple[str, str]]:
    """Yield the measures that at least one run has, other than 0, and their labels."""
    for name in dict.fromkeys((*LABELS, *summary.told)):
        spreads = [row.figures[name] for row in summary.rows if name in row.figures]
        if any(spread.low or spread.high for spread in spreads):
            yield name, LABELS.get(name, name)


def _end(one: Measures) -> str:
    """Return how a run ended: empty if it completed all tasks."""
    if one.disaster is not None:
        return f"ended by the world: {one.disaster}"
    parts = []
    if one.given_up:
        parts.append(f"{one.given_up} given up")
    if one.pending:
        parts.append(f"{one.pending} pending ({one.reason})")
    return ", ".join(parts)


def _command(session: Batch, point: Point, seed: int) -> str:
    """Return the command that writes the page of a run."""
    return session.command(point, seed).replace("rapc run ", "rapc view ", 1)
