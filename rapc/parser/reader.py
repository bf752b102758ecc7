"""Text to data, for good files fast and for bad ones with findings.

The terminals are those of `rap.lark`, by way of `rapc.language.grammar`; lists are
built here with a stack of our own, so no text can exhaust Python's. A file whose
parentheses, strings or comments do not close is read again by `rapc.parser.repair.cut`.
What the data mean is not asked here.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any

from rapc.base.later import later
from rapc.base.source import SourceFile
from rapc.language.comments import comment_end
from rapc.language.grammar import TERMINALS
from rapc.parser.lexicon import (
    MAX_DEPTH,
    Lexicon,
    ReadLog,
    atom_value,
    maker,
    string_value,
)
from rapc.parser.repair.rejoin import rejoin
from rapc.parser.syntax import Datum, List, Reading, String

if TYPE_CHECKING:
    from rapc.parser.repair import cut
else:
    cut = later("rapc.parser.repair.cut")

_OPEN_ENDED = {'"': "string", ";": "comment"}
"""What may hold `#|` without beginning a comment, by what it begins with."""

_FORM_LINE = re.compile(r"^\((?:define|declare)-", re.I | re.M)


@cache
def lexicon() -> Lexicon:
    """The terminals of `rap.lark`, compiled once."""
    return Lexicon(TERMINALS)


def read(source: SourceFile) -> Reading:
    """Read a file: return its data, and the findings about its text."""
    log = ReadLog(source, lexicon())
    forms = _scan(log)
    if forms is None or _swallowed(source.text, forms):
        log = ReadLog(source, lexicon())
        forms = cut.recover(log)
    return log.finish(rejoin(log, forms))


def _swallowed(text: str, forms: Sequence[Datum]) -> bool:
    """Whether a list holds what looks like the next form: one `)` missing before it.

    A surplus one further on makes up for it, so the text as a whole is balanced.
    """
    tops = {form.start for form in forms}
    for found in _FORM_LINE.finditer(text):
        if found.start() not in tops:
            above = bisect_right(forms, found.start(), key=lambda form: form.start)
            if above and _list_at(forms[above - 1], found.start()):
                return True
    return False


def _list_at(datum: Datum, offset: int) -> bool:
    """Whether a list in this datum begins at an offset."""
    while isinstance(datum, List) and datum.start < offset < datum.end:
        index = bisect_right(datum.items, offset, key=lambda item: item.start)
        if not index:
            return False
        datum = datum.items[index - 1]
    return isinstance(datum, List) and datum.start == offset


class _Unclosed(Exception):
    """A string or comment is not closed."""


def _scan(log: ReadLog) -> list[Datum] | None:
    """The data of a sound file; None as soon as something does not close."""
    find = _Words(log).__getitem__
    items: list[Datum] = []
    stack: list[tuple[list[Datum], int]] = []
    try:
        for first, pieces in _windows(log):
            at = first
            for opens, make, value, start, end, closes, length in map(find, pieces):
                if opens:
                    if len(stack) + opens > MAX_DEPTH:
                        return None
                    stack.append((items, at))
                    if opens > 1:
                        stack += [([], left) for left in range(at + 1, at + opens)]
                    items = []
                if make is not None:
                    items.append(make(value, at + start, at + end))
                elif end:
                    value(at, at + end)
                if closes:
                    if closes > len(stack):
                        return None
                    right = at + end
                    while closes:
                        right += 1
                        closes -= 1  # noqa: PLW2901  # counting is what it is for
                        inner = tuple(items)
                        items, left = stack.pop()
                        items.append(List(inner, left, right))
                at += length
    except _Unclosed:
        return None
    return None if stack else items


def _windows(log: ReadLog) -> Iterator[tuple[int, list[str]]]:
    """The pieces of a text from one `#| |#` to the next, with the place of the first.

    Raises _Unclosed.
    """
    text, lexicon = log.source.text, log.lexicon
    at = 0
    while at < len(text):
        mark = text.find("#|", at)
        block = lexicon.block.search(text, mark) if mark >= 0 else None
        stop = block.start() if block else len(text)
        pieces = lexicon.words.findall(text, at, stop)
        begun = pieces and block and _OPEN_ENDED.get(pieces[-1][0])
        if begun:  # a string or comment, which goes on behind what only looks like one
            start = stop - len(pieces.pop())
            whole = getattr(lexicon, begun).match(text, start)
            if whole is None:
                raise _Unclosed
            pieces.append(whole[0])
            stop = whole.end()
        yield at, pieces
        at = stop
        if block and not begun:
            at = comment_end(text, stop)
            if at < 0:
                raise _Unclosed
            log.comment(stop, at)


_Word = tuple[int, Any, Any, int, int, int, int]
"""What a piece of text means.

How many lists it opens; what makes a datum, and of what, and where this stands in the
piece; how many lists it closes; how long it is. With no maker but a place, what is
called instead of one has something to note.
"""


class _Words(dict[str, _Word]):
    """Pieces of a text (see `Lexicon.words`) and what each of them means."""

    def __init__(self, log: ReadLog) -> None:
        self._log = log
        self._match = log.lexicon.word.match

    def __missing__(self, piece: str) -> _Word:
        """A piece not seen before. Raises _Unclosed."""
        found = self._match(piece)
        if found is None:
            return self._other(piece)
        kind = found.lastgroup or ""
        start, end = found.span(kind)
        raw = piece[start:end]
        value = atom_value(kind, raw)
        make = maker(kind, raw)
        if value is None:
            make, value = self._log.atom, raw
        word = (start, make, value, start, end, piece.count(")", end), len(piece))
        self[piece] = word
        return word

    def _other(self, piece: str) -> _Word:
        first, length = piece[0], len(piece)
        if first in "() \t\r\n\f":
            opens, closes = piece.count("("), piece.count(")")
            self[piece] = word = (opens, None, None, 0, 0, closes, length)
            return word
        if first == ";":
            return (0, None, self._log.comment, 0, length, 0, length)
        if first != '"':
            return (0, None, self._log.illegal, 0, length, 0, length)
        if self._log.lexicon.string.fullmatch(piece) is None:
            raise _Unclosed
        return (0, String, string_value(piece), 0, length, 0, length)
