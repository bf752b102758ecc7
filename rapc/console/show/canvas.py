"""Canvases for maps: of characters with styles, and of small dots.

A cell of a terminal has eight dots, in the form of Braille.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter

from rich.cells import cell_len
from rich.text import Text

from rapc.console.lines import wrapped

DOTS = (2, 4)
"""The number of dots of a cell, across and down."""

_BLANK = 0x2800
"""The Braille character without dots; each dot adds a bit."""
_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""The bit of each dot of a cell, by row and column."""


class Canvas:
    """Rows of cells to draw on; a later drawing hides an earlier drawing.

    Parts outside the canvas are not drawn.
    """

    def __init__(self, width: int, height: int) -> None:
        self.width = width
        self.height = height
        self._cells = [[(" ", "")] * width for _ in range(height)]

    def write(self, column: int, row: int, text: str, style: str = "") -> None:
        """Write text of narrow characters, from a cell on."""
        if 0 <= row < self.height:
            for at, character in enumerate(text, column):
                if 0 <= at < self.width:
                    self._cells[row][at] = (character, style)

    def line(self, start: tuple[int, int], end: tuple[int, int], style: str) -> None:
        """Draw a line between two cells (column, row), dotted if slanting."""
        (column, row), (last_column, last_row) = start, end
        across, down = last_column - column, last_row - row
        if down == 0:
            self.write(min(column, last_column), row, "─" * (abs(across) + 1), style)
            return
        mark = "│" if across == 0 else "·"
        for step in range(abs(down) + 1):
            at = column + round(across * step / abs(down))
            self.write(at, row + (step if down > 0 else -step), mark, style)

    def lines(self) -> Iterator[Text]:
        """Return the rows from the top."""
        for row in self._cells:
            line = Text()
            for style, cells in groupby(row, itemgetter(1)):
                line.append("".join(character for character, _ in cells), style or None)
            line.rstrip()
            yield line


class Dots:
    """Dots to be set, row by row from the top; dots outside are ignored.

    A cell has the style of its latest dot.

    Args:
        width: in cells.
        height: in cells.
    """

    def __init__(self, width: int, height: int) -> None:
        self.width = width * DOTS[0]
        self.height = height * DOTS[1]
        self._cells: dict[tuple[int, int], tuple[int, str]] = {}

    def dot(self, column: int, row: int, style: str) -> None:
        """Set a dot."""
        if 0 <= column < self.width and 0 <= row < self.height:
            cell = (column // DOTS[0], row // DOTS[1])
            bit = _BITS[row % DOTS[1]][column % DOTS[0]]
            self._cells[cell] = (self._cells.get(cell, (0, ""))[0] | bit, style)

    def line(
        self, start: tuple[int, int], end: tuple[int, int], style: str, every: int = 1
    ) -> None:
        """Set the dots of a line, all or at intervals, and its last dot."""
        (column, row), (last_column, last_row) = start, end
        steps = max(abs(last_column - column), abs(last_row - row))
        for step in range(0, steps, every):
            across = round((last_column - column) * step / steps)
            down = round((last_row - row) * step / steps)
            self.dot(column + across, row + down, style)
        self.dot(last_column, last_row, style)

    def cells(self) -> Iterator[tuple[int, int, str, str]]:
        """Yield the cells with dots: column, row, character, style."""
        for (column, row), (bits, style) in self._cells.items():
            yield column, row, chr(_BLANK + bits), style


def fit(text: str, width: int) -> str:
    """Return a text cut to a width in cells, with a mark at the cut."""
    if cell_len(text) <= width:
        return text
    while text and cell_len(text) > width - 1:
        text = text[:-1]
    return f"{text}…" if width > 0 else ""


def folded(text: str, width: int, lines: int) -> list[str]:
    """Return a text in at most a number of lines, with a mark at the cut."""
    parts = wrapped(text, width) if width > 0 else []
    if len(parts) <= lines:
        return parts
    return [*parts[: lines - 1], fit(" ".join(parts[lines - 1 :]), width)]
