"""Answers drawn as lines of a given width, coloured or not.

Tables are drawn by rich, so that what is too wide is wrapped inside its column.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Sequence
from typing import Literal

from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import Console
from rich.padding import Padding
from rich.table import Table as RichTable
from rich.text import Text

from rapc.base.visible import visible_lines
from rapc.repl.answer import ShownAnswer, Table, shown

_NUMBERS = (int, float)

_BEFORE = re.compile(r" *(?:[0-9.]+ +)?(?:(?:-->|\.\.\.) )?")
"""What stands before the words of a line: blanks, the time and the mark of a trace."""

_LEAST = 10
"""How many columns of the terminal a column of a table needs to be read."""

_GAP = 3
"""How many of them lie between two."""


def draw(answer: ShownAnswer, width: int, *, color: bool) -> str:
    """Return an answer as text of lines that end, ready to be written.

    Args:
        answer: what is to be said.
        width: how many columns there are.
        color: whether escape sequences for colours are put in.
    """
    stream = io.StringIO()
    console = Console(
        file=stream,
        width=max(width, 20),
        force_terminal=color,
        color_system="standard" if color else None,
        no_color=not color,
        highlight=False,
        emoji=False,
        markup=False,
        legacy_windows=False,
    )
    style = "red" if answer.failed else ""
    for line in answer.lines:
        _line(console, line, style)
    if answer.table is not None:
        _print_table(console, answer.table)
    for line in answer.notes:
        _line(console, line, "")
    return "".join(_without_trailing_space(stream.getvalue(), color))


def _line(console: Console, line: str, style: str) -> None:
    """Print a line; what does not fit goes on below, set in as far as it began.

    What a trace tells begins behind its time and its mark.
    """
    text = visible_lines(line)
    if len(text) <= console.width:
        console.print(Text(text, style=style), soft_wrap=True)
        return
    begun = _BEFORE.match(text)
    indent = min(begun.end() if begun else 0, console.width // 2)
    lead = text[:indent]
    for part in Text(text[indent:]).wrap(console, console.width - indent):
        console.print(Text(f"{lead}{part.plain}", style=style), soft_wrap=True)
        lead = " " * indent


def _print_table(console: Console, table: Table) -> None:
    """Print a table without its empty columns; where it is too wide, row by row."""
    shows = [
        at
        for at in range(len(table.columns))
        if any(r[at] not in (None, "") for r in table.rows)
    ]
    cells = [[visible_lines(shown(row[at])) for at in shows] for row in table.rows]
    names = [table.columns[at] for at in shows]
    least = sum(
        min(max(cell_len(row[at]) for row in [names, *cells]), _LEAST) + _GAP
        for at in range(len(shows))
    )
    if least > console.width + _GAP and len(shows) > 2:
        _print_rows(console, names, cells)
        return
    drawn = RichTable(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, expand=False)
    for at, name in zip(shows, names, strict=True):
        given = [row[at] for row in table.rows if row[at] is not None]
        numeric = bool(given) and all(isinstance(cell, _NUMBERS) for cell in given)
        justify: Literal["left", "right"] = "right" if numeric else "left"
        drawn.add_column(name, justify=justify, overflow="fold", no_wrap=numeric)
    for row in cells:
        drawn.add_row(*[Text(cell) for cell in row])
    console.print(Padding(drawn, 0))


def _print_rows(
    console: Console, names: Sequence[str], cells: Sequence[Sequence[str]]
) -> None:
    """Print each row as a line of its first cells, and below it what else it has."""
    for row in cells:
        _line(console, f"{row[0]} {row[1]}".rstrip(), "")
        for name, cell in zip(names[2:], row[2:], strict=True):
            if cell:
                _line(console, f"  {name}: {cell}" if name else f"  {cell}", "")


def _without_trailing_space(text: str, color: bool) -> Iterator[str]:
    for line in text.splitlines():
        yield (line if color else line.rstrip()) + "\n"
