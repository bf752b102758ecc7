"""Data: what a RAP file is made of before anybody asks what it means.

Every datum knows its place by two offsets into its file, in code points; which file
that is, the `Reading` knows. Names are folded to lower case, strings are not. What
data mean is for `rapc.parser.special`.
"""

from __future__ import annotations

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
    """A number; a whole one is an `int` however it was written."""

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


class TopLevel(msgspec.Struct, frozen=True, gc=False):
    """A datum at the top level."""

    datum: Datum
    #: Whether the reader had to guess at something in it.
    damaged: bool
    #: Whether there is a `)` too many behind it; one before it may have been lost.
    surplus: bool = False


class Comment(msgspec.Struct, frozen=True, gc=False):
    """A comment with its marks: `; ...` to the end of the line, or `#| ... |#`."""

    text: str
    span: Span


class Reading(msgspec.Struct, frozen=True):
    """What the reader made of a file, and what it has to say about it."""

    source: SourceFile
    forms: tuple[TopLevel, ...]
    comments: tuple[Comment, ...]
    diagnostics: tuple[Diagnostic, ...]
