"""The reader: text to data, in linear time.

Lists are built with an explicit stack, because deep texts would exhaust Python's stack.
An unbalanced text is cut into segments where a form begins in column 1: a fault stays
in its form. `rapc.parser.repair` repairs the parentheses within a segment. This module
cuts off unclosed strings and comments.
Not here: the meaning of data (`rapc.parser.special`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache

import msgspec

from rapc.base.diagnostics import Diagnostic, Edit, Fix, Label
from rapc.base.limits import MAX_DEPTH
from rapc.base.source import SourceFile, Span
from rapc.language.comments import BLOCK_MARK
from rapc.parser.lexicon import (
    ATOM,
    BLOCK,
    CLOSE,
    COMMENT,
    CUT,
    FORM,
    OPEN,
    STRING,
    UNCLOSED,
    ReadLog,
    Token,
    lexicon,
    tokens,
)
from rapc.parser.repair import Repair, balance, rejoin, repair_findings
from rapc.parser.syntax import Datum, List, Reading, String

_SWALLOWED = r"\((?:define|declare)-"
_BARE_FORM = r"(?:define|declare)-\w"
_STRING = r'"[^"\\\n]*+(?:(?:\\[^\n]|\\?\n(?!\((?:define|declare)-))[^"\\\n]*+)*+"'
_LINE_STRING = r'"[^"\\\n]*+(?:\\[^\n][^"\\\n]*+)*+"'

_COMMENTS = (COMMENT, BLOCK, UNCLOSED)


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    """Return a compiled expression; compiled at the first text that needs a repair."""
    return re.compile(pattern, re.I | re.M)


class Segment(msgspec.Struct):
    """The tokens of a part of the text up to the next form (`end`).

    `deep` is the offset of a list nested too deeply, `string` an unclosed string,
    `comment` an unclosed comment. If a segment has any of the three, its parentheses
    are repaired without findings.
    """

    start: int
    end: int
    tokens: list[Token]
    deep: int | None = None
    string: Token | None = None
    comment: Token | None = None


def read(source: SourceFile) -> Reading:
    """Return the data of a file and the findings about its text."""
    log = ReadLog(source)
    text = source.text
    closers = _comment_ends(text) if "#|" in text else {}
    forms = _build(log, tokens(text, 0, lexicon().string, closers))
    if forms is None:
        log = ReadLog(source)
        forms = _recover(log, closers)
    return log.finish(rejoin(log, forms) if len(forms) > 1 else forms)


def _recover(log: ReadLog, closers: Mapping[int, int]) -> list[Datum]:
    """Return the data of an invalid text; add the findings to the log."""
    text = log.source.text
    forms: list[Datum] = []
    at = 0
    while at < len(text):
        segment = _Cutter(log, closers, at).cut()
        if segment.string is not None:
            segment = _Cutter(log, closers, at, lines=True).cut()
        forms.extend(_data(log, segment))
        at = segment.end
    return forms


def _comment_ends(text: str) -> dict[int, int]:
    """Return the end of each closed `#|` comment by its start."""
    ends: dict[int, int] = {}
    stack: list[int] = []
    for mark in BLOCK_MARK.finditer(text):
        if mark[0] == "#|":
            stack.append(mark.start())
        elif stack:
            ends[stack.pop()] = mark.end()
    return ends


class _Cutter:
    """A function object that cuts a segment off a text.

    With `lines`, each string ends on its line.
    """

    def __init__(
        self,
        log: ReadLog,
        closers: Mapping[int, int],
        start: int,
        *,
        lines: bool = False,
    ) -> None:
        self.text = log.source.text
        self.closers = closers
        self.lines = lines
        self.segment = Segment(start, len(self.text), [])
        self.depth = 0
        self.surplus = 0
        self.in_test = self.text[start : start + 12].lower() == "(define-test"

    def cut(self) -> Segment:
        """Return the segment; without `lines`, stop at an unclosed string."""
        segment = self.segment
        string = _compiled(_LINE_STRING if self.lines else _STRING)
        for token in tokens(self.text, segment.start, string, self.closers):
            kind, start, _ = token
            if self._begins_form(kind, start):
                segment.end = start
                break
            if kind == CUT:
                segment.string = segment.string or token
                if not self.lines:
                    break
            if kind == UNCLOSED and segment.comment is None:
                segment.comment = token
            if kind in (OPEN, CLOSE):
                self._parenthesis(kind, start)
            elif self.depth <= MAX_DEPTH or kind in _COMMENTS:
                segment.tokens.append(token)
        return segment

    def _begins_form(self, kind: int, at: int) -> bool:
        """Return whether the next segment begins at a token."""
        if at == self.segment.start or self.text[at - 1] != "\n":
            return False
        if kind == ATOM:
            found = _compiled(_BARE_FORM).match(self.text, at)
            return not self.depth and found is not None
        if kind != OPEN:
            return False
        found = _compiled(FORM).match(self.text, at)
        return found is not None and not (self.in_test and "require" in found[0])

    def _parenthesis(self, kind: int, at: int) -> None:
        if kind == OPEN:
            self.depth += 1
            if self.depth > MAX_DEPTH:
                self.segment.deep = self.segment.deep or at
                return
        elif self.depth > MAX_DEPTH:
            self.depth -= 1
            return
        elif self.depth:
            self.depth -= 1
        else:
            self.surplus += 1
            if self.surplus > MAX_DEPTH:
                return
        self.segment.tokens.append((kind, at, at + 1))


def _data(log: ReadLog, segment: Segment) -> list[Datum]:
    """Return the data of a segment; mark all data as damaged after a repair."""
    lost = _lost_text(log.source, segment)
    code = [t for t in segment.tokens if t[0] not in _COMMENTS]
    repair = balance(log.source, code)
    if lost is not None:
        log.report(lost)
    elif not log.full:
        for found in repair_findings(log.source, code, repair, segment.end):
            log.report(found)
    for kind, start, end in segment.tokens:
        if kind in _COMMENTS:
            log.comment(start, end)
    forms = _build(log, repair.apply(code), repaired=True) or []
    harmless = lost is None and _is_harmless(code, repair, forms)
    kept = log.surplus if harmless else log.damage
    if lost is not None or repair.edits:
        kept.extend(form.start for form in forms)
    return forms


def _is_harmless(code: Sequence[Token], repair: Repair, forms: Sequence[Datum]) -> bool:
    """Return whether the repair only removes a `)` after the only form."""
    if repair.edits != len(repair.drops):
        return False
    starts = [code[index][1] for index, _ in repair.drops]
    return not starts or (len(forms) == 1 and min(starts) >= forms[0].end)


def _lost_text(source: SourceFile, segment: Segment) -> Diagnostic | None:
    """Return the finding for the first fault in nesting, strings or comments."""
    if segment.deep is not None:
        return Diagnostic(
            "nested-too-deeply",
            f"lists are nested more than {MAX_DEPTH} levels deep",
            source.span(segment.deep, segment.deep + 1),
            help="closing parentheses may be missing before this position",
        )
    if segment.string is not None:
        _, start, end = segment.string
        opener = source.span(start, start + 1)
        return _unclosed("unterminated-string", source, opener, end, '"', segment.end)
    if segment.comment is not None:
        _, start, stop = segment.comment
        end = start + len(source.text[start:stop].rstrip())
        opener = source.span(start, start + 2)
        return _unclosed("unterminated-comment", source, opener, end, " |#", stop)
    return None


def _unclosed(
    rule: str,
    source: SourceFile,
    opener: Span,
    end: int,
    closer: str,
    noticed: int,
) -> Diagnostic:
    """Return the finding for an unclosed string or comment.

    The closing mark is most likely missing at `end`; the reader noticed the fault at
    `noticed`.
    """
    mark = closer.strip()
    last = "noticed here" if noticed < len(source.text) else "the file ends here"
    return Diagnostic(
        rule,
        f"this {rule.removeprefix('unterminated-')} is not closed",
        opener,
        labels=(
            Label(source.span(end - 1, end), f"`{mark}` is probably missing here"),
            Label(source.span(noticed, noticed + 1), last),
        ),
        fix=Fix.of(f"insert `{mark}`", Edit(source.span(end, end), closer)),
    )


def _build(
    log: ReadLog, found: Iterable[Token], *, repaired: bool = False
) -> list[Datum] | None:
    """Return the data of tokens; add the comments to the log.

    Return None if the tokens are not repaired and need it: a parenthesis, string or
    comment is not closed, or a list contains a likely form. Such a form shows a missing
    `)` that a later surplus `)` balances.
    """
    text, atom, known = log.source.text, log.atom, log.known
    items: list[Datum] = []
    stack: list[tuple[list[Datum], int]] = []
    for kind, start, end in found:
        if kind == ATOM:
            raw = text[start:end]
            if raw in known:
                make, value = known[raw]
                items.append(make(value, start, end))
            else:
                items.append(atom(raw, start, end))
        elif kind == OPEN:
            on_new_line = stack and not repaired and text[start - 1] == "\n"
            if len(stack) == MAX_DEPTH or (
                on_new_line and _compiled(_SWALLOWED).match(text, start)
            ):
                return None
            stack.append((items, start))
            items = []
        elif kind == CLOSE and stack:
            inner = tuple(items)
            items, begin = stack.pop()
            items.append(List(inner, begin, end))
        elif kind == CLOSE or (kind >= CUT and not repaired):
            return None
        elif kind == STRING:
            items.append(log.string(start, end))
        elif kind == CUT:
            items.append(String(text[start + 1 : end], start, end))
        elif kind in _COMMENTS:
            log.comment(start, end)
        else:
            log.illegal(start, end)
    return None if stack else items
