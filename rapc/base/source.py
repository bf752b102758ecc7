"""Source text and places in it: files, spans, rows and columns.

A place is kept as an offset in code points; rows and columns are worked out only
when somebody has to be shown. Reading files from disk belongs to `rapc.library.loader`.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Mapping
from functools import cached_property

import msgspec

_WORD = re.compile(r"\s*([^\s()\";]+)")


class Span(msgspec.Struct, frozen=True, array_like=True, gc=False):
    """A stretch of one file: offsets `start` (inclusive) to `end` (exclusive).

    Offsets count code points from 0. `file` is the name the user gave the file,
    or would: it is what diagnostics print.
    """

    file: str
    start: int
    end: int

    def to(self, other: Span) -> Span:
        """The span from the start of this one to the end of `other`."""
        return Span(self.file, self.start, other.end)


NOWHERE = Span("", 0, 0)
"""The span of what no file holds: nodes built by programs."""


class Position(msgspec.Struct, frozen=True, order=True):
    """A row and a column, both from 1; columns count code points."""

    row: int
    column: int


def place(span: Span, files: Mapping[str, SourceFile]) -> str:
    """Return where a span begins, as `file:row:column`; the file if it was not read."""
    source = files.get(span.file)
    if source is None:
        return span.file
    at = source.position(span.start)
    return f"{span.file}:{at.row}:{at.column}"


class SourceFile:
    r"""One file's text with its line table.

    Args:
        name: the path as it is to be printed.
        text: the whole text, line ends already folded to ``\n``.
    """

    def __init__(self, name: str, text: str) -> None:
        self.name = name
        self.text = text

    @cached_property
    def line_starts(self) -> tuple[int, ...]:
        """The offset at which each line begins, first line first."""
        starts = [0]
        find = self.text.find
        at = find("\n")
        while at >= 0:
            starts.append(at + 1)
            at = find("\n", at + 1)
        return tuple(starts)

    def row(self, offset: int) -> int:
        """The row of an offset, from 1."""
        return bisect_right(self.line_starts, offset)

    def position(self, offset: int) -> Position:
        """The row and column of an offset (clamped to the text)."""
        offset = max(0, min(offset, len(self.text)))
        row = self.row(offset)
        return Position(row, offset - self.line_starts[row - 1] + 1)

    def line(self, row: int) -> str:
        """The text of a row from 1, without its line end; empty past the end."""
        if not 1 <= row <= len(self.line_starts):
            return ""
        start = self.line_starts[row - 1]
        end = self.text.find("\n", start)
        return self.text[start:] if end < 0 else self.text[start:end]

    def span(self, start: int, end: int) -> Span:
        """A span of this file."""
        return Span(self.name, start, end)

    def word(self, span: Span, position: int) -> Span:
        """The span of a word at the front of a list, its head being word 0.

        Falls back to the whole list where something else stands in between.
        """
        word = Span(self.name, span.start, span.start + 1)
        for _ in range(position + 1):
            found = _WORD.match(self.text, word.end, span.end)
            if found is None:
                return span
            word = Span(self.name, *found.span(1))
        return word
