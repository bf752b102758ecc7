"""RAP text in its canonical layout: `rapc fmt`.

The layout is that of `rapc.ir.layout`, which prints nodes as well, but works here on
data, so that comments stay where they are and numbers and strings as they were written.

A comment on a line of its own keeps that line, in the column of what follows it. One
behind an operand stays behind it; if nothing but parentheses follows in the list, it
goes behind these. Between operands and between forms a blank line stays one; several
become one. A definition of several lines has a blank line above and below.

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

from rapc.base.diagnostics import Diagnostic
from rapc.base.source import SourceFile
from rapc.ir.layout import WIDTH, Note, Noted, lines
from rapc.parser.reader import read
from rapc.parser.syntax import Comment, Datum, List, Numeral, String

_BLANK = Note("")


class Formatted:
    """A file in its canonical layout, or why there is none."""

    #: The text; that of the file if it cannot be read without guessing.
    text: str
    #: What is wrong with the text.
    diagnostics: tuple[Diagnostic, ...]

    def __init__(self, text: str, diagnostics: tuple[Diagnostic, ...]) -> None:
        self.text = text
        self.diagnostics = diagnostics


def formatted(source: SourceFile, width: int = WIDTH) -> Formatted:
    """Return a file in its canonical layout.

    Args:
        source: the file.
        width: how many columns a line has, as far as atoms allow it.
    """
    reading = read(source)
    if reading.diagnostics:
        return Formatted(source.text, reading.diagnostics)
    pieces = _Pieces(source.text, reading.comments)
    data = [form.datum for form in reading.forms]
    rows = pieces.rows(data, 0, len(source.text))
    return Formatted(_joined(rows, width), ())


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

    def rows(self, data: Sequence[Datum], start: int, end: int) -> list[Noted]:
        """Return some data and the comments between `start` and `end`, in order."""
        found: list[Noted] = []
        at = start
        for datum in data:
            if datum.start == at and _is_resource(found):
                found[-1] = f"{found[-1]}{self._text[at : datum.end]}"
            else:
                found += self._between(at, datum.start, bool(found))
                found += self._tree(datum)
            at = datum.end
        found += self._between(at, end, bool(found), last=True)
        return [
            Note(one.text) if isinstance(one, Note) and _ends_line(before) else one
            for before, one in zip(["", *found], found, strict=False)
        ]

    def _tree(self, datum: Datum) -> Iterator[Noted]:
        """Yield a datum, and the comments that leave it behind its last operand."""
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
        """Yield the comments and blank lines between two places.

        Args:
            start: where what is before them ends.
            end: where what is behind them begins.
            is_behind: whether there is anything before them in their list.
            last: whether nothing of their list is behind them.
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
    """Whether the last row is the name of a resource's kind, as traces print it."""
    last = rows[-1] if rows else ""
    return isinstance(last, str) and last.startswith("#")


def _ends_line(row: Noted) -> bool:
    """Whether nothing can stand behind a row on its line."""
    return isinstance(row, Note) and row.text.startswith(";")


def _is_beside(row: Noted) -> bool:
    return isinstance(row, Note) and row.beside


# --- the top level ------------------------------------------------------------------


def _joined(rows: Sequence[Noted], width: int) -> str:
    """Return forms and comments as text, definitions of several lines set apart."""
    parts: list[str] = []
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
        parts.append(text)
        apart, behind_form = is_long, is_form
    return "".join([*parts, "\n"]) if parts else ""


def _is_definition(row: Noted) -> bool:
    head = row[0] if isinstance(row, tuple) and row else ""
    return isinstance(head, str) and head.startswith("define-")
