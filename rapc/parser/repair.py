"""Repair of unbalanced parentheses: the most likely missing and surplus ones.

The smallest repair closes the open lists at the end, and removes each `)` that closes
no list. The intended repair follows from indentation and words:

- A line that begins at the column of an open list, or left of it, belongs after it.
- A line that begins right of a closed list belongs inside it.
- The first word of a clause determines the depth of its line.
- A form or a clause begins with one parenthesis.

The intended repair is used if it needs no more edits than the smallest repair.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import cast

import msgspec

from rapc.base.diagnostics import Diagnostic, Edit, Fix, Label
from rapc.base.limits import MAX_DEPTH
from rapc.base.source import SourceFile
from rapc.language.heads import FORMS, METHOD_CLAUSES, RAP_CLAUSES
from rapc.parser.lexicon import ATOM, CLOSE, OPEN, ReadLog, Token
from rapc.parser.syntax import Datum, List, Symbol


class Repair(msgspec.Struct, frozen=True):
    """The edits that make tokens balance; all numbers are indexes of tokens.

    - `closes`: the token after a missing `)`, and the list that the `)` closes;
    - `drops`: a surplus `)`, and the list that it would close too early, if any;
    - `opens`: the tokens after a missing `(`;
    - `extra`: a surplus `(`.
    """

    closes: tuple[tuple[int, int], ...] = ()
    drops: tuple[tuple[int, int | None], ...] = ()
    opens: tuple[int, ...] = ()
    extra: tuple[int, ...] = ()

    @property
    def edits(self) -> int:
        """The number of inserted and removed parentheses."""
        return sum(map(len, (self.closes, self.drops, self.opens, self.extra)))

    def apply(self, tokens: Sequence[Token]) -> Iterator[Token]:
        """Yield the tokens with these edits; inserted parentheses are empty.

        Lists open at the end are closed.
        """
        closes = Counter(at for at, _ in self.closes)
        opens = frozenset(self.opens)
        drops = {*self.extra, *(at for at, _ in self.drops)}
        depth = last = 0
        for index, token in enumerate(tokens):
            kind, start, end = token
            for _ in range(closes[index]):
                depth -= 1
                yield CLOSE, last, last
            if index in opens or (kind == OPEN and index not in drops):
                depth += 1
                yield OPEN, start, end if kind == OPEN else start
            if kind == CLOSE and index not in drops:
                depth -= 1
                yield token
            elif kind not in (OPEN, CLOSE):
                yield token
            last = end
        for _ in range(depth):
            yield CLOSE, last, last


def balance(source: SourceFile, tokens: Sequence[Token]) -> Repair:
    """Return the most likely repair of tokens."""
    fewest = plain_repair(tokens)
    if not fewest.edits:
        return fewest
    guided = _Guided(source, tokens)
    meant = guided.repair()
    if meant is None or meant.edits > fewest.edits + 2 * guided.strays:
        meant = fewest
    return _with_stray_clauses(source, tokens, meant)


def plain_repair(tokens: Sequence[Token]) -> Repair:
    """Return the smallest repair, from the parentheses alone."""
    stack: list[int] = []
    drops: list[tuple[int, int | None]] = []
    for index, (kind, _, _) in enumerate(tokens):
        if kind == OPEN:
            stack.append(index)
        elif kind == CLOSE and stack:
            stack.pop()
        elif kind == CLOSE:
            drops.append((index, None))
    closes = tuple((len(tokens), opener) for opener in reversed(stack))
    return Repair(closes, tuple(drops))


def _with_stray_clauses(
    source: SourceFile, tokens: Sequence[Token], repair: Repair
) -> Repair:
    """Return a repair that moves the clauses after a RAP into the RAP.

    If a `)` after these clauses closes no list, it closes the RAP, and the `)` before
    the clauses is removed. Otherwise `rejoin` would insert a `)` where the repair
    removes one.
    """
    drops = dict(repair.drops)
    closes = Counter(at for at, _ in repair.closes)
    opened: list[int] = []
    #: The last `)` of a RAP with its `(`, and whether clauses of a RAP follow.
    end: tuple[int, int] | None = None
    follows = False
    for index, (kind, _, _) in enumerate(tokens):
        del opened[len(opened) - closes[index] :]
        word = _word(source, tokens, index)
        if not opened and kind != CLOSE:
            follows = end is not None and word in RAP_CLAUSES
            end = end if follows else None
        if index in repair.opens or (kind == OPEN and index not in repair.extra):
            opened.append(index)
        elif kind == CLOSE and end and follows and drops.get(index, 0) is None:
            del drops[index]
            drops[end[0]] = end[1]
            end, follows = (index, end[1]), False
        elif kind == CLOSE and index not in drops:
            opener = opened.pop()
            if not opened and _word(source, tokens, opener) == "define-rap":
                end = (index, opener)
    if drops.items() == dict(repair.drops).items():
        return repair
    return msgspec.structs.replace(repair, drops=tuple(sorted(drops.items())))


def _word(source: SourceFile, tokens: Sequence[Token], index: int) -> str:
    """Return the word of a token; for a `(`, the word after it."""
    kind, start, end = tokens[index]
    if kind == OPEN and index + 1 < len(tokens):
        _, start, end = tokens[index + 1]
    return source.text[start:end].lower()


class _Guided:
    """The repair that follows from indentation and words.

    - `above`: the number of lists around the text, for example around a single method
      in a book;
    - `open`: the open lists (a list without its parenthesis by its first token);
    - `closed`: the lists closed since the start of the line, each with its `)`;
    - `places`: the row and column of every token;
    - `strays`: whether a clause is outside of its form, which costs two more edits.
    """

    def __init__(self, source: SourceFile, tokens: Sequence[Token]) -> None:
        self.source = source
        self.tokens = tokens
        self.places = [source.position(start) for _, start, _ in tokens]
        self.open: list[int] = []
        self.closed: list[tuple[int, int]] = []
        self.closes: list[tuple[int, int]] = []
        self.drops: list[tuple[int, int | None]] = []
        self.opens: list[int] = []
        self.extra: list[int] = []
        self.strays = False
        self.above = self._above()
        firsts = [i for i in range(len(tokens)) if self._begins_line(i)]
        left = [i for i in firsts if self.places[i].column == 1]
        self.indented = 2 * len(left) <= len(firsts)

    def repair(self) -> Repair | None:
        """Return the repair; None if the lists are nested too deeply."""
        for index, (kind, _, _) in enumerate(self.tokens):
            if kind != CLOSE and self._begins_line(index):
                self._line(index, kind)
            if kind == OPEN and self._doubled(index):
                self.extra.append(index)
            elif kind == OPEN:
                self.open.append(index)
            elif kind == CLOSE and self.open:
                self.closed.append((self.open.pop(), index))
            elif kind == CLOSE:
                self.drops.append((index, None))
            if len(self.open) > MAX_DEPTH:
                return None
        self.closes += [(len(self.tokens), opener) for opener in reversed(self.open)]
        return Repair(
            tuple(self.closes),
            tuple(self.drops),
            tuple(self.opens),
            tuple(self.extra),
        )

    def _begins_line(self, index: int) -> bool:
        return index == 0 or self.places[index - 1].row < self.places[index].row

    def _line(self, index: int, kind: int) -> None:
        """Adjust the open lists to the start of a line."""
        depth = self._depth(index)
        self.strays = self.strays or len(self.open) < (depth or 0)
        self._reopen(index, depth)
        self._close(index, depth)
        self.closed.clear()
        if kind == ATOM and depth == len(self.open):
            self.opens.append(index)
            self.open.append(index)

    def _reopen(self, index: int, depth: int | None) -> None:
        """Reopen the lists that the line before closed, if this line is inside of them.

        A clause at the depth of its word stays, for any indentation.
        """
        if depth is not None and len(self.open) >= depth and self._is_sure(index):
            return
        column = self.places[index].column
        while self.closed:
            opener, closer = self.closed[-1]
            if self.indented and self.places[opener].column >= column:
                return  # or `_close` would put the parenthesis back
            inside = self.indented and self._begins_line(opener)
            if not inside and len(self.open) >= (depth or 0):
                return
            self.closed.pop()
            self.drops.append((closer, opener))
            self.open.append(opener)

    def _close(self, index: int, depth: int | None) -> None:
        """Close the lists, except the whole form, that do not contain this line."""
        column = self.places[index].column
        while len(self.open) > 1:
            behind = self.places[self.open[-1]].column >= column
            outside = bool(depth) and len(self.open) > (depth or 0)
            if not (behind if self.indented else outside):
                return
            self.closes.append((index, self.open.pop()))

    def _above(self) -> int:
        if not self.tokens or self.tokens[0][0] != OPEN:
            return 0
        return self._depth_of(self._word(0)) or 0

    def _is_sure(self, index: int) -> bool:
        """Return whether the first word of a line determines its depth."""
        word = self._word(index)
        return not (word in RAP_CLAUSES and word in METHOD_CLAUSES)

    def _depth(self, index: int) -> int | None:
        """Return the depth of a form or clause at the start of a line, or None."""
        depth = self._depth_of(self._word(index))
        return None if depth is None else max(0, depth - self.above)

    def _word(self, index: int) -> str:
        return _word(self.source, self.tokens, index)

    @staticmethod
    def _depth_of(word: str) -> int | None:
        if word in RAP_CLAUSES or word in ("facts", "script", "expect"):
            return 1
        if word in METHOD_CLAUSES:
            return 2
        return 0 if word in FORMS and word != "require" else None

    def _doubled(self, index: int) -> bool:
        """Return whether a surplus `(` precedes the `(` of a form or clause."""
        following = self.tokens[index + 1 : index + 2]
        if not following or following[0][0] != OPEN:
            return False
        return self._depth(index + 1) == len(self.open)


# --- messages ----------------------------------------------------------------------


def repair_findings(
    source: SourceFile, tokens: Sequence[Token], repair: Repair, end: int
) -> Iterator[Diagnostic]:
    """Yield the findings for a repair; the next form begins at the offset `end`."""
    if repair.closes:
        yield _unclosed(source, tokens, repair, end)
    if repair.drops:
        yield _surplus(source, tokens, repair)
    for index in repair.opens:
        _, start, stop = tokens[index]
        yield Diagnostic(
            "missing-parenthesis",
            f"a `(` is missing before `{source.text[start:stop]}`",
            source.span(start, stop),
            fix=Fix.of("insert `(`", Edit(source.span(start, start), "(")),
        )
    for index in repair.extra:
        span = source.span(tokens[index][1], tokens[index][2])
        yield Diagnostic(
            "surplus-parenthesis",
            "unexpected `(`",
            span,
            fix=Fix.of("remove this parenthesis", Edit(span, "")),
        )


def _unclosed(
    source: SourceFile, tokens: Sequence[Token], repair: Repair, end: int
) -> Diagnostic:
    opener = repair.closes[0][1]
    count = len(repair.closes)
    start = tokens[opener][1]
    noticed = "the file ends here" if end >= len(source.text) else "noticed here"
    labels = []
    edits = []
    for place in sorted({place for place, _ in repair.closes}):
        stop = tokens[place - 1][2]
        missing = ")" * sum(1 for other, _ in repair.closes if other == place)
        edits.append(Edit(source.span(stop, stop), missing))
        text = f"`{missing}` is probably missing after this position"
        labels.append(Label(source.span(stop - 1, stop), text))
    return Diagnostic(
        "missing-parenthesis",
        f"{_words(source, tokens, opener)} is not closed"
        if count == 1
        else f"{count} closing parentheses are missing",
        source.span(start, start + 1),
        label="opened here",
        labels=(*labels, Label(source.span(end, end + 1), noticed)),
        fix=Fix.of("insert the missing parentheses", *edits),
    )


def _surplus(source: SourceFile, tokens: Sequence[Token], repair: Repair) -> Diagnostic:
    at, opener = repair.drops[0]
    count = len(repair.drops)
    labels = []
    before = _form_before(tokens, at) if opener is None else opener
    if before is not None:
        start = tokens[before][1]
        closed = (
            "is closed before it begins" if opener is None else "is closed too early"
        )
        text = f"{_words(source, tokens, before)} {closed}"
        labels.append(Label(source.span(start, start + 1), text))
    unmatched = plain_repair(tokens).drops
    if unmatched and unmatched[0][0] != at:
        _, start, stop = tokens[unmatched[0][0]]
        labels.append(Label(source.span(start, stop), "noticed here"))
    spans = [source.span(tokens[i][1], tokens[i][2]) for i, _ in repair.drops]
    labels += [Label(span, "and this one") for span in spans[1:]]
    edits = [Edit(span, "") for span in sorted(spans, key=lambda span: span.start)]
    return Diagnostic(
        "surplus-parenthesis",
        "unexpected `)`" if count == 1 else f"{count} unexpected closing parentheses",
        spans[0],
        label="this parenthesis closes no list"
        if opener is None
        else "probably this parenthesis",
        labels=tuple(labels),
        fix=Fix.of("remove the parenthesis", *edits),
    )


def _form_before(tokens: Sequence[Token], at: int) -> int | None:
    """Return the last list at the top level that begins before a token."""
    depth, found = 0, None
    for index, (kind, _, _) in enumerate(tokens[:at]):
        if kind == OPEN:
            found = found if depth else index
            depth += 1
        elif kind == CLOSE:
            depth = max(0, depth - 1)
    return found


def _words(source: SourceFile, tokens: Sequence[Token], opener: int) -> str:
    """Return the description of a list by its first word."""
    first = opener + 1 if tokens[opener][0] == OPEN else opener
    if first < len(tokens) and tokens[first][0] not in (OPEN, CLOSE):
        _, start, end = tokens[first]
        return f"the list of `{source.text[start : min(end, start + 40)]}`"
    return "a list"


# --- clauses outside of their RAP --------------------------------------------------


def rejoin(log: ReadLog, forms: Iterable[Datum]) -> list[Datum]:
    """Return the top level with stray clauses in their RAPs, which count as damaged.

    A text with a surplus `)` before clauses may balance. A clause at the top level
    belongs to the RAP before it.
    """
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
            "this `)` closes a RAP before the last clause of the RAP",
            closer,
            labels=(
                Label(opener, "the RAP begins here"),
                Label(first, f"`{_head(strays[0])}` is outside of the RAP"),
            ),
            fix=Fix.of("close the RAP after its clauses", *edits),
        )
    )
    log.damage.append(rap.start)
    kept.append(List((*rap.items, *strays), rap.start, last))
