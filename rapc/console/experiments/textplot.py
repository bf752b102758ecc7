"""Plots for a terminal, in plain characters: ranges and averages on one scale.

15       |----o---x---|     811
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.console.experiments.tables import show
from rapc.console.lines import Line, wrapped
from rapc.experiments.summary import PartSummary, Spread

_LEAST = 10
"""How many columns a plot has at least."""


def plot(summary: PartSummary, width: int) -> Iterator[Line]:
    """The time for each task completed, against what the part varies (T 6.8 to 6.10).

    `|---|` is the range, `o` the average, `x` the figure from elsewhere. An average
    over runs of which some complete nothing can lie beyond the range of the others.
    """
    reference = summary.part.reference
    spreads = [row.figures.get("time-each") for row in summary.rows]
    theirs = [summary.reference(row.value).get("time-each") for row in summary.rows]
    known = [max(s.high, s.mean) for s in spreads if s]
    known += [t for t in theirs if t is not None]
    if not known:
        return
    labels = [show(row.value) for row in summary.rows]
    left = max(map(len, labels)) + 2
    room = max(width - left - 8, _LEAST)
    scale = (room - 1) / max(*known, 1)
    told = f", x {reference.title}" if reference and any(theirs) else ""
    head = f"time each: |---| range, o average{told}"
    yield from (Line("head", line) for line in wrapped(head, width))
    for label, spread, other in zip(labels, spreads, theirs, strict=True):
        bar = _bar(spread, other, room, scale)
        figure = f"{spread.mean:.0f}" if spread else "-"
        yield Line("text", f"{label:>{left - 2}}  {bar} {figure:>6}".rstrip())


def _bar(spread: Spread | None, other: float | None, room: int, scale: float) -> str:
    cells = [" "] * room
    if spread is not None:
        low, high = round(spread.low * scale), round(spread.high * scale)
        cells[low : high + 1] = "-" * (high + 1 - low)
        _put(cells, (low, high), "|")
        _put(cells, (round(spread.mean * scale),), "o")
    if other is not None:
        _put(cells, (round(other * scale),), "x")
    return "".join(cells)


def _put(cells: list[str], places: Sequence[int], mark: str) -> None:
    for place in places:
        cells[place] = mark
