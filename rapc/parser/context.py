"""What every reader of data works with: places, findings, the other readers.

A reader takes a `Context` and a datum, reports what is wrong with it in the author's
words, and returns the node, or None if nothing could be made of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Protocol, TypedDict, Unpack

import msgspec

from rapc.base.diagnostics import Diagnostic, Edit, Fix, Label
from rapc.base.names import nearest
from rapc.base.source import SourceFile, Span
from rapc.language.grammar import GRAMMAR
from rapc.language.heads import ARROW, SLIPS, spelling
from rapc.parser.syntax import (
    Arrow,
    Datum,
    Keyword,
    List,
    Numeral,
    String,
    Symbol,
    Variable,
)

Read = Callable[["Context", Any], Any]
"""Makes something of a datum, or of a list alone; None if it had to be left out."""

_KINDS = {
    Symbol: "a symbol",
    Arrow: f"the mark `{ARROW}`",
    Variable: "a variable",
    Keyword: "a keyword",
    Numeral: "a number",
    String: "a string",
    List: "a list",
}


_MISPLACED = {
    ("option of `task`", ":at"): "a task that begins later stands in an `at`: "
    "`(at 130 (task ...))`",
}
"""Help for a word that belongs elsewhere, by what it would be here and the word."""


class OptionReader(msgspec.Struct, frozen=True):
    """What reads an option: a list that begins with its word."""

    #: How many values stand behind the word.
    values: int
    read: Read


class Readers(Protocol):
    """Readers by the name of their rule in the grammar, and by the words of a group."""

    def __getitem__(self, rule: str, /) -> Read:
        """Return the reader of a rule."""

    @property
    def formulas(self) -> dict[str, Read]:
        """Return the readers of formulas by the words that head them."""

    def group(self, rule: str) -> dict[str, Read]:
        """Return the readers of the lists in a group by the words that head them."""

    def option(self, rule: str) -> OptionReader:
        """Return what reads an option, with the number of its values."""


class Details(TypedDict, total=False):
    """What a finding may say besides its message."""

    #: Other data that the finding points at, each with what is said of it.
    labels: Iterable[tuple[Datum, str]]
    #: What to do about it.
    help: str
    #: The change of the text that would cure it.
    fix: Fix | None


class Context:
    """The form in hand, its file, and what has been said about it."""

    #: The name of the file, as spans carry it.
    file: str
    #: How many findings are kept.
    room: int
    #: Whether the reader had to guess at something: then only words that print has had
    #: for others are told, for all other faults might be due to the guess.
    damaged: bool = False
    #: Whether a parenthesis too many stands behind the form: then only slips whose
    #: meaning is clear are told, for the first of the pair may have been lost.
    surplus: bool = False
    #: What has been found in the form.
    diagnostics: list[Diagnostic]
    #: Whether something of the form had to be left out.
    incomplete: bool = False

    def __init__(self, source: SourceFile, room: int, readers: Readers) -> None:
        self.source = source
        self.file = source.name
        self.room = room
        self.readers = readers
        self.formulas = readers.formulas
        self.diagnostics = []

    def span(self, datum: Datum) -> Span:
        """The place of a datum."""
        return Span(self.file, datum.start, datum.end)

    def text(self, datum: Datum) -> str:
        """A datum as it was written."""
        return self.source.text[datum.start : datum.end]

    def report(
        self, rule: str, message: str, at: Datum, **more: Unpack[Details]
    ) -> None:
        """Report a fault for which something of the form is left out."""
        self.incomplete = True
        if not self.surplus:
            self.report_fixable(rule, message, at, **more)

    def report_fixable(
        self, rule: str, message: str, at: Datum, **more: Unpack[Details]
    ) -> None:
        """Report a fault whose meaning is clear, so that nothing is left out."""
        if not self.damaged:
            self.certain(rule, message, at, **more)

    def certain(
        self,
        rule: str,
        message: str,
        at: Datum,
        *,
        labels: Iterable[tuple[Datum, str]] = (),
        help: str = "",
        fix: Fix | None = None,
    ) -> None:
        """Report a fault that no parenthesis guessed at can have brought about."""
        if len(self.diagnostics) < self.room:
            shown = tuple(Label(self.span(d), text) for d, text in labels)
            place = self.span(at)
            self.diagnostics.append(
                Diagnostic(rule, message, place, labels=shown, help=help, fix=fix)
            )

    def wrong(self, rule: str, datum: Datum) -> None:
        """Report a datum that does not fit a rule of the grammar."""
        said, name = GRAMMAR[rule], head_of(datum)
        kind = kind_of(datum)
        if isinstance(datum, List) and name is None:
            kind = "a list without a name" if datum.items else "an empty list"
        message = said.wrong.format(kind=kind)
        if not message:
            takes = f"takes {said.takes}" if said.takes else ""
            message = f"`{name}` {takes or f'is written `{spelling(rule)}`'}"
        self.report(said.breaks, message, datum, help=said.help)

    def replace(self, datum: Datum, content: str, *, sure: bool = True) -> Fix:
        """The fix that writes `content` in place of a datum."""
        edit = Edit(self.span(datum), content)
        return Fix.of(f"write `{content}`", edit, sure=sure)

    def insert(self, offset: int, content: str, *, sure: bool = True) -> Fix:
        """The fix that inserts `content`."""
        edit = Edit(self.source.span(offset, offset), content)
        return Fix.of(f"insert `{content.strip()}`", edit, sure=sure)

    def wrap(self, first: Datum, last: Datum, left: str, *, sure: bool = True) -> Fix:
        """The fix that puts `left` before some data and `)` behind them."""
        before = Edit(self.source.span(first.start, first.start), left)
        after = Edit(self.source.span(last.end, last.end), ")")
        return Fix.of("put parentheses around it", before, after, sure=sure)

    def unknown(
        self, rule: str, what: str, word: Symbol | Keyword, known: Iterable[str]
    ) -> str | None:
        """Report a word that is not among the known ones; returns what was meant.

        The answer is None where that can only be guessed.
        """
        options = tuple(known)
        printed = SLIPS.get(word.name)
        if printed in options:
            self.certain(
                rule,
                f"the {what} is called `{printed}`, not `{word.name}`",
                word,
                fix=self.replace(word, printed),
            )
            return printed
        if len(self.diagnostics) >= self.room:
            self.incomplete = True
            return None
        slips = {slip: right for slip, right in SLIPS.items() if right in options}
        meant = nearest(word.name, (*options, *slips))
        if meant not in options:
            meant = slips.get(meant or "")
        self.report(
            rule,
            f"`{word.name}` is no {what}",
            word,
            help=f"did you mean `{meant}`?"
            if meant
            else _MISPLACED.get((what, word.name))
            or "known are " + ", ".join(f"`{option}`" for option in options),
            fix=self.replace(word, meant, sure=False) if meant else None,
        )
        return meant


def kind_of(datum: Datum) -> str:
    """Return what a datum is, with its article."""
    return _KINDS[type(datum)]


def head_of(datum: Datum) -> str | None:
    """The name of the symbol that heads a list, or None."""
    if type(datum) is List and datum.items:
        first = datum.items[0]
        if type(first) is Symbol:
            return first.name
    return None
