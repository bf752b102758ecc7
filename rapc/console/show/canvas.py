"""A sheet of characters with styles, on which maps are drawn."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from operator import itemgetter

from rich.cells import cell_len
from rich.text import Text

from rapc.console.lines import wrapped


class Canvas:
    """Rows of cells to draw on; a later drawing hides an earlier one.

    What falls outside is not drawn.
    """

    def __init__(self, width: int, height: int) -> None:
        self.width = width
        self.height = height
        self._cells = [[(" ", "")] * width for _ in range(height)]

    def write(self, column: int, row: int, text: str, style: str = "") -> None:
        """Write text of narrow characters from a cell on."""
        if 0 <= row < self.height:
            for at, character in enumerate(text, column):
                if 0 <= at < self.width:
                    self._cells[row][at] = (character, style)

    def line(self, start: tuple[int, int], end: tuple[int, int], style: str) -> None:
        """A line between two cells (column, row), dotted if it is a slanting one."""
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
        """The rows from the top."""
        for row in self._cells:
            line = Text()
            for style, cells in groupby(row, itemgetter(1)):
                line.append("".join(character for character, _ in cells), style or None)
            line.rstrip()
            yield line


def fit(text: str, width: int) -> str:
    """A text cut to a width in cells, with a mark where it was cut."""
    if cell_len(text) <= width:
        return text
    while text and cell_len(text) > width - 1:
        text = text[:-1]
    return f"{text}…" if width > 0 else ""


def folded(text: str, width: int, lines: int) -> list[str]:
    """Return a text in at most so many lines, with a mark where it was cut."""
    parts = wrapped(text, width) if width > 0 else []
    if len(parts) <= lines:
        return parts
    return [*parts[: lines - 1], fit(" ".join(parts[lines - 1 :]), width)]
