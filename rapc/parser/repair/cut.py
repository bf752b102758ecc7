"""The reader for files that do not close: whatever is read is passed on, with findings.

The text is cut where a form begins in column one, so that a fault stays in its form.
Parentheses within such a segment are put right by `rapc.parser.repair.balance`;
strings and comments that do not close are cut off here. Everything takes linear time.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache

import msgspec

from rapc.base.diagnostics import Applicability, Diagnostic, Edit, Fix, Label
from rapc.base.source import SourceFile, Span
from rapc.language.comments import BLOCK_MARK
from rapc.parser.lexicon import (
    ATOM,
    BLOCK,
    CLOSE,
    COMMENT,
    MAX_DEPTH,
    OPEN,
    STRING,
    ReadLog,
    Token,
)
from rapc.parser.repair.balance import Repair, balance
from rapc.parser.repair.messages import repair_findings
from rapc.parser.syntax import Datum, List, String

CUT = STRING + 100
"""The kind of a string that does not close: it ends with its line."""

_FORM = (
    r"\({1,2}(?:define-|declare-|require[\s\"]"
    r"|(?:def|dec)[a-z]{0,6}-(?:rap|test|mem|event|class|indi|prim|sens|skill))"
)
_BARE_FORM = r"(?:define|declare)-\w"
_STRING = r'"[^"\\\n]*+(?:(?:\\[^\n]|\\?\n(?!\((?:define|declare)-))[^"\\\n]*+)*+"'
_LINE_STRING = r'"[^"\\\n]*+(?:\\[^\n][^"\\\n]*+)*+"'


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    """Return an expression, compiled when the first text has to be put right."""
    return re.compile(pattern, re.I | re.M)


class Segment(msgspec.Struct):
    """The tokens of a stretch of text up to where the next form begins (`end`).

    `deep` is the place of a list nested too deeply, `string` of a string that does not
    close, `comment` of such a comment. Where text is lost in one of these ways,
    parentheses are put right without a word.
    """

    start: int
    end: int
    tokens: list[Token]
    deep: int | None = None
    string: Token | None = None
    comment: int | None = None


def recover(log: ReadLog) -> list[Datum]:
    """The data of any text at all; what is wrong with it goes into the log."""
    text = log.source.text
    closers = _comment_ends(text)
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
    """Return where each `#|` that is closed has its end."""
    ends: dict[int, int] = {}
    stack: list[int] = []
    for mark in BLOCK_MARK.finditer(text):
        if mark[0] == "#|":
            stack.append(mark.start())
        elif stack:
            ends[stack.pop()] = mark.end()
    return ends


class _Cutter:
    """Cuts one segment off a text.

    With `lines`, no string goes beyond its line.
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
        self.loose = log.lexicon.loose
        self.closers = closers
        self.string = _compiled(_LINE_STRING if lines else _STRING)
        self.segment = Segment(start, len(self.text), [])
        self.depth = 0
        self.surplus = 0
        self.in_test = self.text[start : start + 12].lower() == "(define-test"

    def cut(self) -> Segment:
        """The segment; given up where a string that might have lines is not closed."""
        at = self.segment.start
        while at < self.segment.end:
            if self.segment.string is not None and self.string is _compiled(_STRING):
                break
            match = self.loose.match(self.text, at)
            kind = match.lastindex if match else None
            if match is None or kind is None:
                break
            start, at = match.span(kind)
            if self._begins_form(kind, start):
                self.segment.end = start
            elif kind in (OPEN, CLOSE):
                self._parenthesis(kind, start)
            elif kind == STRING:
                at = self._string(start)
            elif kind == BLOCK:
                at = self._comment(start)
            elif self.depth <= MAX_DEPTH or kind == COMMENT:
                self.segment.tokens.append((kind, start, at))
        return self.segment

    def _begins_form(self, kind: int, at: int) -> bool:
        """Whether the next segment begins here."""
        if at == self.segment.start or self.text[at - 1] != "\n":
            return False
        if kind == ATOM:
            found = _compiled(_BARE_FORM).match(self.text, at)
            return not self.depth and found is not None
        if kind != OPEN:
            return False
        found = _compiled(_FORM).match(self.text, at)
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

    def _string(self, start: int) -> int:
        found = self.string.match(self.text, start)
        kind, end = STRING, found.end() if found else -1
        if found is None:
            stop = self.text.find("\n", start)
            line = self.text[start : stop if stop >= 0 else len(self.text)]
            kind, end = CUT, start + max(1, len(line.rstrip(" \t\r\f)")))
            self.segment.string = self.segment.string or (CUT, start, end)
        if self.depth <= MAX_DEPTH:
            self.segment.tokens.append((kind, start, end))
        return end

    def _comment(self, start: int) -> int:
        end = self.closers.get(start)
        if end is None:
            if self.segment.comment is None:
                self.segment.comment = start
            form = _compiled(f"^{_FORM}").search(self.text, start)
            end = form.start() if form else len(self.text)
        self.segment.tokens.append((BLOCK, start, end))
        return end


def _data(log: ReadLog, segment: Segment) -> list[Datum]:
    """The data of a segment; all of them count as damaged if anything was amiss."""
    lost = _lost_text(log.source, segment)
    code = [t for t in segment.tokens if t[0] not in (COMMENT, BLOCK)]
    repair = balance(log.source, code)
    if lost is not None:
        log.report(lost)
    elif not log.full:
        for found in repair_findings(log.source, code, repair, segment.end):
            log.report(found)
    for kind, start, end in segment.tokens:
        if kind in (COMMENT, BLOCK):
            log.comment(start, end)
    forms = _build(log, code, repair)
    harmless = lost is None and _is_harmless(code, repair, forms)
    kept = log.surplus if harmless else log.damage
    if lost is not None or repair.edits:
        kept.extend(form.start for form in forms)
    return forms


def _is_harmless(code: Sequence[Token], repair: Repair, forms: Sequence[Datum]) -> bool:
    """Whether the repair only takes out what stands behind the one form there is."""
    if repair.edits != len(repair.drops):
        return False
    starts = [code[index][1] for index, _ in repair.drops]
    return not starts or (len(forms) == 1 and min(starts) >= forms[0].end)


def _lost_text(source: SourceFile, segment: Segment) -> Diagnostic | None:
    """Report the first fault in nesting, strings and comments."""
    if segment.deep is not None:
        return Diagnostic(
            "nested-too-deeply",
            f"lists are nested more than {MAX_DEPTH} deep here",
            source.span(segment.deep, segment.deep + 1),
            help="are closing parentheses missing before?",
        )
    if segment.string is not None:
        _, start, end = segment.string
        opener = source.span(start, start + 1)
        return _unclosed("unterminated-string", source, opener, end, '"', segment.end)
    if segment.comment is not None:
        start = segment.comment
        stop = next(e for k, s, e in segment.tokens if k == BLOCK and s == start)
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
    """A string or comment that should end at `end` and was missed at `noticed`."""
    mark = closer.strip()
    last = "noticed here" if noticed < len(source.text) else "the file ends here"
    return Diagnostic(
        rule,
        f"this {rule.removeprefix('unterminated-')} is never closed",
        opener,
        labels=(
            Label(source.span(end - 1, end), f"`{mark}` is most likely missing here"),
            Label(source.span(noticed, noticed + 1), last),
        ),
        fix=Fix(
            Applicability.UNSAFE,
            f"insert `{mark}`",
            (Edit(source.span(end, end), closer),),
        ),
    )


def _build(log: ReadLog, tokens: Sequence[Token], repair: Repair) -> list[Datum]:
    """The data of repaired tokens."""
    closes = Counter(at for at, _ in repair.closes)
    opens = frozenset(repair.opens)
    drops = {*repair.extra, *(at for at, _ in repair.drops)}
    items: list[Datum] = []
    stack: list[tuple[list[Datum], int]] = []
    for index, token in enumerate(tokens):
        kind, start, end = token
        for _ in range(closes[index]):
            items = _close(stack, items, tokens[index - 1][2])
        if index in opens or (kind == OPEN and index not in drops):
            stack.append((items, start))
            items = []
        if kind == CLOSE and index not in drops:
            items = _close(stack, items, end)
        elif kind not in (OPEN, CLOSE):
            _atom(log, items, token)
    while stack:
        items = _close(stack, items, tokens[-1][2])
    return items


def _close(
    stack: list[tuple[list[Datum], int]], items: list[Datum], end: int
) -> list[Datum]:
    """Close the innermost list; the items of the list around it."""
    outer, start = stack.pop()
    outer.append(List(tuple(items), start, end))
    return outer


def _atom(log: ReadLog, items: list[Datum], token: Token) -> None:
    """Take up a token that is no parenthesis."""
    kind, start, end = token
    if kind == ATOM:
        items.append(log.atom(log.source.text[start:end], start, end))
    elif kind == STRING:
        items.append(log.string(start, end))
    elif kind == CUT:
        items.append(String(log.source.text[start + 1 : end], start, end))
    else:
        log.illegal(start, end)
