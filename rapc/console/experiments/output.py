"""Files of a batch besides its results: tables and commands.

`plots` draws the plots, if matplotlib is installed.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from rapc.console.experiments.tables import (
    grid,
    markdown,
    part_title,
    remarks,
    rest,
    show,
    table_lines,
    tasks,
)
from rapc.console.lines import Kind, Line, wrapped
from rapc.experiments.session import Batch
from rapc.experiments.summary import PartSummary, Spread

RESULTS = "results.sqlite"
TABLES = "tables.md"
TASKS = "tasks.md"
COMMANDS = "commands.txt"


def part_as_text(summary: PartSummary, width: int) -> Iterator[Line]:
    """Yield a part for a terminal of a number of columns: table, remarks, plot."""
    yield from _wrapped("title", part_title(summary.part), width)
    yield from table_lines(grid(summary), width)
    for remark in remarks(summary):
        yield from _wrapped("text", remark, width)
    if summary.part.vary is not None:
        yield from plot(summary, width)


def _wrapped(kind: Kind, text: str, width: int) -> Iterator[Line]:
    return (Line(kind, line) for line in wrapped(text, width))


def write_tables(
    heading: str, summaries: Iterable[PartSummary], drawn: Container[str], file: Path
) -> None:
    """Write the tables of parts as Markdown, with links to the drawn plots."""
    text = [f"## {heading}"]
    for summary in summaries:
        text += ["", f"### {part_title(summary.part)}", "", *markdown(grid(summary))]
        text += ["", *markdown(rest(summary))]
        for remark in remarks(summary, None):
            text += ["", remark]
        if summary.part.name in drawn:
            text += ["", f"![{part_title(summary.part)}]({summary.part.name}.svg)"]
    file.write_text("\n".join(text) + "\n", encoding="utf-8")


def write_tasks(heading: str, summaries: Iterable[PartSummary], file: Path) -> None:
    """Write as Markdown when the tasks of each point came and were completed."""
    text = [f"## {heading}"]
    for summary in summaries:
        text += ["", f"### {part_title(summary.part)}"]
        for row in summary.rows:
            if row.value is not None:
                _, _, name = (summary.part.vary or "").partition(".")
                text += ["", f"{name} {show(row.value)}:"]
            text += ["", *markdown(tasks(row))]
    file.write_text("\n".join(text) + "\n", encoding="utf-8")


def write_commands(session: Batch, file: Path) -> None:
    """Write the command that repeats the first run of each point."""
    text = []
    for point in session.points:
        value = "" if point.value is None else f" {show(point.value)}"
        text += [
            f"# {point.part}{value}",
            session.command(point, session.seeds.start),
            "",
        ]
    file.write_text("\n".join(text), encoding="utf-8")


@contextmanager
def bar(
    what: str, total: int, stream: TextIO, *, shown: bool, color: bool
) -> Iterator[Callable[[int], None]]:
    """Show the progress of `total`, unless the bar is hidden.

    Yield a function to be called with each number of items done.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    console = Console(file=stream, no_color=not color)
    with Progress(
        *columns, console=console, transient=True, disable=not shown
    ) as progress:
        task = progress.add_task(what, total=total)
        yield lambda more: progress.advance(task, more)


# --- plots in plain characters -------------------------------------------------------
#
# 15       |----o---x---|     811

_LEAST = 10
"""The lowest number of columns of a plot."""


def plot(summary: PartSummary, width: int) -> Iterator[Line]:
    """Yield a plot of the time for each completed task (T 6.8 to 6.10).

    `|---|` is the range, `o` the average, `x` the figure from elsewhere. An average
    over runs without completed tasks can lie outside the range of the other runs.
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
