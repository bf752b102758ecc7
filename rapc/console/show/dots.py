"""Lines of small dots for terminals: eight in each cell, as Braille has them."""

from __future__ import annotations

from collections.abc import Iterator

DOTS = (2, 4)
"""How many dots a cell has across and down."""

_BLANK = 0x2800
"""The Braille character without dots; a bit is added for each."""
_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""The bit of each dot of a cell, by row and column."""


class Dots:
    """Dots to be set, row by row from the top; what falls outside is not drawn.

    A cell has the style of the dot in it that was given last.

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
        """Set the dots between two, or one in so many of them, and the last."""
        (column, row), (last_column, last_row) = start, end
        steps = max(abs(last_column - column), abs(last_row - row))
        for step in range(0, steps, every):
            across = round((last_column - column) * step / steps)
            down = round((last_row - row) * step / steps)
            self.dot(column + across, row + down, style)
        self.dot(last_column, last_row, style)

    def cells(self) -> Iterator[tuple[int, int, str, str]]:
        """Yield what is to be written: column, row, character, style."""
        for (column, row), (bits, style) in self._cells.items():
            yield column, row, chr(_BLANK + bits), style
