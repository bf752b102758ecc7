"""Plots as SVG and PNG, like T figures 6.8 to 6.10, with matplotlib.

Only this module imports matplotlib, so rapc works without it. Equal results give equal
bytes.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from rapc.console.experiments.tables import heading, show
from rapc.console.lines import wrapped
from rapc.experiments.definition import Reference
from rapc.experiments.summary import PartSummary, PointSummary

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
_ACTIONS = ("effector", "sensor", "failed")
"""The measures of the panel of actions."""
_LINES: tuple[Any, ...] = ("-", "--", ":", "-.", (0, (1, 5)), (0, (5, 5)))
"""The line styles of the measures in a panel."""
_CROSSES = {"effector": "x", "sensor": "+", "failed": "*"}
"""The markers of reference figures in the panel of actions."""


def draw_plot(drawn: Sequence[PartSummary], file: Path) -> tuple[Path, Path]:
    """Draw parts that vary the same setting into one plot, titled by the first.

    The top panel has the time for each completed task, the next panel the number of
    completed tasks. Below are the actions, the counted successes, and each figure of
    the world. Bars go from the tenth to the ninetieth of a hundred runs; points are
    means (of time: over all runs). Numbers from elsewhere are crosses; verbal ranges
    are thick bars. Return the files, `.svg` and `.png`.
    """
    with rc_context(_STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph")  # no font has all characters
        drawing = list(_panels(drawn))
        heights = [panel.height for panel in drawing]
        figure = Figure(figsize=(6.4, sum(heights) + 0.2), layout="constrained")
        panels = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
        figure.suptitle("\n".join(wrapped(heading(drawn[0].part), _WIDTH)))
        for axes, panel in zip(panels, drawing, strict=True):
            axes.set_ylabel(panel.called)
            for number, summary in enumerate(drawn):
                for at, measure in enumerate(panel.measures):
                    line = _LINES[at % len(_LINES)]
                    _series(axes, summary, number, measure, line)
        _frame(panels, drawn[0])
        files = file.with_suffix(".svg"), file.with_suffix(".png")
        figure.savefig(files[0], metadata={"Date": None, "Creator": None})
        figure.savefig(files[1], dpi=150, metadata={"Software": None})
    return files


class _Panel(NamedTuple):
    """A panel of a plot."""

    #: The name of its axis.
    called: str
    measures: Sequence[str]
    #: The height in inches.
    height: int


def _panels(drawn: Sequence[PartSummary]) -> Iterator[_Panel]:
    """Yield the panels of a plot; actions and counts that are all 0 have none."""
    yield _Panel("time for each task completed", ("time-each",), 3)
    yield _Panel("tasks completed", ("completed",), 2)
    told = dict.fromkeys(name for summary in drawn for name in summary.told)
    counted = {name for summary in drawn for name in summary.counted}
    for panel in (
        _Panel("actions", _ACTIONS, 3),
        _Panel("times that it happened", [n for n in told if n in counted], 3),
    ):
        if any(
            name in row.figures and row.figures[name].high
            for summary in drawn
            for row in summary.rows
            for name in panel.measures
        ):
            yield panel
    yield from (_Panel(name, (name,), 2) for name in told if name not in counted)


def _series(
    axes: Axes, summary: PartSummary, number: int, measure: str, line: Any = "-"
) -> None:
    """Draw one part's figures with their ranges, and the figures from elsewhere.

    Values that are not numbers have no order: no line connects them.
    """
    known = [
        (place, row.figures[measure])
        for place, row in _placed(summary)
        if measure in row.figures
    ]
    numbers = all(_numeric(row.value) for row in summary.rows)
    axes.errorbar(
        [place for place, _ in known],
        [spread.mean for _, spread in known],
        yerr=(
            [max(spread.mean - spread.tenth, 0) for _, spread in known],
            [max(spread.ninetieth - spread.mean, 0) for _, spread in known],
        ),
        color=_COLORS[number % len(_COLORS)],
        marker=_MARKERS[number % len(_MARKERS)],
        markersize=4,
        capsize=3,
        linestyle=line if numbers else "none",
        linewidth=1.3,
        elinewidth=0.9,
        label=_label(summary, measure),
    )
    _bounds(axes, summary, measure)
    _theirs(axes, summary, number, measure)


def _label(summary: PartSummary, measure: str) -> str:
    name = summary.part.name
    if measure in ("time-each", "completed"):
        return f"{name}: 10 to 90 % of runs"
    return f"{name}: {measure}"


def _theirs(axes: Axes, summary: PartSummary, number: int, measure: str) -> None:
    told = [
        (place, figures[measure])
        for place, row in _placed(summary)
        if measure in (figures := summary.reference(row.value))
    ]
    reference = summary.part.reference
    if told and reference is not None:
        axes.plot(
            [place for place, _ in told],
            [figure for _, figure in told],
            color=_THEIRS,
            marker="" if reference.least else _CROSSES.get(measure, "x+*"[number % 3]),
            markersize=8,
            linestyle="dashed" if reference.least else "none",
            linewidth=1,
            zorder=3,
            label=_theirs_called(summary, reference, measure),
        )


def _theirs_called(summary: PartSummary, reference: Reference, measure: str) -> str:
    title = reference.title
    if reference.least:
        return f"{summary.part.name}: {title}"
    told = measure if measure in _ACTIONS else "single runs"
    return f"{summary.part.name}: {title}, {told}"


def _bounds(axes: Axes, summary: PartSummary, measure: str) -> None:
    """Draw the verbal ranges from elsewhere, from low to high, as thick bars."""
    reference = summary.part.reference
    if reference is None:
        return
    bounds = reference.bounds.get(measure, ())
    places = {row.value: place for place, row in _placed(summary)}
    for number, (value, low, high) in enumerate(bounds):
        axes.vlines(
            places[value],
            low - 0.1,
            high + 0.1,
            color="#bbbbbb",
            linewidth=7,
            zorder=0,
            label="" if number else f"{reference.title}, as told",
        )


def _places(summary: PartSummary) -> list[float]:
    """Return the positions of the values on the axis: numbers, or side by side."""
    values = [row.value for row in summary.rows]
    if all(_numeric(value) for value in values):
        return [float(value) for value in values if value is not None]
    return [float(place) for place in range(len(values))]


def _placed(summary: PartSummary) -> Iterator[tuple[float, PointSummary]]:
    return zip(_places(summary), summary.rows, strict=True)


def _numeric(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _whole() -> MaxNLocator:
    """Set ticks at whole numbers, in round steps."""
    return MaxNLocator(integer=True, steps=[1, 2, 5, 10])


_LONG_LABEL = 33
"""The length of labels from which labels stand in two columns; three do not fit."""


def _frame(panels: Sequence[Axes], summary: PartSummary) -> None:
    """Draw the name of the common axis, the mark and the legends."""
    above, middle, below = panels[0], panels[1], panels[-1]
    _, _, name = (summary.part.vary or "").partition(".")
    below.set_xlabel(f"{name} ({summary.unit})" if summary.unit else name)
    values = [row.value for row in summary.rows]
    if not all(_numeric(value) for value in values):
        below.set_xticks(_places(summary), [show(value) for value in values])
    elif all(isinstance(value, int) for value in values):
        below.xaxis.set_major_locator(_whole())
    mark = summary.part.mark
    for axes in panels:
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
    middle.yaxis.set_major_locator(_whole())
    for axes in panels:
        _, labels = axes.get_legend_handles_labels()
        axes.legend(
            fontsize=7,
            loc="lower left",
            bbox_to_anchor=(0, 1),
            ncols=3 if max(map(len, labels), default=0) < _LONG_LABEL else 2,
            borderpad=0,
            columnspacing=1,
            handlelength=1.5,
        )
