"""The context of all readers of data: spans, findings and the other readers.

A reader takes a `Context` and a datum, reports faults in the author's words, and
returns the node, or None if the datum has no valid meaning.
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
"""A reader: returns the meaning of a datum, or of a list only; None if left out."""

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
    (
        "option of `task`",
        ":at",
    ): "a task that begins later is written in an `at`: `(at 130 (task ...))`",
}
"""The help for a misplaced word, by its use at this position and the word."""


class OptionReader(msgspec.Struct, frozen=True):
    """A reader of an option, that is, of a list that begins with the option's word."""

    #: The number of values after the word.
    values: int
    read: Read


class Readers(Protocol):
    """The readers by grammar rule, and by the first words of a group."""

    def __getitem__(self, rule: str, /) -> Read:
        """Return the reader of a rule."""

    @property
    def formulas(self) -> dict[str, Read]:
        """Return the readers of formulas by first word."""

    def group(self, rule: str) -> dict[str, Read]:
        """Return the readers of the lists in a group by first word."""

    def option(self, rule: str) -> OptionReader:
        """Return the reader of an option, with the number of its values."""


class Details(TypedDict, total=False):
    """The parts of a finding besides its message."""

    #: Further data of the finding, each with a message.
    labels: Iterable[tuple[Datum, str]]
    #: The help.
    help: str
    #: The fix.
    fix: Fix | None


class Context:
    """The state of reading a form: its file and its findings."""

    #: The name of the file in spans.
    file: str
    #: The maximal number of findings.
    room: int
    #: Whether the reader guessed a part of the form. If so, only published slips are
    #: reported, because the guess may cause all other faults.
    damaged: bool = False
    #: Whether a surplus `)` follows the form. If so, only slips with a clear meaning
    #: are reported, because the `(` of the pair may be missing.
    surplus: bool = False
    #: The findings in the form.
    diagnostics: list[Diagnostic]
    #: Whether a part of the form was left out.
    incomplete: bool = False

    def __init__(self, source: SourceFile, room: int, readers: Readers) -> None:
        self.source = source
        self.file = source.name
        self.room = room
        self.readers = readers
        self.formulas = readers.formulas
        self.diagnostics = []

    def span(self, datum: Datum) -> Span:
        """Return the span of a datum."""
        return Span(self.file, datum.start, datum.end)

    def text(self, datum: Datum) -> str:
        """Return the source text of a datum."""
        return self.source.text[datum.start : datum.end]

    def report(
        self, rule: str, message: str, at: Datum, **more: Unpack[Details]
    ) -> None:
        """Report a fault that leaves a part of the form out."""
        self.incomplete = True
        if not self.surplus:
            self.report_fixable(rule, message, at, **more)

    def report_fixable(
        self, rule: str, message: str, at: Datum, **more: Unpack[Details]
    ) -> None:
        """Report a fault with a clear meaning, which leaves nothing out."""
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
        """Report a fault that cannot be due to a guessed parenthesis."""
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
        """Return the fix that writes `content` in place of a datum."""
        edit = Edit(self.span(datum), content)
        return Fix.of(f"write `{content}`", edit, sure=sure)

    def insert(self, offset: int, content: str, *, sure: bool = True) -> Fix:
        """Return the fix that inserts `content`."""
        edit = Edit(self.source.span(offset, offset), content)
        return Fix.of(f"insert `{content.strip()}`", edit, sure=sure)

    def wrap(self, first: Datum, last: Datum, left: str, *, sure: bool = True) -> Fix:
        """Return the fix that puts `left` before some data and `)` after the data."""
        before = Edit(self.source.span(first.start, first.start), left)
        after = Edit(self.source.span(last.end, last.end), ")")
        return Fix.of("add parentheses", before, after, sure=sure)

    def unknown(
        self, rule: str, what: str, word: Symbol | Keyword, known: Iterable[str]
    ) -> str | None:
        """Report a word that is not among the known words; return a similar word.

        The result is None if no known word is similar.
        """
        options = tuple(known)
        group, of, owner = what.partition(" of ")
        message = f"unknown {group} `{word.name}`{of}{owner}"
        printed = SLIPS.get(word.name)
        if printed in options:
            self.certain(
                rule,
                message,
                word,
                help=f"did you mean `{printed}`?",
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
            message,
            word,
            help=f"did you mean `{meant}`?"
            if meant
            else _MISPLACED.get((what, word.name))
            or "expected one of " + ", ".join(f"`{option}`" for option in options),
            fix=self.replace(word, meant, sure=False) if meant else None,
        )
        return meant


def kind_of(datum: Datum) -> str:
    """Return the kind of a datum in words, with its article."""
    return _KINDS[type(datum)]


def head_of(datum: Datum) -> str | None:
    """Return the name of the symbol at the head of a list, or None."""
    if type(datum) is List and datum.items:
        first = datum.items[0]
        if type(first) is Symbol:
            return first.name
    return None
