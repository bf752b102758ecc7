"""Findings about a program as data: findings, labels, fixes, rules.

Not here: printing (`rapc.console.findings`), and the severity that a user configures
(`rapc.analysis.driver`).
"""

from __future__ import annotations

import enum
import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import msgspec

from rapc.base.source import Span

_PAGES = Path(__file__).parents[1] / "rules"


class Severity(enum.IntEnum):
    """The severity of a finding; a higher number is more severe."""

    INFO = 1
    WARNING = 2
    ERROR = 3

    @property
    def word(self) -> str:
        """The lower-case word to print."""
        return self.name.lower()


class Label(msgspec.Struct, frozen=True):
    """A further span with a message about it."""

    span: Span
    message: str


class Edit(msgspec.Struct, frozen=True):
    """The replacement of a span by `content`; an empty span inserts."""

    span: Span
    content: str


def edited(text: str, edits: Iterable[Edit]) -> str:
    """Return the text of a file after edits of the file that do not overlap."""
    pieces, at = [], 0
    for edit in sorted(edits, key=lambda edit: edit.span.start):
        pieces += [text[at : edit.span.start], edit.content]
        at = edit.span.end
    return "".join([*pieces, text[at:]])


class Applicability(enum.Enum):
    """The safety of a fix: safe, or unsafe if the fix may change the meaning."""

    SAFE = "safe"
    UNSAFE = "unsafe"


class Fix(msgspec.Struct, frozen=True):
    """A fix: a message and edits that do not overlap."""

    applicability: Applicability
    message: str
    edits: tuple[Edit, ...]

    @classmethod
    def of(cls, message: str, *edits: Edit, sure: bool = False) -> Fix:
        """Return a fix that is safe if it is `sure` to keep the meaning."""
        kind = Applicability.SAFE if sure else Applicability.UNSAFE
        return cls(kind, message, edits)


class Subject(NamedTuple):
    """A name at a span; an empty name stands for a missing variable."""

    place: Span
    name: str = ""


class Diagnostic(msgspec.Struct, frozen=True):
    """A finding: the name of a rule, a message and a span.

    `message` starts in lower case, has no full stop, and puts names in back-ticks.
    `help` is the advice. `label` is printed at the span itself.
    """

    rule: str
    message: str
    span: Span
    label: str = ""
    labels: tuple[Label, ...] = ()
    notes: tuple[str, ...] = ()
    help: str = ""
    fix: Fix | None = None
    #: The subjects of the finding, for the checker: see `rapc.analysis.hiding`.
    about: tuple[Subject, ...] = ()


class RulePage(NamedTuple):
    """The manual page of a rule, without its heading."""

    text: str
    #: The reasons for the rule.
    why: str
    #: A whole file that triggers the rule.
    example: str
    #: The corrected program, without findings.
    better: str


class Rule(msgspec.Struct, frozen=True):
    """A kind of finding."""

    code: str
    name: str
    summary: str
    severity: Severity = Severity.ERROR
    #: Whether the rule is off by default, as a matter of style.
    opt_in: bool = False
    #: The fixes of the rule and their safety, as a phrase; empty if none.
    fix: str = ""
    #: When to ignore the rule, as a phrase; empty for an error never to ignore.
    ignore: str = ""
    #: The sections of T, S and L (docs/language) about the subject of the rule.
    source: str = ""

    @property
    def page_file(self) -> Path:
        """The file of the manual page."""
        return _PAGES / f"{self.name}.md"

    @property
    def page(self) -> RulePage:
        """The manual page of the rule, read from `rapc/rules/NAME.md`."""
        text = self.page_file.read_text(encoding="utf-8")
        block = "```rap\n(.*?)```"
        form = rf"(.*?)\n\n## Example\n\n{block}\n\n## Use instead\n\n{block}\n"
        found = re.fullmatch(form, text, re.DOTALL)
        if found is None:
            raise ValueError(
                f"the page of rule `{self.name}` requires the sections Example "
                "and Use instead"
            )
        return RulePage(text, *found.groups())

    def at(
        self,
        span: Span,
        message: str,
        *,
        label: str = "",
        labels: tuple[Label, ...] = (),
        notes: tuple[str, ...] = (),
        help: str = "",
        fix: Fix | None = None,
        about: tuple[Subject, ...] = (),
    ) -> Diagnostic:
        """Return a finding of this rule; see `Diagnostic` for the arguments."""
        return Diagnostic(
            self.name, message, span, label, labels, notes, help, fix, about
        )
