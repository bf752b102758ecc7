"""Clauses left outside of their `define-rap` by a parenthesis too many.

Such a text balances, so the reader has nothing to complain of, but a clause at the top
level belongs to the RAP before it.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import cast

from rapc.base.diagnostics import Applicability, Diagnostic, Edit, Fix, Label
from rapc.language.heads import RAP_CLAUSES
from rapc.parser.lexicon import ReadLog
from rapc.parser.syntax import Datum, List, Symbol


def rejoin(log: ReadLog, forms: Iterable[Datum]) -> list[Datum]:
    """Return the top level with stray clauses put back; their RAPs count as damaged."""
    kept: list[Datum] = []
    strays: list[List] = []
    for form in forms:
        if _head(form) in RAP_CLAUSES and kept and _head(kept[-1]) == "define-rap":
            strays.append(cast(List, form))
            continue
        _adopt(log, kept, strays)
        strays = []
        kept.append(form)
    _adopt(log, kept, strays)
    return kept


def _head(form: Datum) -> str:
    if isinstance(form, List) and form.items and isinstance(form.items[0], Symbol):
        return form.items[0].name
    return ""


def _adopt(log: ReadLog, kept: list[Datum], strays: list[List]) -> None:
    if not strays:
        return
    rap = cast(List, kept.pop())
    last = strays[-1].end
    closer = log.source.span(rap.end - 1, rap.end)
    opener = log.source.span(rap.start, rap.start + 1)
    first = log.source.span(strays[0].start, strays[0].start + 1)
    edits = (Edit(closer, ""), Edit(log.source.span(last, last), ")"))
    log.report(
        Diagnostic(
            "surplus-parenthesis",
            "this `)` closes a RAP before its last clause",
            closer,
            labels=(
                Label(opener, "the RAP begins here"),
                Label(first, f"`{_head(strays[0])}` stands outside of it"),
            ),
            fix=Fix(Applicability.UNSAFE, "close the RAP behind its clauses", edits),
        )
    )
    log.damage.append(rap.start)
    kept.append(List((*rap.items, *strays), rap.start, last))
