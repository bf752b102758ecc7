"""Answers to commands: lines of text and tables, for people and for programs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import msgspec

from rapc.base.values import format_atom, number

Cell = str | int | float | None
"""What a cell of a table holds; None is shown as nothing."""


class Table(msgspec.Struct, frozen=True):
    """Rows under headings."""

    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


class ShownAnswer(msgspec.Struct, frozen=True):
    """What a command has to say."""

    #: Lines before the table.
    lines: tuple[str, ...] = ()
    table: Table | None = None
    #: Lines after the table.
    notes: tuple[str, ...] = ()
    #: Whether the command could not be carried out.
    failed: bool = False
    #: Whether the lines are RAP text.
    is_code: bool = False

    def record(self) -> dict[str, Any]:
        """Return the answer as an object for programs: its keys are stable."""
        found: dict[str, Any] = {
            "failed": self.failed,
            "lines": [*self.lines, *self.notes],
        }
        if self.table is not None:
            columns = self.table.columns
            found["rows"] = [
                dict(zip(columns, row, strict=True)) for row in self.table.rows
            ]
        return found


def say(*lines: str) -> ShownAnswer:
    """Return an answer of some lines."""
    return ShownAnswer(lines)


def failure(*lines: str) -> ShownAnswer:
    """Return an answer that says why a command could not be carried out."""
    return ShownAnswer(lines, failed=True)


def table(
    columns: Sequence[str],
    rows: Iterable[Iterable[object]],
    *lines: str,
    none: str = "nothing",
    notes: Sequence[str] = (),
) -> ShownAnswer:
    """Return an answer with a table, or the words for `none` where it has no rows.

    Numbers are rounded to twelve digits: 0.1 + 0.2 is 0.3 to whoever reads a table, and
    1e-25 is not 0. Values that are not symbols or numbers are written as RAP text.
    """
    made = tuple([tuple(map(_cell, row)) for row in rows])
    if not made:
        return ShownAnswer((*lines, none), notes=tuple(notes))
    return ShownAnswer(lines, Table(tuple(columns), made), tuple(notes))


def _cell(value: object) -> Cell:
    if isinstance(value, float):
        return number(float(f"{value:.12g}"))
    return (
        value if value is None or isinstance(value, str | int) else format_atom(value)
    )


def shown(cell: Cell) -> str:
    """Return a cell as text."""
    if cell is None:
        return ""
    return cell if isinstance(cell, str) else format_atom(cell)
