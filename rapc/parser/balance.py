"""Parentheses that do not match: what is missing or too much, and where most likely.

The fewest repairs are those that close what is open at the end and drop what closes
nothing. Indentation tells where the author meant them: a line that begins at or left
of a list still open was meant to stand behind that list, and one that begins right of
a list just closed was meant to stand inside. Where nothing is indented, lines that
begin a clause tell how deep they are. Either is believed if it needs no more repairs
than the fewest.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import msgspec

from rapc.diagnostics import Applicability, Diagnostic, Edit, Fix, Label
from rapc.parser.lexicon import CLOSE, MAX_DEPTH, OPEN, Token
from rapc.parser.names import METHOD_CLAUSES, RAP_CLAUSES
from rapc.source import SourceFile


class Repair(msgspec.Struct, frozen=True):
    """What makes some tokens balance; all numbers are positions among them.

    `closes` holds where a `)` belongs (before that token) and which list it closes;
    `drops` which `)` goes, and the list it would close too early, if any.
    """

    closes: tuple[tuple[int, int], ...] = ()
    drops: tuple[tuple[int, int | None], ...] = ()

    @property
    def edits(self) -> int:
        """How many parentheses are put in or taken out."""
        return len(self.closes) + len(self.drops)


def balance(source: SourceFile, tokens: Sequence[Token]) -> Repair:
    """The likeliest way to make tokens balance."""
    fewest = _plain(tokens)
    if not fewest.edits:
        return fewest
    guided = _Guided(source, tokens)
    meant = guided.repair()
    if meant is None or meant.edits > fewest.edits + 2 * guided.strays:
        return fewest
    return meant


def _plain(tokens: Sequence[Token]) -> Repair:
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


class _Guided:
    """The repair that indentation suggests.

    `open` holds the lists open, `closed` those closed since the last line began, each
    with its closing parenthesis; `places` the row and column of every token. `strays`
    is true once a clause would stand outside of its form: putting it back costs two
    more repairs.
    """

    def __init__(self, source: SourceFile, tokens: Sequence[Token]) -> None:
        self.source = source
        self.tokens = tokens
        self.places = [source.position(start) for _, start, _ in tokens]
        self.open: list[int] = []
        self.closed: list[tuple[int, int]] = []
        self.closes: list[tuple[int, int]] = []
        self.drops: list[tuple[int, int | None]] = []
        self.strays = False
        firsts = [i for i in range(len(tokens)) if self._begins_line(i)]
        left = [i for i in firsts if self.places[i].column == 1]
        self.indented = 2 * len(left) <= len(firsts)

    def repair(self) -> Repair | None:
        """The repair; None if it nests too deeply."""
        for index, (kind, _, _) in enumerate(self.tokens):
            if kind != CLOSE and self._begins_line(index):
                self._reopen(index)
                self._close(index)
                self.closed.clear()
            if kind == OPEN:
                self.open.append(index)
                if len(self.open) > MAX_DEPTH:
                    return None
            elif kind == CLOSE and self.open:
                self.closed.append((self.open.pop(), index))
            elif kind == CLOSE:
                self.drops.append((index, None))
        self.closes += [(len(self.tokens), opener) for opener in reversed(self.open)]
        return Repair(tuple(self.closes), tuple(self.drops))

    def _begins_line(self, index: int) -> bool:
        return index == 0 or self.places[index - 1].row < self.places[index].row

    def _reopen(self, index: int) -> None:
        """Take back what the line before has closed but this line stands inside of."""
        column = self.places[index].column
        self.strays = self.strays or len(self.open) < self._depth(index)
        while self.closed:
            opener, closer = self.closed[-1]
            inside = self.places[opener].column < column and self._begins_line(opener)
            if not (self.indented and inside) and len(self.open) >= self._depth(index):
                return
            self.closed.pop()
            self.drops.append((closer, opener))
            self.open.append(opener)

    def _close(self, index: int) -> None:
        """Close what this line does not stand inside of, the whole form excepted."""
        column = self.places[index].column
        depth = self._depth(index)
        while len(self.open) > 1:
            behind = self.places[self.open[-1]].column >= column
            if not (behind if self.indented else 0 < depth < len(self.open)):
                return
            self.closes.append((index, self.open.pop()))

    def _depth(self, index: int) -> int:
        """In how many lists a line stands that begins a clause; 0 if it begins none."""
        if self.tokens[index][0] != OPEN or index + 1 == len(self.tokens):
            return 0
        _, start, end = self.tokens[index + 1]
        word = self.source.text[start:end].lower()
        if word in RAP_CLAUSES or word in ("facts", "script", "expect"):
            return 1
        return 2 if word in METHOD_CLAUSES else 0


def findings(
    source: SourceFile, tokens: Sequence[Token], repair: Repair, end: int
) -> Iterator[Diagnostic]:
    """What is to be said of a repair; the next form begins at the offset `end`."""
    if repair.closes:
        yield _missing(source, tokens, repair, end)
    if repair.drops:
        yield _surplus(source, tokens, repair)


def _missing(
    source: SourceFile, tokens: Sequence[Token], repair: Repair, end: int
) -> Diagnostic:
    opener = repair.closes[0][1]
    count = len(repair.closes)
    start = tokens[opener][1]
    named = _words(source, tokens, opener)
    noticed = "the file ends here" if end >= len(source.text) else "noticed here"
    labels = [Label(source.span(end, end + 1), noticed)]
    edits = []
    for place in sorted({place for place, _ in repair.closes}):
        stop = tokens[place - 1][2]
        missing = sum(1 for other, _ in repair.closes if other == place)
        edits.append(Edit(source.span(stop, stop), ")" * missing))
        text = f"`{')' * missing}` is most likely missing behind this"
        labels.insert(0, Label(source.span(stop - 1, stop), text))
    return Diagnostic(
        "missing-parenthesis",
        f"{named} is never closed"
        if count == 1
        else f"{count} closing parentheses are missing",
        source.span(start, start + 1),
        label="opened here",
        labels=tuple(labels),
        fix=Fix(Applicability.UNSAFE, "close it", tuple(edits)),
    )


def _surplus(source: SourceFile, tokens: Sequence[Token], repair: Repair) -> Diagnostic:
    at, opener = repair.drops[0]
    count = len(repair.drops)
    labels = []
    before = _form_before(tokens, at) if opener is None else opener
    if before is not None:
        start = tokens[before][1]
        closed = "is closed before it" if opener is None else "is closed too early"
        text = f"{_words(source, tokens, before)} {closed}"
        labels.append(Label(source.span(start, start + 1), text))
    plain = _plain(tokens).drops
    if plain and plain[0][0] != at:
        _, start, stop = tokens[plain[0][0]]
        labels.append(Label(source.span(start, stop), "noticed here"))
    spans = [source.span(tokens[i][1], tokens[i][2]) for i, _ in repair.drops]
    labels += [Label(span, "and this one") for span in spans[1:]]
    return Diagnostic(
        "surplus-parenthesis",
        "there is a `)` too many"
        if count == 1
        else f"there are {count} closing parentheses too many",
        spans[0],
        label="this one most likely" if opener is not None else "it closes nothing",
        labels=tuple(labels),
        fix=Fix(
            Applicability.UNSAFE,
            "take it out",
            tuple(Edit(span, "") for span in sorted(spans, key=lambda s: s.start)),
        ),
    )


def _form_before(tokens: Sequence[Token], at: int) -> int | None:
    """The last list at the top level that begins before a token."""
    depth, found = 0, None
    for index, (kind, _, _) in enumerate(tokens[:at]):
        if kind == OPEN:
            found = found if depth else index
            depth += 1
        elif kind == CLOSE:
            depth = max(0, depth - 1)
    return found


def _words(source: SourceFile, tokens: Sequence[Token], opener: int) -> str:
    """A list by its first word."""
    if opener + 1 < len(tokens) and tokens[opener + 1][0] not in (OPEN, CLOSE):
        _, start, end = tokens[opener + 1]
        return f"the list of `{source.text[start : min(end, start + 40)]}`"
    return "a list"
