"""Names of spaces on a plan: line breaks of a name, and its cells.

A name stands across, downwards, or in several rows broken at hyphens. Of all positions
in its space it takes the first without overlap, then the position with the least
overlap, then the nearest to the middle. A name that does not fit is cut; a number
replaces a name of which fewer than `LEAST` letters would be left.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

from rapc.console.show.canvas import fit

LEAST = 4
"""The lowest number of cells of a name that is cut."""

Cell = tuple[int, int]
"""Column and row."""

Rows = Sequence[tuple[int, int, str]]
"""The position of rows of text, and the text: column, row, text."""


class Inside(NamedTuple):
    """The cells inside the walls of a space."""

    first: int
    upper: int
    wide: int
    high: int


class Taken(NamedTuple):
    """Cells that a name must not cover."""

    #: Cells of agents and signs.
    signs: Collection[Cell]
    #: Cells of walls and blocks, and cells beside signs.
    others: Collection[Cell]


def label(name: str, inside: Inside, taken: Taken, *, marked: bool) -> Rows | None:
    """Return a name as placed rows, or None if a number must replace it.

    Args:
        name: the name of the space.
        inside: the space.
        taken: the cells not to be covered.
        marked: whether the name stands in brackets, which may cover walls.
    """
    best: tuple[tuple[int, int], Rows] | None = None
    for order, shape in enumerate(_shapes(name, inside)):
        covered, rows = _place(shape, inside, taken, marked=marked)
        if best is None or (covered, order) < best[0]:
            best = (covered, order), rows
        if covered == 0:
            break
    return best[1] if best else None


def numbered(number: str, inside: Inside, taken: Taken, *, marked: bool) -> Rows:
    """Return the position of a number in a space."""
    return _place([number], inside, taken, marked=marked)[1]


def _shapes(name: str, inside: Inside) -> Iterator[Sequence[str]]:
    """Yield the rows into which a name can be broken, the best first.

    A name that stands downwards has a row for each letter.
    """
    _, _, wide, high = inside
    if len(name) <= wide:
        yield [name]
    if wide < high and len(name) <= high:
        yield list(name)
    rows = _at_hyphens(name, wide)
    if 1 < len(rows) <= high and all(len(row) <= wide for row in rows):
        yield rows
    if high <= wide and len(name) <= high:
        yield list(name)
    cut = [list(fit(name, high))] if high >= LEAST else []
    cut += [[fit(name, wide)]] if wide >= LEAST else []
    yield from cut if high > wide else reversed(cut)


def _at_hyphens(name: str, wide: int) -> list[str]:
    rows = [""]
    for part in name.replace("-", "-\0").split("\0"):
        if len(rows[-1] + part) > wide and rows[-1]:
            rows.append("")
        rows[-1] += part
    return rows


def _place(
    shape: Sequence[str], inside: Inside, taken: Taken, *, marked: bool
) -> tuple[int, Rows]:
    """Return the best position of a shape, and the number of signs it covers."""
    best: tuple[tuple[int, int, int], Rows] | None = None
    for distance, corner in _corners(shape, inside):
        rows = list(_rows(shape, corner, marked=marked))
        cells = [(c + at, row) for c, row, text in rows for at in range(len(text))]
        covered = sum(cell in taken.signs for cell in cells)
        rated = covered, sum(cell in taken.others for cell in cells), distance
        if best is None or rated < best[0]:
            best = rated, rows
        if not any(rated[:2]):
            break
    assert best is not None
    return best[0][0], best[1]


def _corners(shape: Sequence[str], inside: Inside) -> list[tuple[int, Cell]]:
    """Return the first cells of a shape, sorted by distance from the middle."""
    across, down = inside.wide - max(map(len, shape)), inside.high - len(shape)
    return sorted(
        (
            abs(column - across // 2) + 2 * abs(row - down // 2),
            (inside.first + column, inside.upper + row),
        )
        for column in (range(across + 1) if across > 0 else [across // 2])
        for row in (range(down + 1) if down > 0 else [down // 2])
    )


def _rows(shape: Sequence[str], corner: Cell, *, marked: bool) -> Rows:
    column, row = corner
    if not marked:
        return [(column, row + down, text) for down, text in enumerate(shape)]
    if len(shape) > 1 and max(map(len, shape)) == 1:
        return _rows(["[", *shape, "]"], (column, row - 1), marked=False)
    texts = [f" {text}" for text in shape]
    texts[0] = f"[{shape[0]}"
    texts[-1] += "]"
    return _rows(texts, (column - 1, row), marked=False)
