"""Tokens: the regular expression from the grammar's terminals, and atoms.

`ReadLog` turns atoms into data and collects comments, findings and the positions that
make a form damaged. Not here: lists (`rapc.parser.reader`).
"""

from __future__ import annotations

import math
import re
import sys
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from typing import Any

from rapc.base.diagnostics import Diagnostic, Edit, Fix
from rapc.base.limits import LARGEST_NUMBER, MAX_FINDINGS, MAX_NAME, MAX_NUMBER
from rapc.base.source import SourceFile
from rapc.base.values import Number, format_atom, number
from rapc.language.grammar import TERMINALS
from rapc.language.heads import ARROW
from rapc.parser.syntax import (
    Arrow,
    Comment,
    Datum,
    Keyword,
    Numeral,
    Reading,
    String,
    Symbol,
    TopLevel,
    Variable,
)

OPEN, CLOSE, QUOTE, ATOM, STRING, COMMENT, BLOCK, OTHER = range(1, 9)
CUT, UNCLOSED = 9, 10
"""The kinds of tokens: the groups of `Lexicon.loose`, and unclosed tokens.

OTHER is an invalid character, CUT an unclosed string, UNCLOSED an unclosed comment.
"""

FORM = (
    r"\({1,2}(?:define-|declare-|require[\s\"]"
    r"|(?:def|dec)[a-z]{0,6}-(?:rap|test|mem|event|class|indi|prim|sens|skill))"
)
FORM_LINE = re.compile(f"^{FORM}", re.I | re.M)
"""The likely beginning of a form in column 1."""

Token = tuple[int, int, int]
"""The kind of a token and the offsets of its text."""

_ESCAPE = re.compile(r"\\(.)", re.S)
_NUMBER_LIKE = re.compile(r"[+-]?(?=\.?[0-9])[0-9]*\.?[0-9]*(?:e[+-]?[0-9]+)?", re.I)
_Make = Callable[[Any, int, int], Datum]
MAKERS: Mapping[str, _Make] = {
    "NUMBER": Numeral,
    "VARIABLE": Variable,
    "KEYWORD": Keyword,
    "WORD": Symbol,
}
"""The classes of data by the kind of an atom; `=>` is an `Arrow`."""

_MEANT = str.maketrans(
    {
        **dict.fromkeys("'`,@#|\\:", ""),
        **dict.fromkeys("[{", "("),
        **dict.fromkeys("]}", ")"),
        **dict.fromkeys("\u201c\u201d", '"'),
    }
)
_QUOTES = frozenset("#'`,")


class Lexicon:
    """The compiled terminals of the grammar.

    An atom is a `_NAME`, but not a single colon; `atom` matches the kinds of atoms.
    `loose` matches a token and the space before it; of a string it matches only the
    opening quote. `offsets` has the numbers of the first offsets: files that share the
    objects need less memory.

    Args:
        terminals: regular expressions without groups, by terminal name.
    """

    def __init__(self, terminals: Mapping[str, str]) -> None:
        space, name = terminals["_SPACE"], terminals["_NAME"]
        left, right, comment = (terminals[k] for k in ("LPAR", "RPAR", "COMMENT"))
        atom = f"(?!:(?!{name})){name}"
        other = rf"\|#|(?!{space})(?s:.)"
        block = terminals["BLOCK_OPEN"]
        tokens = (left, right, "#'", atom, '"', comment, block, other)
        choice = "|".join(f"({token})" for token in tokens)
        self.loose = re.compile(rf"{space}*+(?:{choice}|\Z)")
        kinds = "|".join(f"(?P<{kind}>{terminals[kind]})" for kind in MAKERS)
        self.atom = re.compile(kinds)
        self.string = re.compile(terminals["STRING"])
        self.offsets = tuple(range(_SHARED))


_SHARED = 1 << 16
"""The number of offsets that are shared."""


@cache
def lexicon() -> Lexicon:
    """Return the terminals of `rap.lark`, compiled once."""
    return Lexicon(TERMINALS)


def tokens(
    text: str, at: int, string: re.Pattern[str], closers: Mapping[int, int]
) -> Iterator[Token]:
    """Yield the tokens of a text after an offset, with comments.

    Args:
        text: the text.
        at: the offset.
        string: the expression for strings. An unclosed string is a `CUT`, which ends
            with its line, before the parentheses at the end of the line.
        closers: the end of each comment in `#| |#`. An unclosed comment is an
            `UNCLOSED`, which ends before the next form.
    """
    find, offsets = lexicon().loose, lexicon().offsets
    again = True
    while again:
        again = False
        for match in find.finditer(text, at):
            kind = match.lastindex
            if kind is None:
                return
            start, end = match.start(kind), match.end()
            if end < _SHARED:
                start, end = offsets[start], offsets[end]
            if kind <= ATOM:
                yield kind, start, end
                continue
            if kind == STRING:
                found = string.match(text, start)
                if found is None:
                    stop = text.find("\n", start)
                    line = text[start : stop if stop >= 0 else len(text)]
                    kind, end = CUT, start + max(1, len(line.rstrip(" \t\r\f)")))
                else:
                    end = found.end()
            elif kind == BLOCK and start in closers:
                end = closers[start]
            elif kind == BLOCK:
                form = FORM_LINE.search(text, start)
                kind, end = UNCLOSED, form.start() if form else len(text)
            yield kind, start, end
            if kind >= CUT or kind in (STRING, BLOCK):
                at, again = end, True
                break


def atom_value(kind: str, raw: str) -> Number | str | None:
    """Return the value of an atom of a kind, or None if the atom is invalid."""
    if kind == "NUMBER":
        if len(raw) > MAX_NUMBER:
            return None
        return number(float(raw)) if "." in raw else int(raw)
    if len(raw) > MAX_NAME:
        return None
    if kind == "WORD" and raw[0] in "+-.0123456789" and _NUMBER_LIKE.fullmatch(raw):
        return None
    return sys.intern(raw.lower())


class ReadLog:
    """The comments, findings and damaged positions collected while a file is read."""

    #: The class and value of each valid atom read so far, by its text.
    known: dict[str, tuple[_Make, Any]]
    #: The offsets of guessed parts.
    damage: list[int]
    #: The offsets of forms followed by a surplus `)`.
    surplus: list[int]

    def __init__(self, source: SourceFile) -> None:
        self.source = source
        self.known = {}
        self.comments: list[Comment] = []
        self.diagnostics: list[Diagnostic] = []
        self.damage = []
        self.surplus = []
        self._illegal: list[tuple[int, int]] = []

    @property
    def full(self) -> bool:
        """Whether the limit of findings is reached."""
        return len(self.diagnostics) + len(self._illegal) >= MAX_FINDINGS

    def report(self, found: Diagnostic) -> None:
        """Add a finding, unless the limit is reached."""
        if not self.full:
            self.diagnostics.append(found)

    def comment(self, start: int, end: int) -> None:
        """Add a comment."""
        text = self.source.text[start:end]
        self.comments.append(Comment(text, self.source.span(start, end)))

    def atom(self, raw: str, start: int, end: int) -> Datum:
        """Return the datum of an atom; report an invalid atom."""
        match = lexicon().atom.match(raw)
        kind = (match and match.lastgroup) or "WORD"
        value = atom_value(kind, raw)
        if value is not None:
            make: _Make = Arrow if raw == ARROW else MAKERS[kind]
            self.known[raw] = make, value
            return make(value, start, end)
        if kind == "NUMBER":
            self._too_long("number", MAX_NUMBER, start, end)
            return Numeral(0, start, end)
        if len(raw) <= MAX_NAME:
            return self._number_like(raw, start, end)
        self._too_long("name", MAX_NAME, start, end)
        return MAKERS[kind](raw[:MAX_NAME].lower(), start, end)

    def string(self, start: int, end: int) -> String:
        """Return the datum of a string with its quotes."""
        value = self.source.text[start + 1 : end - 1]
        return String(_ESCAPE.sub(r"\1", value), start, end)

    def illegal(self, start: int, end: int) -> None:
        """Add invalid characters; adjacent characters make one finding."""
        if self._illegal and self._illegal[-1][1] == start:
            start = self._illegal.pop()[0]
        if not self.full and (start or self.source.text[0] != "\ufeff"):
            self._illegal.append((start, end))

    def finish(self, forms: Iterable[Datum]) -> Reading:
        """Return the reading of a file with `forms` at its top level."""
        for start, end in self._illegal:
            self._report_illegal(start, end)
        found = sorted(self.diagnostics, key=lambda d: d.span.start)
        damage = sorted(self.damage)
        surplus = sorted(self.surplus)
        if damage or surplus:
            hits = ((one, _hit(one, damage), _hit(one, surplus)) for one in forms)
            top = tuple([TopLevel(*hit) for hit in hits])
        else:
            top = tuple([TopLevel(form, False, False) for form in forms])
        return Reading(self.source, top, tuple(self.comments), tuple(found))

    def _number_like(self, raw: str, start: int, end: int) -> Datum:
        value = float(raw) if len(raw) <= MAX_NUMBER else math.inf
        fits = abs(value) < LARGEST_NUMBER
        content = format_atom(number(value)) if fits else "0"
        span = self.source.span(start, end)
        fix = Fix.of(f"write `{content}`", Edit(span, content), sure=True)
        self.report(
            Diagnostic(
                "malformed-number",
                f"invalid number `{raw[:MAX_NUMBER]}`",
                span,
                help="a number is an integer such as `-3` or a decimal such as `0.5`",
                fix=fix if fits else None,
            )
        )
        return Numeral(number(float(content)), start, end)

    def _too_long(self, what: str, limit: int, start: int, end: int) -> None:
        self.damage.append(start)
        self.report(
            Diagnostic(
                "too-long",
                f"{what} of {end - start} characters; the limit is {limit}",
                self.source.span(start, start + 20),
                label=f"the {what} begins here",
            )
        )

    def _report_illegal(self, start: int, end: int) -> None:
        text = self.source.text[start:end]
        harmless = text.isspace() or _QUOTES.issuperset(text) or text == "|#"
        if not harmless:
            self.damage.append(start)
        content = " " if text.isspace() else text.translate(_MEANT)
        span = self.source.span(start, end)
        doing = (
            f"write `{content}` in place of this character"
            if content.strip()
            else "remove this character"
        )
        self.diagnostics.append(
            Diagnostic(
                "illegal-character",
                f"unexpected {_shown(text)}",
                span,
                help=_advice(text),
                fix=Fix.of(doing, Edit(span, content), sure=harmless),
            )
        )


def _hit(form: Datum, damage: list[int]) -> bool:
    at = bisect_left(damage, form.start)
    return at < len(damage) and damage[at] < form.end


def _shown(text: str) -> str:
    if text.isprintable() and not text.isspace():
        return f"`{text[:10]}`"
    return f"character U+{ord(text[0]):04X}"


def _advice(text: str) -> str:
    if text == "|#":
        return "this mark ends a comment, but no comment is open"
    if _QUOTES.issuperset(text):
        return "the language has no quotation: symbols and lists stand for themselves"
    if any(mark in text for mark in "[]{}"):
        return "lists are written with parentheses"
    return ""
