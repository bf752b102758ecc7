"""What a measurement beside the peers has found, as it is kept: figures, no judgement.

The peers' script tells of each measurement at length; here are its medians alone, with
what `bench.costs` finds in the same run, and the figures of peers that cannot be run
here, from elsewhere.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import msgspec

YARDSTICK = "hand"
"""The peer that tells how fast a machine is: plain Python, nothing installed."""

_MEMORY = "bytes_per_monitor"

_KEPT = (
    *("definitions_per_s", "first_sel", "all_sel", "first_broad"),
    *("per_solution_broad", "fire", _MEMORY, "tasks_per_s"),
)


class Measured(msgspec.Struct, frozen=True):
    """One peer at one size of a workload: medians by the names the script gives them.

    The size is a number of definitions, items or monitors, in W4 the depth of the
    tree; times are seconds.
    """

    workload: str
    peer: str
    size: int
    figures: dict[str, float]


class Results(msgspec.Struct, frozen=True):
    """Everything that was found.

    `elsewhere` are measurements from another time on a machine of the same kind;
    `costs` and `profiles` are from `bench.costs` and `bench.profiles`. `noise` is the
    median over all figures of the distance between a figure's extremes, as a share.
    """

    day: str
    machine: str
    versions: dict[str, str]
    noise: float
    measured: tuple[Measured, ...]
    elsewhere: tuple[Measured, ...]
    costs: dict[str, float]
    profiles: str
    #: Whether other jobs ran on the machine: then only ratios say something.
    shared: bool = False

    def sizes(self, workload: str, peer: str, figure: str) -> list[int]:
        """The sizes at which a peer has this figure, ascending."""
        return sorted(
            one.size
            for one in (*self.measured, *self.elsewhere)
            if one.workload == workload and one.peer == peer and figure in one.figures
        )

    def at(self, workload: str, peer: str, size: int, figure: str) -> float | None:
        """A figure; a time or rate from elsewhere as if taken on a machine like this.

        How fast this one is, the yardstick at the same size tells, here and there.
        """
        found = _find(self.measured, workload, peer, size, figure)
        if found is not None:
            return found
        found = _find(self.elsewhere, workload, peer, size, figure)
        if figure == _MEMORY:
            return found
        slowness = self.slowness(workload, size, figure)
        return None if found is None or slowness is None else found * slowness

    def slowness(self, workload: str, size: int, figure: str) -> float | None:
        """What the yardstick has here over what it has elsewhere."""
        here = _find(self.measured, workload, YARDSTICK, size, figure)
        there = _find(self.elsewhere, workload, YARDSTICK, size, figure)
        return None if here is None or there is None else here / there

    def is_from_elsewhere(self, peer: str) -> bool:
        """Whether a peer was not measured in this run."""
        return all(one.peer != peer for one in self.measured)


def from_script(told: Mapping[str, Any]) -> Iterator[Measured]:
    """The measurements in what the peers' script has written; failed ones have none."""
    for one in told["results"]:
        params = one["params"]
        figures = {
            name: value["median"] if isinstance(value, dict) else value
            for name, value in one["figures"].items()
            if name in _KEPT
        }
        size = params.get("n", params.get("d"))
        yield Measured(one["workload"], one["peer"], size, figures)


def spreads(told: Mapping[str, Any]) -> Iterator[float]:
    """How far the samples of each figure lie apart, as a share of its median."""
    for one in told["results"]:
        for value in one["figures"].values():
            if isinstance(value, dict) and "spread" in value:
                yield value["spread"]


def noise(told: Iterable[Mapping[str, Any]]) -> float:
    """The median of all spreads."""
    return statistics.median(share for part in told for share in spreads(part))


def _find(
    among: Iterable[Measured], workload: str, peer: str, size: int, figure: str
) -> float | None:
    for one in among:
        if (one.workload, one.peer, one.size) == (workload, peer, size):
            return one.figures.get(figure)
    return None
