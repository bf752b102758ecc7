"""Positions of the protocol, and places in a text that has been edited since.

rapc counts code points in a text with folded line ends. The protocol counts lines, and
code points (utf-32) or UTF-16 units in a line; a client that accepts utf-32 gets it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from lsprotocol import types

from rapc.base.files import fold_line_ends
from rapc.base.source import SourceFile

_WIDE = re.compile("[\U00010000-\U0010ffff]")


class Change(NamedTuple):
    """A change of a text: the replaced stretch and the length of the new text."""

    start: int
    end: int
    length: int


def moved(offset: int, changes: Iterable[Change]) -> int:
    """Return the place of an offset after some changes.

    An offset inside a replaced stretch moves to the nearest place in the new text.
    """
    for start, end, length in changes:
        if offset >= end and offset > start:
            offset += length - (end - start)
        elif offset > start:
            offset = min(offset, start + length)
    return offset


def moved_back(offset: int, changes: Sequence[Change]) -> int:
    """Return the place of an offset before some changes; see `moved`."""
    for start, end, length in reversed(changes):
        if offset >= start + length and offset > start:
            offset += (end - start) - length
        elif offset > start:
            offset = min(offset, end)
    return offset


class Text(SourceFile):
    """The text of a file, with positions in the units of the client.

    Args:
        name: the path of the file.
        text: the text, line ends folded.
        wide: whether a code point outside the first plane counts as two units.
    """

    def __init__(self, name: str, text: str, wide: bool) -> None:
        super().__init__(name, text)
        self.wide = wide

    def offset(self, position: types.Position) -> int:
        """Return the offset of a position; after the end of a line, the line's end."""
        starts = self.line_starts
        if position.line >= len(starts):
            return len(self.text)
        start = starts[position.line]
        line = self.line(position.line + 1)
        units = position.character
        if self.wide and not line.isascii():
            units = _points(line, units)
        return start + min(units, len(line))

    def at(self, offset: int) -> types.Position:
        """Return the position of an offset."""
        place = self.position(offset)
        column = place.column - 1
        if self.wide and not self.text.isascii():
            start = self.line_starts[place.row - 1]
            column += len(_WIDE.findall(self.text, start, start + column))
        return types.Position(place.row - 1, column)

    def range(self, start: int, end: int) -> types.Range:
        """Return the range between two offsets."""
        return types.Range(self.at(start), self.at(end))

    def stretch(self, range: types.Range) -> tuple[int, int]:
        """Return the offsets of a range, in order."""
        start, end = self.offset(range.start), self.offset(range.end)
        return min(start, end), max(start, end)

    @property
    def everything(self) -> types.Range:
        """The range of the whole text."""
        return self.range(0, len(self.text))


def _points(line: str, units: int) -> int:
    """Return the number of code points in the first UTF-16 units of a line."""
    for at, char in enumerate(line):
        if units <= 0:
            return at
        units -= 2 if char > "\uffff" else 1
    return len(line)


def change(
    text: Text, event: types.TextDocumentContentChangeEvent
) -> tuple[str, Change]:
    """Return the new text after an edit of the client, and the change."""
    new = fold_line_ends(event.text)
    if isinstance(event, types.TextDocumentContentChangePartial):
        start, end = text.stretch(event.range)
        changed = f"{text.text[:start]}{new}{text.text[end:]}"
        return changed, Change(start, end, len(new))
    return new, difference(text.text, new)


def difference(old: str, new: str) -> Change:
    """Return a single change that makes one text of another."""
    start = _common(old, new)
    longest = min(len(old), len(new)) - start
    end = _common(old[::-1][:longest], new[::-1][:longest])
    return Change(start, len(old) - end, len(new) - end - start)


def _common(one: str, other: str) -> int:
    """Return the length of the longest common prefix of two texts."""
    least, most = 0, min(len(one), len(other))
    while least < most:
        middle = (least + most + 1) // 2
        if one[least:middle] == other[least:middle]:
            least = middle
        else:
            most = middle - 1
    return least
