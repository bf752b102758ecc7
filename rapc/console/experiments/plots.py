"""Plots as SVG and PNG, like T figures 6.8 to 6.10, with matplotlib.

Only this module imports matplotlib, so who does without it imports it last. The same
results give the same bytes.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from rapc.console.experiments.tables import heading, show
from rapc.console.wrapping import wrapped
from rapc.experiments.summary import Summary

_STYLE: Any = {
    "svg.hashsalt": "rapc",
    "svg.fonttype": "path",
    "text.parse_math": False,
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
}

_COLORS = ("#1b5e8c", "#c0561a", "#3b7d3b", "#7a4f9a")
_THEIRS = "#555555"
_WIDTH = 80
_MARKERS = "osD^"


def draw(drawn: Sequence[Summary], file: Path) -> tuple[Path, Path]:
    """Draw parts that vary the same into one plot, the first one's name for title.

    Returns the files, `.svg` and `.png`: above the time for each task completed, with
    the range of the runs as bars, below how many tasks were completed.
    """
    with rc_context(_STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph")  # no font has all characters
        figure = Figure(figsize=(6.4, 5.6), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        figure.suptitle("\n".join(wrapped(heading(drawn[0].part), _WIDTH)))
        for number, summary in enumerate(drawn):
            _series(above, summary, number, "time-each")
            _series(below, summary, number, "completed")
        _frame(above, below, drawn[0])
        files = file.with_suffix(".svg"), file.with_suffix(".png")
        figure.savefig(files[0], metadata={"Date": None, "Creator": None})
        figure.savefig(files[1], dpi=150, metadata={"Software": None})
    return files


def _series(axes: Axes, summary: Summary, number: int, measure: str) -> None:
    """One part's averages with their ranges, and the figures from elsewhere."""
    places = _places(summary)
    known = [
        (place, row.figures[measure])
        for place, row in zip(places, summary.rows, strict=True)
        if measure in row.figures
    ]
    color = _COLORS[number % len(_COLORS)]
    below = [spread.mean - spread.low for _, spread in known]
    over = [spread.high - spread.mean for _, spread in known]
    axes.errorbar(
        [place for place, _ in known],
        [spread.mean for _, spread in known],
        yerr=(below, over),
        color=color,
        marker=_MARKERS[number % len(_MARKERS)],
        markersize=4,
        capsize=3,
        linewidth=1.3,
        elinewidth=0.9,
        label=f"{summary.part.name}: average, least and greatest",
    )
    _theirs(axes, summary, number, measure)


def _theirs(axes: Axes, summary: Summary, number: int, measure: str) -> None:
    told = [
        (place, figures[measure])
        for place, row in zip(_places(summary), summary.rows, strict=True)
        if measure in (figures := summary.reference(row.value))
    ]
    if told and summary.part.reference is not None:
        axes.plot(
            [place for place, _ in told],
            [figure for _, figure in told],
            color=_THEIRS,
            marker="x+*"[number % 3],
            markersize=8,
            linestyle="none",
            zorder=3,
            label=f"{summary.part.name}: {summary.part.reference.title}",
        )


def _places(summary: Summary) -> list[float]:
    """Return where the values are on the axis: at their number, or side by side."""
    values = [row.value for row in summary.rows]
    if all(_numeric(value) for value in values):
        return [float(value) for value in values if value is not None]
    return [float(place) for place in range(len(values))]


def _numeric(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _frame(above: Axes, below: Axes, summary: Summary) -> None:
    """Axes, their names, the mark, and the legend."""
    _, _, name = (summary.part.vary or "").partition(".")
    below.set_xlabel(f"{name} ({summary.unit})" if summary.unit else name)
    above.set_ylabel("time for each task completed")
    below.set_ylabel("tasks completed")
    values = [row.value for row in summary.rows]
    if not all(_numeric(value) for value in values):
        below.set_xticks(_places(summary), [show(value) for value in values])
    mark = summary.part.mark
    for axes in (above, below):
        axes.margins(y=0.1)
        axes.set_ylim(bottom=0)
        if mark is not None:
            axes.axvline(mark.at, color=_THEIRS, linestyle=":", linewidth=1)
    if mark is not None:
        above.plot(
            [mark.at],
            [0],
            marker="D",
            color="black",
            clip_on=False,
            linestyle="none",
            label=mark.label,
        )
    above.legend(fontsize=8)
