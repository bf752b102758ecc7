"""RAP text in its canonical layout: `rapc fmt`.

The formatter uses `rapc.ir.layout`, which also prints nodes, on data. Comments keep
their position, and numbers and strings keep their spelling.

- A comment on its own line keeps its line, in the column of the following text.
- A comment after an operand stays after the operand. If only parentheses follow in the
  list, the comment moves after the parentheses.
- Between operands and between forms, one or more blank lines become one blank line.
- A definition of several lines has a blank line above and below.

For example

    (define-rap (go ?where) ; there
     (method ( primitive (drive ?where))))

becomes

    (define-rap (go ?where)  ; there
      (method
        (primitive (drive ?where))))
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import cast

import msgspec

from rapc.base.diagnostics import Diagnostic, Edit
from rapc.base.source import SourceFile
from rapc.ir.layout import WIDTH, Note, Noted, lines
from rapc.parser.reader import read
from rapc.parser.syntax import Comment, Datum, List, Numeral, String

_BLANK = Note("")


class Formatted:
    """A file in its canonical layout, or the findings that prevent it."""

    #: The formatted text; the text of the file if there are findings.
    text: str
    #: The findings in the text.
    diagnostics: tuple[Diagnostic, ...]

    def __init__(self, text: str, diagnostics: tuple[Diagnostic, ...]) -> None:
        self.text = text
        self.diagnostics = diagnostics


def formatted(source: SourceFile, width: int = WIDTH) -> Formatted:
    """Return a file in its canonical layout.

    Args:
        source: the file.
        width: the number of columns of a line, if the atoms allow it.
    """
    return Formatter(width).formatted(source)


class Formatter:
    """A formatter of one file that lays out again only the forms that have changed.

    A text is cut where a `(` begins a line. The parts between are formatted by
    themselves and cached by their text.

    Args:
        width: the number of columns of a line, if the atoms allow it.
    """

    def __init__(self, width: int = WIDTH) -> None:
        self._width = width
        self._known: dict[str, _Part] = {}

    def formatted(self, source: SourceFile) -> Formatted:
        """Return a file in its canonical layout."""
        parts = self._parts(source.text.split(_CUT))
        if any(part.text is None for part in parts):
            # A string may contain a line that begins with `(`.
            parts = [_part(source, self._width)]
        faults = tuple([fault for part in parts for fault in part.faults])
        if faults:
            return Formatted(source.text, faults)
        texts: list[str] = []
        before = parts[0]
        for part in parts:
            if part.text and texts:
                apart = before.ends_apart or (part.is_long and before.ends_with_form)
                texts.append("\n\n" if apart else "\n")
            if part.text:
                texts.append(part.text)
                before = part
        return Formatted("".join([*texts, "\n"]) if texts else "", ())

    def edits(self, source: SourceFile, start: int, end: int) -> tuple[Edit, ...]:
        """Return the edits that format the forms in a stretch of a file.

        A form that cannot be read stays unchanged; so do the forms behind an unclosed
        string or comment.
        """
        found: list[Edit] = []
        texts = source.text.split(_CUT)
        at = 0
        for text, part in zip(texts, self._parts(texts), strict=True):
            if part.is_open or at > end:
                break
            to = at + len(text) + (at > 0)
            kept = source.text[at:to].rstrip() if to >= start else ""
            if kept and part.text not in (None, kept):
                found.append(Edit(source.span(at, at + len(kept)), str(part.text)))
            at = to + 1
        return tuple(found)

    def _parts(self, texts: Sequence[str]) -> list[_Part]:
        """Return the parts of a text; all texts but the first lack their `(`."""
        first, *others = texts
        known = self._known
        found = {text: known.get(text) for text in others}
        for text, part in found.items():
            if part is None:
                found[text] = _part(SourceFile("", f"({text}\n"), self._width)
        self._known = cast(dict[str, _Part], found)
        begin = _part(SourceFile("", f"{first}\n"), self._width)
        return [begin, *map(self._known.__getitem__, others)]


class _Part(msgspec.Struct, frozen=True):
    """A part of a text, laid out."""

    #: The forms and comments as text; None if the part cannot be read by itself.
    text: str | None
    #: Whether the first form is a definition of several lines.
    is_long: bool = False
    #: Whether a blank line follows.
    ends_apart: bool = False
    #: Whether the last form has no comment below it.
    ends_with_form: bool = False
    #: The findings in the part.
    faults: tuple[Diagnostic, ...] = ()
    #: Whether a string or a comment is not closed.
    is_open: bool = False


_CUT = "\n("
"""The text at which a text is cut into parts."""


def _part(source: SourceFile, width: int) -> _Part:
    """Return a part of a text, or a whole text, laid out."""
    reading = read(source)
    faults = reading.diagnostics
    if faults:
        is_open = any(one.rule in _OPEN for one in faults)
        return _Part(None, faults=faults, is_open=is_open)
    pieces = _Pieces(source.text, reading.comments)
    data = [form.datum for form in reading.forms]
    rows = pieces.rows(data, 0, len(source.text), last=False)
    return _joined(rows, width)


_OPEN = ("unterminated-string", "unterminated-comment")
"""The faults after which the parts that follow may be text of a string or comment."""


class _Pieces:
    """The trees of a text's data, with its comments among them.

    Args:
        text: the text.
        comments: its comments, in order.
    """

    def __init__(self, text: str, comments: Sequence[Comment]) -> None:
        self._text = text
        self._comments = comments
        self._next = 0

    def rows(
        self, data: Sequence[Datum], start: int, end: int, last: bool = True
    ) -> list[Noted]:
        """Return some data and the comments between `start` and `end`, in order.

        Unless `last`, blank lines at the end count.
        """
        found: list[Noted] = []
        at = start
        for datum in data:
            if datum.start == at and _is_resource(found):
                found[-1] = f"{found[-1]}{self._text[at : datum.end]}"
            else:
                found += self._between(at, datum.start, bool(found))
                found += self._tree(datum)
            at = datum.end
        found += self._between(at, end, bool(found), last)
        return [
            Note(one.text) if isinstance(one, Note) and _ends_line(before) else one
            for before, one in zip(["", *found], found, strict=False)
        ]

    def _tree(self, datum: Datum) -> Iterator[Noted]:
        """Yield a datum, then the comments moved out of its end."""
        if not isinstance(datum, List):
            yield self._atom(datum)
            return
        rows = self.rows(datum.items, datum.start + 1, datum.end - 1)
        left = len(rows)
        while left > 1 and _is_beside(rows[left - 1]):
            left -= 1
        yield tuple(rows[:left])
        yield from rows[left:]

    def _atom(self, datum: Datum) -> str:
        if isinstance(datum, Numeral | String | List):
            return self._text[datum.start : datum.end]
        return datum.name

    def _between(
        self, start: int, end: int, is_behind: bool, last: bool = False
    ) -> Iterator[Note]:
        """Yield the comments and blank lines between two positions.

        Args:
            start: the end of the preceding text.
            end: the start of the following text.
            is_behind: whether the list has a datum before `start`.
            last: whether the list has no datum after `end`.
        """
        comments = self._comments
        while self._next < len(comments) and comments[self._next].span.start < end:
            comment = comments[self._next]
            self._next += 1
            gap = self._text[start : comment.span.start]
            if is_behind and gap.count("\n") > 1:
                yield _BLANK
            text = comment.text.rstrip()
            yield Note(text, beside=is_behind and "\n" not in gap)
            start, is_behind = comment.span.end, True
        if is_behind and not last and self._text.count("\n", start, end) > 1:
            yield _BLANK


def _is_resource(rows: Sequence[Noted]) -> bool:
    """Return whether the last row is the kind of a resource in the form of a trace."""
    last = rows[-1] if rows else ""
    return isinstance(last, str) and last.startswith("#")


def _ends_line(row: Noted) -> bool:
    """Return whether a row extends to the end of its line."""
    return isinstance(row, Note) and row.text.startswith(";")


def _is_beside(row: Noted) -> bool:
    return isinstance(row, Note) and row.beside


# --- the top level ------------------------------------------------------------------


def _joined(rows: Sequence[Noted], width: int) -> _Part:
    """Return forms and comments as text, with blank lines around long definitions."""
    parts: list[str] = []
    is_first_long = False
    apart = False
    behind_form = False
    for row in rows:
        if row == _BLANK:
            apart = bool(parts)
            continue
        if isinstance(row, Note):
            text, is_long, is_form = row.text, False, False
            if row.beside:
                parts.append(f"  {text}")
                continue
        else:
            text, is_form = lines(row, width), True
            is_long = "\n" in text and _is_definition(row)
        if parts:
            apart = apart or (is_long and behind_form)
            parts.append("\n\n" if apart else "\n")
        else:
            is_first_long = is_long
        parts.append(text)
        apart, behind_form = is_long, is_form
    return _Part("".join(parts), is_first_long, apart, behind_form)


def _is_definition(row: Noted) -> bool:
    head = row[0] if isinstance(row, tuple) and row else ""
    return isinstance(head, str) and head.startswith("define-")
