"""Text to IR: the reader, then the form functions; and small texts by themselves.

Linking what several files define is for `rapc.library`.
"""

from __future__ import annotations

from typing import cast

import msgspec

from rapc.diagnostics import Diagnostic
from rapc.ir import nodes
from rapc.parser.data import Comment, Datum, List, Symbol
from rapc.parser.forms.context import Context, head_of, kind_of
from rapc.parser.forms.table import FORMS
from rapc.parser.reader import read
from rapc.source import SourceFile, Span

__all__ = ("Comment", "Parsed", "parse")


class Parsed(msgspec.Struct, frozen=True):
    """What became of a file.

    `forms` holds all that could be made of it, in the order of the text. `partial`
    holds the spans of those from which something had to be left out: what others
    find missing in them is not the author's fault.
    """

    forms: tuple[nodes.TopForm, ...]
    diagnostics: tuple[Diagnostic, ...]
    comments: tuple[Comment, ...]
    partial: tuple[Span, ...] = ()


def parse(source: SourceFile) -> Parsed:
    """Read a file and make IR of it; never raises."""
    reading = read(source)
    forms: list[nodes.TopForm] = []
    found = list(reading.diagnostics)
    partial: list[Span] = []
    for top in reading.forms:
        ctx = Context(source)
        form = _form(ctx, top.datum)
        if form is not None:
            forms.append(form)
        if not top.damaged:
            found.extend(ctx.diagnostics)
        if top.damaged or ctx.lost:
            partial.append(ctx.span(top.datum))
    found.sort(key=lambda d: d.span.start)
    return Parsed(tuple(forms), tuple(found), reading.comments, tuple(partial))


def _form(ctx: Context, datum: Datum) -> nodes.TopForm | None:
    name = head_of(datum)
    if not isinstance(datum, List) or name is None:
        ctx.report(
            "unknown-form",
            f"{kind_of(datum)} stands outside of any form",
            datum,
            help="a form is a list that begins with a word such as `define-rap`",
        )
        return None
    if name not in FORMS:
        word = cast(Symbol, datum.items[0])
        meant = ctx.unknown("unknown-form", "top-level form", word, FORMS)
        return FORMS[meant](ctx, datum) if meant else None
    return FORMS[name](ctx, datum)
