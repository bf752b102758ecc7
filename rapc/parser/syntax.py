"""Data: the syntax of a RAP file before its interpretation.

Every datum has its start and end as offsets in code points; its `Reading` has the file.
Names are folded to lower case, strings are not.
Not here: the meaning of data (`rapc.parser.special`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import msgspec

from rapc.base.diagnostics import Diagnostic
from rapc.base.source import SourceFile, Span
from rapc.base.values import Number


class Symbol(msgspec.Struct, frozen=True, gc=False):
    """A symbol, folded to lower case."""

    name: str
    start: int
    end: int


class Arrow(msgspec.Struct, frozen=True, gc=False):
    """The mark `=>` between inputs and outputs; neither a name nor a value."""

    name: str
    start: int
    end: int


class Variable(msgspec.Struct, frozen=True, gc=False):
    """A variable; the name keeps its question mark."""

    name: str
    start: int
    end: int


class Keyword(msgspec.Struct, frozen=True, gc=False):
    """A keyword; the name keeps its colon."""

    name: str
    start: int
    end: int


class Numeral(msgspec.Struct, frozen=True, gc=False):
    """A number; a whole number is an `int` for every spelling."""

    value: Number
    start: int
    end: int


class String(msgspec.Struct, frozen=True, gc=False):
    """A string; `value` has no quotes and no escapes."""

    value: str
    start: int
    end: int


class List(msgspec.Struct, frozen=True, gc=False):
    """A list with its parentheses."""

    items: tuple[Datum, ...]
    start: int
    end: int


Datum = Symbol | Arrow | Variable | Keyword | Numeral | String | List


def lists(data: Iterable[Datum]) -> Iterator[List]:
    """Yield all lists among some data and inside the data, in the order of the text."""
    stack = list(data)[::-1]
    while stack:
        datum = stack.pop()
        if isinstance(datum, List):
            yield datum
            stack.extend(reversed(datum.items))


class TopLevel(msgspec.Struct, frozen=True, gc=False):
    """A datum at the top level."""

    datum: Datum
    #: Whether the reader guessed a part of the datum.
    damaged: bool
    #: Whether a surplus `)` follows the datum; a `(` before it may be missing.
    surplus: bool = False


class Comment(msgspec.Struct, frozen=True, gc=False):
    """A comment with its marks: `; ...` to the end of the line, or `#| ... |#`."""

    text: str
    span: Span


class Reading(msgspec.Struct, frozen=True):
    """The result of reading a file: data, comments and findings."""

    source: SourceFile
    forms: tuple[TopLevel, ...]
    comments: tuple[Comment, ...]
    diagnostics: tuple[Diagnostic, ...]
