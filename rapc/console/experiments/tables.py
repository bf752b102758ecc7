"""Tables of measures, like those of T 6.3: for a terminal and as Markdown.

A table has a row for each point; figures from elsewhere are in the cells of the
measured figures. If a table is too wide for the terminal, its columns are split over
several tables.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import msgspec

from rapc.base.values import format_atom, typed
from rapc.console.lines import Line
from rapc.experiments.definition import Series
from rapc.experiments.draws import Value
from rapc.experiments.measures import LABELS
from rapc.experiments.summary import PartSummary, PointSummary, Spread


class Grid(msgspec.Struct, frozen=True):
    """A table: a head, and rows with an equal number of cells."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


_GAP = 2


def heading(part: Series) -> str:
    """Return the title of a part, in one line."""
    return " ".join(part.title.split()) or f"Part {part.name}"


def part_title(part: Series) -> str:
    """Return the title of a part, and its name for options."""
    return f"{heading(part)} (part `{part.name}`)" if part.title else heading(part)


def show(value: Value | None) -> str:
    """Return a value of the varied setting as text."""
    return "all" if value is None else typed(value)


def grid(summary: PartSummary) -> Grid:
    """Return the main table of a part: means, deviations, reference figures.

    `437 ± 36 / 441` is the measured mean, its standard deviation, and the reference;
    `!` marks a reference more than two standard deviations from the mean.
    """
    names = [*_MAIN, *summary.told]
    head = (*_head(summary), *[LABELS.get(name, name) for name in names])
    return Grid(head, tuple([_main(row, summary, names) for row in summary.rows]))


def rest(summary: PartSummary) -> Grid:
    """Return the table of the other measures of a part, as means.

    Missed deadlines and faults in queries are listed if there were any.
    """
    names = [
        name
        for name in LABELS
        if name not in _MAIN and (name not in _RARE or _occurs(summary, name))
    ]
    head = (*_head(summary), "from-to", *[LABELS[name] for name in names])
    rows = []
    for row in summary.rows:
        cells = [_with_theirs(name, row, summary) for name in names]
        rows.append((*_first(row), _range(row.figures.get("time-each")), *cells))
    return Grid(head, tuple(rows))


_MAIN = ("time-each", "completed", "effector", "sensor", "failed")
_RARE = ("missed-deadlines", "query-faults")


def _occurs(summary: PartSummary, name: str) -> bool:
    rows = (row.figures.get(name) for row in summary.rows)
    return any(spread is not None and spread.high > 0 for spread in rows)


def _head(summary: PartSummary) -> tuple[str, str, str]:
    first = summary.part.vary or "point"
    return (first.partition(".")[2] or first, "runs", "disasters")


def _first(row: PointSummary) -> tuple[str, str, str]:
    runs = str(row.runs) if row.runs == row.wanted else f"{row.runs}/{row.wanted}"
    return (show(row.value), runs, str(row.lost))


def _main(
    row: PointSummary, summary: PartSummary, names: Sequence[str]
) -> tuple[str, ...]:
    theirs, reference = summary.reference(row.value), summary.part.reference
    least = reference is not None and reference.least
    cells = []
    for name in names:
        spread = row.figures.get(name)
        cell = _cell(name, spread.mean if spread else None)
        known = spread is not None and row.runs - row.lost > 1
        if known and spread is not None and name in _MAIN:
            cell += f" ± {_cell(name, spread.deviation)}"
        if name in theirs:
            cell += f" / {_theirs(name, theirs[name])}"
            far = known and spread is not None and _far(spread, theirs[name])
            if far and not least:
                cell += " !"
        cells.append(cell)
    return (*_first(row), *cells)


def _far(spread: Spread, theirs: float) -> bool:
    return abs(theirs - spread.mean) > 2 * spread.deviation + 1e-9


def _with_theirs(name: str, row: PointSummary, summary: PartSummary) -> str:
    spread = row.figures.get(name)
    cell = _cell(name, spread.mean if spread else None)
    theirs = summary.reference(row.value).get(name)
    return cell if theirs is None else f"{cell} / {_theirs(name, theirs)}"


def _range(spread: Spread | None) -> str:
    return f"{spread.low:.0f}-{spread.high:.0f}" if spread else "-"


_WHOLE = ("time", "time-each", "task-time", "effector", "sensor")
"""Measures without decimals."""


def _cell(name: str, value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.0f}" if name in _WHOLE else f"{value:.1f}"


def _theirs(name: str, value: float) -> str:
    return f"{value:.0f}" if name in _WHOLE else format_atom(value)


def tasks(row: PointSummary) -> Grid:
    """Return the table of the tasks of one point, in the order of arrival."""
    head = ("task", "runs", "came", "completed", "at", "given up")
    rows = []
    for number, task in enumerate(row.tasks, 1):
        at = "-" if task.ended is None else f"{task.ended.mean:.0f}"
        if task.ended is not None and task.completed > 1:
            at += f" ± {task.ended.deviation:.0f}"
        counts = (str(task.completed), at, str(task.given_up))
        name = task.goal or f"number {number}"
        rows.append((name, str(task.runs), f"{task.came.mean:.0f}", *counts))
    return Grid(head, tuple(rows))


def table_lines(made: Grid, width: int) -> Iterator[Line]:
    """Yield the table for a width in columns, each part with the first column."""
    widths = [
        max(len(cell) for cell in column)
        for column in zip(made.head, *made.rows, strict=True)
    ]
    for number, columns in enumerate(_split(widths, width)):
        if number:
            yield Line("text", "")
        yield Line("head", _line(made.head, widths, columns))
        yield from (Line("text", _line(cells, widths, columns)) for cells in made.rows)


def _split(widths: Sequence[int], width: int) -> Iterator[list[int]]:
    """Yield the groups of columns that fit side by side, after the first column."""
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
    """Yield the table as Markdown."""
    yield _row(made.head)
    yield _row(["---", *["---:"] * (len(made.head) - 1)])
    yield from map(_row, made.rows)


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


_STOPPED = {
    "until": "stopped at the time `until`",
    "stuck": "stuck: no task could continue",
    "runaway": "stopped: the clock did not move",
}
"""The texts for runs that ended before their tasks."""


_NAMED = 5
"""The highest number of seeds in a list; the file of results has all seeds."""


_REASONS = 3
"""The highest number of reasons of failure for a point on a terminal."""


def remarks(summary: PartSummary, most: int | None = _REASONS) -> Iterator[str]:
    """Yield the remarks below a table: legend, runs to look at, notes.

    Args:
        summary: the part.
        most: how many reasons of failure to list for a point; None: all.
    """
    reference = summary.part.reference
    if reference is not None:
        behind = (
            f"Ours with the standard deviation, {reference.title} behind the stroke"
        )
        far = "; ! where that lies more than two deviations from our mean"
        yield f"{behind}{'' if reference.least else far}."
    for row in summary.rows:
        at = "" if row.value is None else f" at {show(row.value)}"
        told = [*row.disasters.items()]
        told += [(_STOPPED[reason], seeds) for reason, seeds in row.stopped.items()]
        if told:
            listed = ", ".join(f"{what} ({_seeds(seeds)})" for what, seeds in told)
            yield f"Not ended well{at}: {listed}."
        yield from _reasons(row, at, most)
    yield from summary.part.notes


def _reasons(row: PointSummary, at: str, most: int | None) -> Iterator[str]:
    """Yield why tasks failed, the most frequent reason first."""
    listed = [*row.reasons.items()][:most]
    if listed:
        told = "; ".join(f"{number} by {reason}" for reason, number in listed)
        more = sum(row.reasons.values()) - sum(number for _, number in listed)
        yield f"Given up{at}: {told}" + (f"; {more} more." if more else ".")


def _seeds(seeds: Sequence[int]) -> str:
    word = "seed" if len(seeds) == 1 else "seeds"
    listed = ", ".join(map(str, seeds[:_NAMED]))
    more = len(seeds) - _NAMED
    return f"{word} {listed}" + (f" and {more} more" if more > 0 else "")
