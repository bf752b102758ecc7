"""The figures beside the peers as a chart: a panel for each workload, and growth.

Bars have a logarithmic scale. Ours are blue; yardsticks, which are no systems, are
light; what was measured elsewhere is hatched. A dotted line is what rapc is to reach.
Only this module imports matplotlib, so who does without it imports it last.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import msgspec
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from bench.common import short
from bench.results import Results

_STYLE: Any = {
    "svg.hashsalt": "rapc",
    "svg.fonttype": "path",
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "hatch.linewidth": 0.6,
}

_OURS, _OTHERS, _LIGHT = "#1b5e8c", "#9a9a9a", "#dcdcdc"
_LINES = ("#c0561a", "#3b7d3b", "#7a4f9a", "#8a6d1d", "#444444", "#b0306a", "#2a8a8a")
_HATCH = "////"


class Panel(msgspec.Struct, frozen=True):
    """One workload at one size: what is told, its figures times `scale`, in `unit`."""

    title: str
    workload: str
    figure: str
    size: int
    axis: str
    unit: str
    scale: float = 1
    target: float | None = None

    @property
    def more_is_better(self) -> bool:
        """Whether the figure is a rate."""
        return self.figure.endswith("_per_s")


PANELS = (
    Panel(
        "W1: 5,000 definitions are read",
        *("W1", "definitions_per_s", 5000, "definitions a second", "/s"),
    ),
    Panel(
        "W2: all answers for a site, of 10,000 items",
        *("W2", "all_sel", 10_000, "microseconds", " us", 1e6),
    ),
    Panel(
        "W3: one firing among 100,000 monitors",
        *("W3", "fire", 100_000, "microseconds", " us", 1e6, 5),
    ),
    Panel(
        "W4: a tree of 9,841 tasks",
        *("W4", "tasks_per_s", 8, "tasks a second", "/s", 1, 300_000),
    ),
    Panel(
        "W5: memory of a dormant task, of 10,000",
        *("W3", "bytes_per_monitor", 10_000, "bytes", "", 1, 1200),
    ),
)


def draw(results: Results, file: Path) -> tuple[Path, Path]:
    """Draw it all; returns the files, `.svg` and `.png`."""
    with rc_context(_STYLE):
        figure = Figure(figsize=(10.4, 10.6), layout="constrained")
        axes = figure.subplots(3, 2).flat
        for place, panel in zip(axes, PANELS, strict=False):
            _bars(place, panel, results)
        _growth(axes[-1], results)
        figure.suptitle("rapc beside other systems, measured in one run", size=12)
        figure.legend(handles=_keys(), loc="outside lower center", ncols=5, fontsize=8)
        files = file.with_suffix(".svg"), file.with_suffix(".png")
        figure.savefig(files[0], metadata={"Date": None, "Creator": None})
        figure.savefig(files[1], dpi=110, metadata={"Software": None})
    return files


def _is_ours(peer: str) -> bool:
    return peer.startswith("rapc")


def _look(results: Results, peer: str) -> dict[str, Any]:
    """How a peer's bar is drawn."""
    if _is_ours(peer):
        return {"color": _OURS}
    if peer.startswith("hand"):
        return {"facecolor": _LIGHT, "edgecolor": _OTHERS}
    if results.is_from_elsewhere(peer):
        return {"facecolor": "white", "edgecolor": _OTHERS, "hatch": _HATCH}
    return {"color": _OTHERS}


def _keys() -> list[Any]:
    return [
        Patch(color=_OURS, label="rapc"),
        Patch(color=_OTHERS, label="other systems"),
        Patch(facecolor=_LIGHT, edgecolor=_OTHERS, label="yardsticks (by hand)"),
        Patch(
            facecolor="white",
            edgecolor=_OTHERS,
            hatch=_HATCH,
            label="measured elsewhere, scaled",
        ),
        Patch(facecolor="none", edgecolor="black", linestyle=":", label="target"),
    ]


def _bars(axes: Axes, panel: Panel, results: Results) -> None:
    """The best peer on top; none that has no figure, or a figure of nothing."""
    found = _found(panel, results)
    found.sort(reverse=not panel.more_is_better)
    peers = [peer for _, peer in found]
    for row, (value, peer) in enumerate(found):
        axes.barh(row, value, height=0.72, linewidth=0.8, **_look(results, peer))
        axes.annotate(
            short(value) + panel.unit,
            (value, row),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            fontsize=8,
            fontweight="bold" if _is_ours(peer) else "normal",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5},
        )
    axes.set_yticks(range(len(peers)), peers)
    for label in axes.get_yticklabels():
        if _is_ours(label.get_text()):
            label.set_fontweight("bold")
    _scale(axes, panel, [value for value, _ in found])


def _found(panel: Panel, results: Results) -> list[tuple[float, str]]:
    names = {one.peer for one in (*results.measured, *results.elsewhere)}
    found = []
    for peer in sorted(names):
        value = results.at(panel.workload, peer, panel.size, panel.figure)
        if value:
            found.append((value * panel.scale, peer))
    return found


def _scale(axes: Axes, panel: Panel, values: Sequence[float]) -> None:
    """A title, a scale with room for the figures behind the bars, and the target."""
    axes.set_xscale("log")
    if values:
        axes.set_xlim(min(values) / 2.5, max(values) * 12)
    if panel.target is not None:
        axes.axvline(panel.target, color="black", linestyle=":", linewidth=1)
    better = "longer" if panel.more_is_better else "shorter"
    axes.set_xlabel(f"{panel.axis} ({better} is better)")
    axes.set_title(panel.title)
    axes.tick_params(axis="y", length=0)


def _growth(axes: Axes, results: Results) -> None:
    """The time of one firing by the number of monitors, a line for each peer."""
    names = {one.peer for one in (*results.measured, *results.elsewhere)}
    colors = iter(_LINES * len(names))
    for peer in sorted(names):
        sizes = results.sizes("W3", peer, "fire")
        points = [(n, results.at("W3", peer, n, "fire")) for n in sizes]
        known = [(n, seconds * 1e6) for n, seconds in points if seconds is not None]
        if known:
            color = _OURS if _is_ours(peer) else next(colors)
            dashed = "--" if results.is_from_elsewhere(peer) else "-"
            _line(axes, peer, known, color, dashed)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("monitors asleep")
    axes.set_ylabel("microseconds")
    axes.set_title("W3: one firing, by the number of monitors")


def _line(
    axes: Axes, peer: str, points: Sequence[tuple[int, float]], color: str, style: str
) -> None:
    """A peer's line, with its name where it ends."""
    ours = _is_ours(peer)
    axes.plot(
        [n for n, _ in points],
        [value for _, value in points],
        color=color,
        linewidth=2.2 if ours else 1.1,
        linestyle=style,
        marker="o" if ours else ".",
        markersize=4,
    )
    axes.annotate(
        peer,
        points[-1],
        xytext=(5, 0),
        textcoords="offset points",
        va="center",
        color=color,
        fontsize=8,
        fontweight="bold" if ours else "normal",
        annotation_clip=False,
    )
