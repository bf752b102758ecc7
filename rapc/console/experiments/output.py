"""What a batch leaves in its folder besides the results: tables and commands.

Plots are drawn by `plots`, if matplotlib is there.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from pathlib import Path

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
from rapc.console.experiments.textplot import plot
from rapc.console.lines import Kind, Line, wrapped
from rapc.experiments.session import Batch
from rapc.experiments.summary import PartSummary

RESULTS = "results.sqlite"
TABLES = "tables.md"
TASKS = "tasks.md"
COMMANDS = "commands.txt"


def part_as_text(summary: PartSummary, width: int) -> Iterator[Line]:
    """A part for a terminal of so many columns: table, remarks and plot."""
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
    """Write the tables of parts as Markdown, with plots for those that were drawn."""
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
