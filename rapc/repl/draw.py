"""Format answers as lines of a given width, with or without colour.

A cell that is too wide is wrapped between words inside its column. If the longest words
of the columns do not fit side by side, each row is a block of several lines.
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

from rapc.base.values import readable_numbers
from rapc.base.visible import visible_lines
from rapc.debug.answer import Answer, Table, shown

_NUMBERS = (int, float)

_BEFORE = re.compile(r" *(?:[0-9.]+ +)?(?:(?:-->|\.\.\.) )?")
"""The prefix of a line: blanks, and the time and the mark of a trace."""

_LONGEST = 40
"""The greatest width of a word, often a path, that a table does not break."""

_GAPS = (3, 2)
"""The gaps between two columns of a table, in characters: preferred, smallest."""

_HANG = 2
"""The indentation of the further lines of a first cell."""


def draw(answer: Answer, width: int, *, color: bool) -> str:
    """Return an answer as text; each line ends with a line break.

    Long numbers are rounded to 6 decimals, except in RAP text.

    Args:
        answer: the answer.
        width: the width in characters.
        color: whether to use escape sequences for colours.
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
        _line(console, line if answer.is_code else readable_numbers(line), style)
    if answer.table is not None:
        _print_table(console, answer.table)
    for line in answer.notes:
        _line(console, readable_numbers(line), "")
    return "".join(_without_trailing_space(stream.getvalue(), color))


def _line(console: Console, line: str, style: str, *, deeper: int = 0) -> None:
    """Print a line; wrap a long line with the indentation of its text.

    The text of a trace line begins after the time and the mark.

    Args:
        console: the console to print to.
        line: the line.
        style: the style of the line.
        deeper: the extra indentation of further lines, in characters.
    """
    text = visible_lines(line)
    if len(text) <= console.width:
        console.print(Text(text, style=style), soft_wrap=True)
        return
    begun = _BEFORE.match(text)
    indent = min(begun.end() if begun else 0, console.width // 2)
    lead = " " * (indent + deeper)
    first, *rest = _folded(console, text[indent:], console.width - indent, deeper)
    for part in (text[:indent] + first, *(lead + part for part in rest)):
        console.print(Text(part, style=style), soft_wrap=True)


def _folded(console: Console, text: str, width: int, deeper: int) -> list[str]:
    """Return a text as wrapped lines; further lines are narrower by `deeper`."""
    first = Text(text).wrap(console, max(width, 1))[0].plain.rstrip()
    rest = Text(text[len(first) :].lstrip()).wrap(console, max(width - deeper, 1))
    return [first, *(part.plain for part in rest if part.plain)]


def _print_table(console: Console, table: Table) -> None:
    """Print a table without empty columns; if it is too wide, as blocks."""
    shows = [
        at
        for at in range(len(table.columns))
        if any(r[at] not in (None, "") for r in table.rows)
    ]
    cells = [
        [visible_lines(readable_numbers(shown(row[at]))) for at in shows]
        for row in table.rows
    ]
    names = [table.columns[at] for at in shows]
    columns = list(zip(names, *cells, strict=True))
    least = [
        max(_least_width(cell, first=at == 0) for cell in column)
        for at, column in enumerate(columns)
    ]
    gap = next((g for g in _GAPS if sum(least) <= _left(console, shows, g)), None)
    if gap is None and len(shows) > 1:
        _print_rows(console, names, cells)
        return
    wanted = [max(map(cell_len, column)) for column in columns]
    widths = _shared(least, wanted, _left(console, shows, gap or 0))
    drawn = RichTable(
        box=SIMPLE_HEAD,
        pad_edge=False,
        show_edge=False,
        collapse_padding=gap == min(_GAPS),
    )
    for at, name in enumerate(names):
        given = [row[shows[at]] for row in table.rows if row[shows[at]] is not None]
        numeric = bool(given) and all(isinstance(cell, _NUMBERS) for cell in given)
        justify: Literal["left", "right"] = "right" if numeric else "left"
        drawn.add_column(name, justify=justify, overflow="fold", no_wrap=numeric)
    for row in cells:
        parts = enumerate(zip(row, widths, strict=True))
        drawn.add_row(*[_wrapped(console, c, w, first=at == 0) for at, (c, w) in parts])
    console.print(Padding(drawn, 0))


def _left(console: Console, shows: Sequence[int], gap: int) -> int:
    """Return the total width of the columns, without gaps."""
    return console.width - gap * (len(shows) - 1)


def _least_width(cell: str, *, first: bool) -> int:
    """Return the least width of a column that breaks no word of a cell."""
    words = cell.split()
    indent = _indent(cell) + (_HANG if first and len(words) > 1 else 0)
    return indent + min(max(map(cell_len, words), default=0), _LONGEST)


def _shared(least: Sequence[int], wanted: Sequence[int], left: int) -> list[int]:
    """Return widths of columns that fit; the widest columns shrink first."""
    cap = min(max(wanted, default=0), left)
    while True:
        widths = [max(low, min(w, cap)) for low, w in zip(least, wanted, strict=True)]
        if sum(widths) <= left or cap <= 0:
            return widths
        cap -= 1


def _indent(text: str) -> int:
    return len(text) - len(text.lstrip(" "))


def _wrapped(console: Console, cell: str, width: int, *, first: bool) -> Text:
    """Return a cell wrapped to a width; lines after the first are indented."""
    if cell_len(cell) <= width:
        return Text(cell)
    indent = min(_indent(cell), width - 1)
    deeper = _HANG if first else 0
    lead = "\n" + " " * (indent + deeper)
    lines = _folded(console, cell[indent:], width - indent, deeper)
    return Text(cell[:indent] + lead.join(lines))


def _print_rows(
    console: Console, names: Sequence[str], cells: Sequence[Sequence[str]]
) -> None:
    """Print each row as a block: first cells, then one line a cell."""
    for at, row in enumerate(cells):
        if at and len(names) > 2:
            console.print()
        numbered = row[0].isdecimal()
        inline = numbered or not names[0] or len(names) == 2
        head = f"{names[0]} {row[0]}:" if numbered else row[0]
        head = f"{head} {row[1]}".rstrip() if inline else head
        _line(console, head, "", deeper=2 * _HANG)
        inner = " " * (_indent(row[0]) + _HANG)
        for name, cell in list(zip(names, row, strict=True))[1 + inline :]:
            if cell:
                said = f"{name}: {cell}" if name else cell
                _line(console, inner + said, "", deeper=_HANG)


def _without_trailing_space(text: str, color: bool) -> Iterator[str]:
    for line in text.splitlines():
        yield (line if color else line.rstrip()) + "\n"
