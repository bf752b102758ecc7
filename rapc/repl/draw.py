"""Answers drawn as lines of a given width, coloured or not.

Tables are drawn by rich, so that what is too wide is wrapped inside its column.
"""

from __future__ import annotations

import io
from collections.abc import Iterator

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.padding import Padding
from rich.table import Table as RichTable
from rich.text import Text

from rapc.base.visible import visible_lines
from rapc.repl.answer import Answer, Table, shown

_NUMBERS = (int, float)


def draw(answer: Answer, width: int, *, color: bool) -> str:
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
        console.print(Padding(_table(answer.table), 0))
    for line in answer.notes:
        _line(console, line, "")
    return "".join(_without_trailing_space(stream.getvalue(), color))


def _line(console: Console, line: str, style: str) -> None:
    """Print a line; what does not fit goes on below, set in as far as it began."""
    text = visible_lines(line)
    bare = text.lstrip()
    indent = len(text) - len(bare)
    if len(text) <= console.width:
        console.print(Text(text, style=style), soft_wrap=True)
        return
    inner = Text(bare, style=style)
    hang = min(indent, console.width // 2)
    console.print(Padding(inner, (0, 0, 0, hang)))


def _table(table: Table) -> RichTable:
    drawn = RichTable(box=SIMPLE_HEAD, pad_edge=False, show_edge=False, expand=False)
    for at, name in enumerate(table.columns):
        cells = [row[at] for row in table.rows if row[at] is not None]
        numeric = bool(cells) and all(isinstance(cell, _NUMBERS) for cell in cells)
        drawn.add_column(
            name,
            justify="right" if numeric else "left",
            overflow="fold",
            no_wrap=numeric,
        )
    for row in table.rows:
        drawn.add_row(*[Text(visible_lines(shown(cell))) for cell in row])
    return drawn


def _without_trailing_space(text: str, color: bool) -> Iterator[str]:
    for line in text.splitlines():
        yield (line if color else line.rstrip()) + "\n"
