"""Text to data, for good files fast and for bad ones with findings.

The terminals come from `rap.lark`; lists are built here with a stack of our own, so
no text can exhaust Python's. A file whose parentheses, strings or comments do not
close is read again by `rapc.parser.recovery`. What the data mean is not asked here.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Sequence
from functools import cache

from lark import Lark

from rapc.parser.data import Datum, List, Reading
from rapc.parser.lexicon import (
    ATOM,
    BLOCK,
    CLOSE,
    COMMENT,
    MAX_DEPTH,
    OPEN,
    STRING,
    Lexicon,
    Notes,
    comment_end,
)
from rapc.parser.recovery import recover
from rapc.parser.rejoin import rejoin
from rapc.source import SourceFile

_FORM_LINE = re.compile(r"^\((?:define|declare)-", re.I | re.M)


@cache
def lexicon() -> Lexicon:
    """The terminals of `rap.lark`, compiled once."""
    grammar = Lark.open("rap.lark", rel_to=__file__, parser=None, lexer="basic")
    return Lexicon({t.name: t.pattern.to_regexp() for t in grammar.terminals})


def read(source: SourceFile) -> Reading:
    """All data of a file with everything that is to be said about its text."""
    notes = Notes(source, lexicon())
    forms = _scan(notes)
    if forms is None or _swallowed(source.text, forms):
        notes = Notes(source, lexicon())
        forms = recover(notes)
    return notes.finish(rejoin(notes, forms))


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


def _scan(notes: Notes) -> list[Datum] | None:
    """The data of a sound file; None as soon as something does not close."""
    text = notes.source.text
    known = notes.known
    items: list[Datum] = []
    stack: list[list[Datum]] = []
    starts: list[int] = []
    at: int | None = 0
    while at is not None:
        tokens = notes.lexicon.token.finditer(text, at)
        at = None
        for match in tokens:
            kind = match.lastindex
            if kind == ATOM:
                raw = match[ATOM]
                end = match.end()
                entry = known.get(raw)
                if entry is None:
                    items.append(notes.atom(raw, end - len(raw), end))
                else:
                    items.append(entry[0](entry[1], end - len(raw), end))
            elif kind == OPEN:
                if len(stack) == MAX_DEPTH:
                    return None
                stack.append(items)
                starts.append(match.end() - 1)
                items = []
            elif kind == CLOSE:
                if not stack:
                    return None
                closed = List(tuple(items), starts.pop(), match.end())
                items = stack.pop()
                items.append(closed)
            elif kind is not None:
                end = _other(notes, items, kind, match.start(kind), match.end())
                if end < 0:
                    return None
                if end > match.end():
                    at = end
                    break
    return None if stack else items


def _other(notes: Notes, items: list[Datum], kind: int, start: int, end: int) -> int:
    """Take up a token that is neither parenthesis nor atom.

    Returns where to go on, or -1 if the token does not close.
    """
    if kind == STRING:
        items.append(notes.string(start, end))
    elif kind == COMMENT:
        notes.comment(start, end)
    elif kind == BLOCK:
        end = comment_end(notes.source.text, start)
        if end > 0:
            notes.comment(start, end)
    elif notes.source.text[start] == '"':
        return -1
    else:
        notes.illegal(start, end)
    return end
