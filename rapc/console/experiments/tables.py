"""Tables of what was measured, like those of T 6.3: for a terminal and as Markdown.

A row for each point, ours, and below it the figures from elsewhere, if there are any.
Where a table is too wide for the terminal, its columns go below one another.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal

import msgspec

from rapc.base.values import format_atom
from rapc.experiments.definition import Part, Value
from rapc.experiments.measures import LABELS
from rapc.experiments.summary import Row, Spread, Summary

Kind = Literal["title", "head", "ours", "theirs", "text"]


class Line(msgspec.Struct, frozen=True):
    """A line of text with its kind, by which it is coloured."""

    kind: Kind
    text: str


class Grid(msgspec.Struct, frozen=True):
    """A table: a head, and rows of as many cells, ours or theirs."""

    head: tuple[str, ...]
    rows: tuple[tuple[Kind, tuple[str, ...]], ...]


_GAP = 2


def heading(part: Part) -> str:
    """What a part is called, in one line."""
    return " ".join(part.title.split()) or f"Part {part.name}"


def title(part: Part) -> str:
    """What a part is called, and by which name it is asked for."""
    return f"{heading(part)} (part `{part.name}`)" if part.title else heading(part)


def show(value: Value | None) -> str:
    """A value of what is varied, as it is printed."""
    if value is None:
        return "all"
    return format_atom(value) if not isinstance(value, bool) else str(value).lower()


def grid(summary: Summary) -> Grid:
    """The table of a part."""
    names = [LABELS.get(name, name) for name in summary.measures]
    at = summary.measures.index("time-each") + 1
    names.insert(at, "from-to")
    first = summary.part.vary or "point"
    rows: list[tuple[Kind, tuple[str, ...]]] = []
    for row in summary.rows:
        rows.append(("ours", _ours(row, summary.measures)))
        theirs = summary.reference(row.value)
        if theirs and summary.part.reference is not None:
            cells = [_cell(name, theirs.get(name)) for name in summary.measures]
            cells.insert(at, "")
            rows.append(("theirs", (summary.part.reference.title, "", "", *cells)))
    head = (first.partition(".")[2] or first, "runs", "disasters", *names)
    return Grid(head, tuple(rows))


def _ours(row: Row, measures: Sequence[str]) -> tuple[str, ...]:
    runs = str(row.runs) if row.runs == row.wanted else f"{row.runs}/{row.wanted}"
    cells = [show(row.value), runs, str(row.lost)]
    for name in measures:
        spread = row.figures.get(name)
        cells.append(_cell(name, float(spread.mean) if spread else None))
        if name == "time-each":
            cells.append(_range(spread))
    return tuple(cells)


def _range(spread: Spread | None) -> str:
    return f"{spread.low:.0f}-{spread.high:.0f}" if spread else "-"


def _cell(name: str, value: float | None) -> str:
    if value is None:
        return "-"
    if name in ("time", "time-each", "effector", "sensor"):
        return f"{value:.0f}"
    return f"{value:.1f}" if isinstance(value, float) else str(value)


def lines(made: Grid, width: int) -> Iterator[Line]:
    """The table for a width in columns: the first column comes with all others."""
    widths = [
        max(len(cell) for cell in column)
        for column in zip(made.head, *(cells for _, cells in made.rows), strict=True)
    ]
    for number, columns in enumerate(_split(widths, width)):
        if number:
            yield Line("text", "")
        yield Line("head", _line(made.head, widths, columns))
        for kind, cells in made.rows:
            if kind == "ours" or any(cells[column] for column in columns[1:]):
                yield Line(kind, _line(cells, widths, columns))


def _split(widths: Sequence[int], width: int) -> Iterator[list[int]]:
    """Columns that fit beside one another, each time after the first one."""
    columns, used = [0], widths[0]
    for column, wide in enumerate(widths[1:], 1):
        if len(columns) > 1 and used + _GAP + wide > width:
            yield columns
            columns, used = [0], widths[0]
        columns.append(column)
        used += _GAP + wide
    yield columns


def _line(cells: Sequence[str], widths: Sequence[int], columns: Sequence[int]) -> str:
    first, *others = columns
    shown = [f"{cells[first]:<{widths[first]}}"]
    shown += [f"{cells[column]:>{widths[column]}}" for column in others]
    return (" " * _GAP).join(shown).rstrip()


def markdown(made: Grid) -> Iterator[str]:
    """The table as Markdown."""
    yield _row(made.head)
    yield _row(["---", *["---:"] * (len(made.head) - 1)])
    for kind, cells in made.rows:
        shown = cells if kind == "ours" else [f"*{c}*" if c else c for c in cells]
        yield _row(shown)


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


_STOPPED = {
    "until": "stopped at the time `until`",
    "stuck": "stuck, for nothing could go on",
    "runaway": "called off, for the clock stood still",
}
"""What is said of runs that were over before their tasks were."""


_NAMED = 5
"""So many seeds of runs that ended alike are listed; the file of results has all."""


def remarks(summary: Summary) -> Iterator[str]:
    """What is to be said below a table: runs to look at, by their seeds, and notes."""
    for row in summary.rows:
        told = [*row.disasters.items()]
        told += [(_STOPPED[reason], seeds) for reason, seeds in row.stopped.items()]
        if told:
            where = (
                "Not ended well"
                if row.value is None
                else f"Not ended well at {show(row.value)}"
            )
            listed = ", ".join(f"{what} ({_seeds(seeds)})" for what, seeds in told)
            yield f"{where}: {listed}."
    yield from summary.part.notes


def _seeds(seeds: Sequence[int]) -> str:
    word = "seed" if len(seeds) == 1 else "seeds"
    listed = ", ".join(map(str, seeds[:_NAMED]))
    more = len(seeds) - _NAMED
    return f"{word} {listed}" + (f" and {more} more" if more > 0 else "")
