"""Source text and positions in it: files, spans, rows and columns.

A position is an offset in code points; rows and columns are computed only for output.
Not here: reading files (`rapc.base.files`).
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Mapping
from functools import cached_property

import msgspec

_WORD = re.compile(r"\s*([^\s()\";]+)")


class Span(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """A span of one file: offsets `start` (inclusive) to `end` (exclusive).

    Offsets count code points from 0. `file` is the user's name for the file, which
    findings print.
    """

    file: str
    start: int
    end: int

    def to(self, other: Span) -> Span:
        """Return the span from the start of this span to the end of `other`."""
        return Span(self.file, self.start, other.end)

    def contains(self, other: Span) -> bool:
        """Return whether the span `other` lies in this span."""
        return (
            self.file == other.file
            and self.start <= other.start
            and other.end <= self.end
        )


NOWHERE = Span("", 0, 0)
"""The span of nodes without a file, built by programs."""


class Position(msgspec.Struct, frozen=True, order=True):
    """A row and a column, both from 1; columns count code points."""

    row: int
    column: int


def place(span: Span, files: Mapping[str, SourceFile]) -> str:
    """Return the start of a span as `file:row:column`; only the file if unread."""
    source = files.get(span.file)
    if source is None:
        return span.file
    at = source.position(span.start)
    return f"{span.file}:{at.row}:{at.column}"


class SourceFile:
    r"""The text of a file with its line table.

    Args:
        name: the path for output.
        text: the whole text, line ends already folded to ``\n``.
    """

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self.text = text

    @cached_property
    def lowered(self) -> str:
        """The text with small letters where that does not move an offset."""
        text = self.text.lower()
        if len(text) == len(self.text):
            return text
        return "".join([c.lower() if len(c.lower()) == 1 else c for c in self.text])

    @cached_property
    def line_starts(self) -> tuple[int, ...]:
        """The offset of the start of each line, first line first."""
        starts = [0]
        find = self.text.find
        at = find("\n")
        while at >= 0:
            starts.append(at + 1)
            at = find("\n", at + 1)
        return tuple(starts)

    def row(self, offset: int) -> int:
        """Return the row of an offset, from 1."""
        return bisect_right(self.line_starts, offset)

    def position(self, offset: int) -> Position:
        """Return the row and column of an offset (clamped to the text)."""
        offset = max(0, min(offset, len(self.text)))
        row = self.row(offset)
        return Position(row, offset - self.line_starts[row - 1] + 1)

    def line(self, row: int) -> str:
        """Return the text of a row from 1, without line end; empty past the end."""
        if not 1 <= row <= len(self.line_starts):
            return ""
        start = self.line_starts[row - 1]
        end = self.text.find("\n", start)
        return self.text[start:] if end < 0 else self.text[start:end]

    def span(self, start: int, end: int) -> Span:
        """Return a span of this file."""
        return Span(self.name, start, end)

    def word(self, span: Span, position: int) -> Span:
        """Return the span of a word at the front of a list; its head is word 0.

        Returns the span of the list if there are other characters before the word.
        """
        word = Span(self.name, span.start, span.start + 1)
        for _ in range(position + 1):
            found = _WORD.match(self.text, word.end, span.end)
            if found is None:
                return span
            word = Span(self.name, *found.span(1))
        return word
