"""What is said of parentheses that are missing or too many (see `balance`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.base.diagnostics import Applicability, Diagnostic, Edit, Fix, Label
from rapc.base.source import SourceFile
from rapc.parser.lexicon import CLOSE, OPEN, Token
from rapc.parser.repair.balance import Repair, plain_repair


def repair_findings(
    source: SourceFile, tokens: Sequence[Token], repair: Repair, end: int
) -> Iterator[Diagnostic]:
    """Return the message on a repair; the next form begins at the offset `end`."""
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
            fix=_fix("insert `(`", Edit(source.span(start, start), "(")),
        )
    for index in repair.extra:
        span = source.span(tokens[index][1], tokens[index][2])
        yield Diagnostic(
            "surplus-parenthesis",
            "there is a `(` too many",
            span,
            fix=_fix("take it out", Edit(span, "")),
        )


def _fix(message: str, *edits: Edit) -> Fix:
    return Fix(Applicability.UNSAFE, message, edits)


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
        text = f"`{missing}` is most likely missing behind this"
        labels.append(Label(source.span(stop - 1, stop), text))
    return Diagnostic(
        "missing-parenthesis",
        f"{_words(source, tokens, opener)} is never closed"
        if count == 1
        else f"{count} closing parentheses are missing",
        source.span(start, start + 1),
        label="opened here",
        labels=(*labels, Label(source.span(end, end + 1), noticed)),
        fix=_fix("close it", *edits),
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
    unmatched = plain_repair(tokens).drops
    if unmatched and unmatched[0][0] != at:
        _, start, stop = tokens[unmatched[0][0]]
        labels.append(Label(source.span(start, stop), "noticed here"))
    spans = [source.span(tokens[i][1], tokens[i][2]) for i, _ in repair.drops]
    labels += [Label(span, "and this one") for span in spans[1:]]
    edits = [Edit(span, "") for span in sorted(spans, key=lambda span: span.start)]
    return Diagnostic(
        "surplus-parenthesis",
        "there is a `)` too many"
        if count == 1
        else f"there are {count} closing parentheses too many",
        spans[0],
        label="it closes nothing" if opener is None else "this one most likely",
        labels=tuple(labels),
        fix=_fix("take it out", *edits),
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
    first = opener + 1 if tokens[opener][0] == OPEN else opener
    if first < len(tokens) and tokens[first][0] not in (OPEN, CLOSE):
        _, start, end = tokens[first]
        return f"the list of `{source.text[start : min(end, start + 40)]}`"
    return "a list"
