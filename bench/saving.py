"""A whole run as bytes, and back in place: nine orders, enemies and others about.

The runs are those that `tests.runtime.saving` saves and takes up at random points.
"""

from __future__ import annotations

from collections.abc import Iterator

from bench.common import Figure, seconds
from tests.runtime.saving import Truck

SEED = 5
"""A run in which others move rocks about, and that lasts."""


def figures(quick: bool = False) -> Iterator[Figure]:
    """The time to save, to restore and to fork at some cycle of a run."""
    truck = Truck(SEED)
    cycles = 100 if quick else 3000
    for _ in range(cycles):
        truck.run.step()
    run, saved, size = truck.run, truck.run.save(), f"at cycle {cycles}"
    yield Figure("saving", "save", size, seconds(run.save) * 1e3, "ms")
    restored = seconds(lambda: run.restore(saved))
    yield Figure("saving", "restore in place", size, restored * 1e3, "ms")
    yield Figure("saving", "fork", size, seconds(run.fork) * 1e3, "ms")
    yield Figure("saving", "bytes", size, len(saved), "bytes")
