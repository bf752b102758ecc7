"""rapc beside other systems: the results of one run of the peers' script, as a page.

The script that runs the peers is not ours; it takes `bench/rapc_adapter.py` into its
slot (`RAPC_ADAPTER`) and writes results with `--json`. What is made of them here: what
was aimed at and what came out, a table for each workload, and a chart.

    python -m bench.beside peers.json [--page PAGE.md] [--chart CHART.svg]
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import msgspec

BEGIN, END = "<!-- beside others: begin -->\n", "<!-- beside others: end -->\n"
"""Where the tables stand on a page; `--page` replaces what is between."""


class Panel(msgspec.Struct, frozen=True):
    """One workload's figure: what it is called, and where the results have it.

    `size` is the parameter that tells sizes apart; `scale` makes of the figure what
    `unit` counts.
    """

    title: str
    workload: str
    figure: str
    size: str
    scale: float
    unit: str


PANELS = (
    Panel("W1: definitions read", "W1", "definitions_per_s", "n", 1, "a second"),
    Panel("W2: first answer for a site", "W2", "first_sel", "n", 1e6, "us"),
    Panel("W2: all answers for a site", "W2", "all_sel", "n", 1e6, "us"),
    Panel("W3: one firing among monitors", "W3", "fire", "n", 1e6, "us"),
    Panel("W4: tasks of a tree", "W4", "tasks_per_s", "d", 1, "a second"),
    Panel("W5: memory of a monitor", "W3", "bytes_per_monitor", "n", 1, "bytes"),
)


class Results:
    """The results of a run, by workload, figure, peer and size."""

    def __init__(self, text: bytes) -> None:
        read = msgspec.json.decode(text)
        self.machine: Mapping[str, object] = read["machine"]
        self._rows: Sequence[Mapping[str, Any]] = read["results"]

    def value(self, panel: Panel, peer: str, size: int) -> float | None:
        """A figure, the median if it has samples; None where it was not measured."""
        for row in self._rows:
            if (row["workload"], row["peer"]) == (panel.workload, peer):
                found = row.get("figures", {}).get(panel.figure)
                if found is not None and row["params"][panel.size] == size:
                    median = found["median"] if isinstance(found, dict) else found
                    return float(median) * panel.scale
        return None

    def peers(self, panel: Panel) -> list[str]:
        """Who was measured in a panel, each once: ours first."""
        rows = (r for r in self._rows if r["workload"] == panel.workload)
        names = {r["peer"] for r in rows if panel.figure in r.get("figures", {})}
        return sorted(names, key=lambda name: (not name.startswith("rapc"), name))

    def sizes(self, panel: Panel) -> list[int]:
        """The sizes at which anybody was measured, from the smallest."""
        rows = (r for r in self._rows if r["workload"] == panel.workload)
        return sorted({r["params"][panel.size] for r in rows if "figures" in r})


# --- what was aimed at --------------------------------------------------------


OURS, TRACED = "rapc", "rapc-traced"


class Goal(msgspec.Struct, frozen=True):
    """What a figure, or the quotient of two, is to come to.

    `ours` and `other` are peer and size in the panel numbered `panel`; with `at_least`
    the quotient is not to be smaller than `bound`, else not larger. Without `other`
    the figure itself is meant.
    """

    text: str
    panel: int
    ours: tuple[str, int]
    other: tuple[str, int] | None
    bound: float
    at_least: bool = False

    def measured(self, results: Results) -> float | None:
        """What came out, or None where something was not measured."""
        panel = PANELS[self.panel]
        mine = results.value(panel, *self.ours)
        if mine is None or self.other is None:
            return mine
        theirs = results.value(panel, *self.other)
        return None if theirs is None else mine / theirs

    def reached(self, value: float) -> bool:
        """Whether what came out is good enough."""
        return value >= self.bound if self.at_least else value <= self.bound


_K = 1000
GOALS = (
    Goal("W1: read, of `hand+pos`", 0, (OURS, 5000), ("hand+pos", 5000), 0.9, True),
    Goal("W1: loaded, of `clips`", 0, ("rapc-load", 5000), ("clips", 5000), 1, True),
    Goal("W2: first, time of `swipl`", 1, (OURS, 10 * _K), ("swipl", 10 * _K), 1.5),
    Goal("W2: all, time of `swipl`", 2, (OURS, 10 * _K), ("swipl", 10 * _K), 1.5),
    Goal("W2: first, of `sqlite3`", 1, (OURS, 10 * _K), ("sqlite3", 10 * _K), 0.25),
    Goal("W2: all, of `sqlite3`", 2, (OURS, 10 * _K), ("sqlite3", 10 * _K), 0.25),
    Goal("W2: first, 100,000 to 1,000 items", 1, (OURS, 100 * _K), (OURS, _K), 2),
    Goal("W2: all, 100,000 to 1,000 items", 2, (OURS, 100 * _K), (OURS, _K), 2),
    Goal("W3: a firing at 10,000, us", 3, (OURS, 10 * _K), None, 5),
    Goal("W3: a firing, 100,000 to 10", 3, (OURS, 100 * _K), (OURS, 10), 1.5),
    Goal("W3: time of `py_trees`", 3, (OURS, 100 * _K), ("py_trees", 100 * _K), 5e-5),
    Goal("W3: traced, time of untraced", 3, (TRACED, 10 * _K), (OURS, 10 * _K), 2),
    Goal("W4: tasks a second", 4, (OURS, 8), None, 300 * _K, True),
    Goal("W4: tasks of `py_trees`", 4, (OURS, 8), ("py_trees", 8), 2.5, True),
    Goal("W4: tasks of `agentspeak`", 4, (OURS, 8), ("agentspeak", 8), 3, True),
    Goal("W4: traced, tasks of untraced", 4, (TRACED, 8), (OURS, 8), 0.5, True),
    Goal("W5: bytes of a monitor at 10,000", 5, (OURS, 10 * _K), None, 1200),
)  # fmt: skip


def goals(results: Results) -> Iterator[str]:
    """The goals as rows of a Markdown table, with what came out."""
    yield "| goal | bound | measured | |"
    yield "|---|---:|---:|---|"
    for goal in GOALS:
        value = goal.measured(results)
        if value is not None:
            sign = "at least" if goal.at_least else "at most"
            verdict = "reached" if goal.reached(value) else "not reached"
            bound = f"{sign} {_short(goal.bound)}"
            yield f"| {goal.text} | {bound} | {_short(value)} | {verdict} |"


# --- tables and chart ---------------------------------------------------------


def tables(results: Results) -> Iterator[str]:
    """A Markdown table for each panel in which anything was measured."""
    for panel in PANELS:
        peers, sizes = results.peers(panel), results.sizes(panel)
        if not peers:
            continue
        yield f"\n**{panel.title}**, {panel.unit}, by `{panel.size}`:\n"
        yield f"| system | {' | '.join(f'{size:,}' for size in sizes)} |"
        yield f"|---|{'---:|' * len(sizes)}"
        for peer in peers:
            values = (results.value(panel, peer, size) for size in sizes)
            cells = ("" if value is None else _short(value) for value in values)
            yield f"| `{peer}` | {' | '.join(cells)} |"


def _short(value: float) -> str:
    """Three figures that count, without a power of ten."""
    if value >= 100:
        return f"{value:,.0f}"
    return f"{value:.3g}" if value >= 0.001 else f"{value:.6f}".rstrip("0")


def draw(results: Results, chart: Path) -> None:
    """Draw the panels, a line for each system, as SVG; the same again for the same."""
    import matplotlib as mpl  # noqa: PLC0415  # heavy, and wanted for the chart only
    from matplotlib.artist import Artist  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    everyone = dict.fromkeys(name for p in PANELS for name in results.peers(p))
    others = sorted(name for name in everyone if not name.startswith("rapc"))
    with mpl.rc_context(
        {"svg.hashsalt": "beside", "svg.fonttype": "none", "font.size": 8}
    ):
        figure = Figure(figsize=(13, 8), layout="constrained")
        lines: dict[str, Artist] = {}
        for panel, ax in zip(PANELS, figure.subplots(2, 3).flat, strict=True):
            for peer in results.peers(panel):
                found = [
                    (s, results.value(panel, peer, s)) for s in results.sizes(panel)
                ]
                xs, ys = zip(*((s, v) for s, v in found if v), strict=True)
                look = _look(others, peer)
                [lines[peer]] = ax.plot(xs, ys, label=peer, markersize=4, **look)
            ax.set(
                yscale="log", title=panel.title, xlabel=panel.size, ylabel=panel.unit
            )
            if panel.size == "n":
                ax.set_xscale("log")
            else:
                ax.set_xticks(results.sizes(panel))
        known = [lines[name] for name in sorted(lines)]
        figure.legend(handles=known, loc="outside right center")
        figure.savefig(chart, format="svg", metadata={"Date": None})


def _look(others: Sequence[str], peer: str) -> dict[str, Any]:
    """How a system's line is drawn, the same in all panels: ours black and broad."""
    if peer not in others:
        return {"color": "black", "marker": "o" if peer == OURS else "s", "lw": 2}
    at = others.index(peer)
    return {"color": f"C{at % 10}", "marker": "ox^v"[at // 10 % 4], "lw": 0.8}


def put(page: str, text: str) -> str:
    """A page with the text between its marks. Raises ValueError without them."""
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError("the page has no marks to put tables between")
    return f"{before}{begin}{text}{end}{after}"


def main(args: Sequence[str] | None = None) -> None:
    """Read the command line, and print or write."""
    parser = argparse.ArgumentParser(description="rapc beside other systems.")
    parser.add_argument("results", type=Path, help="what the peers' script wrote")
    parser.add_argument("--page", type=Path, help="page to put the tables into")
    parser.add_argument("--chart", type=Path, help="SVG file to draw")
    given = parser.parse_args(args)
    results = Results(given.results.read_bytes())
    machine = ", ".join(f"{name} {value}" for name, value in results.machine.items())
    lines = [f"Measured in one run; {machine}.\n", *goals(results), *tables(results)]
    text = "\n".join(lines) + "\n"
    if given.page is not None:
        page = put(given.page.read_text(encoding="utf-8"), text)
        given.page.write_text(page, encoding="utf-8")
    else:
        print(text, end="")
    if given.chart is not None:
        draw(results, given.chart)


if __name__ == "__main__":
    main()
