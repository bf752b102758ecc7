"""The page of long runs: its size, the times until it is ready and redrawn, readers."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.browser import browser, chromium
from bench.live import LIMIT, pairs, ratio
from bench.viewer import best, orders, write_page

pytestmark = [
    pytest.mark.nightly,
    pytest.mark.skipif(chromium() is None, reason="Chromium is not installed"),
    pytest.mark.xdist_group("browser"),
]


@pytest.mark.parametrize(
    ("times", "events", "ready", "redraw", "megabytes"),
    [(1, 48_500, 500, 50, 1.2), (10, 488_000, 4_000, 60, 10)],
)
def test_page_is_ready_and_redrawn_in_time(
    tmp_path: Path,
    times: int,
    events: int,
    ready: float,
    redraw: float,
    megabytes: float,
) -> None:
    file = tmp_path / "page.html"
    write_page([*orders(times)], file)
    with browser() as found:
        figures = best(found, file)
    assert figures.events >= events
    assert figures.requests == ()
    assert figures.megabytes <= megabytes
    assert figures.ready <= ready
    assert figures.longest <= redraw


def test_readers_do_not_slow_a_run() -> None:
    figures = pairs(5)
    assert ratio(figures) <= LIMIT
    for _, _, reader in figures:
        assert reader.events >= 488_000
        assert reader.rate >= 10_000
