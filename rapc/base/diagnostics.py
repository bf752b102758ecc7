"""What is said about a program, as data: findings, labels, fixes, rules.

Nothing here prints (see `rapc.console.findings`) and nothing here decides how grave a
finding is for a given user: severity belongs to the rule and to the driver
(`rapc.analysis.driver`), which may be configured.
"""

from __future__ import annotations

import enum
from typing import NamedTuple

import msgspec

from rapc.base.source import Span


class Severity(enum.IntEnum):
    """How grave a finding is; higher is graver."""

    INFO = 1
    WARNING = 2
    ERROR = 3

    @property
    def word(self) -> str:
        """The lower-case word that is printed."""
        return self.name.lower()


class Label(msgspec.Struct, frozen=True):
    """A further place with what is to be seen there."""

    span: Span
    message: str


class Edit(msgspec.Struct, frozen=True):
    """Replace a span by `content` (an empty span inserts)."""

    span: Span
    content: str


class Applicability(enum.Enum):
    """Whether a fix keeps the meaning (safe) or may change it."""

    SAFE = "safe"
    UNSAFE = "unsafe"


class Fix(msgspec.Struct, frozen=True):
    """A repair: what it does, in words and as edits that do not overlap."""

    applicability: Applicability
    message: str
    edits: tuple[Edit, ...]

    @classmethod
    def of(cls, message: str, *edits: Edit, sure: bool = False) -> Fix:
        """Return a fix that is safe if it is `sure` to keep the meaning."""
        kind = Applicability.SAFE if sure else Applicability.UNSAFE
        return cls(kind, message, edits)


class Subject(NamedTuple):
    """A name at a place; no name stands for a variable that is missing there."""

    place: Span
    name: str = ""


class Diagnostic(msgspec.Struct, frozen=True):
    """One finding: a rule's name, a sentence and the place it is about.

    `message` starts in lower case, has no full stop, and puts names in back-ticks;
    what to do about it goes into `help`. `label` is printed at the span itself.
    """

    rule: str
    message: str
    span: Span
    label: str = ""
    labels: tuple[Label, ...] = ()
    notes: tuple[str, ...] = ()
    help: str = ""
    fix: Fix | None = None
    #: What it is about, for the checker: see `rapc.analysis.hiding`.
    about: tuple[Subject, ...] = ()


class Rule(msgspec.Struct, frozen=True):
    """One kind of finding and its manual page.

    `example` is a whole file that triggers the rule, `better` the same program
    put right, in which nothing is found; both are checked by a test.
    """

    code: str
    name: str
    summary: str
    why: str
    example: str
    better: str
    severity: Severity = Severity.ERROR
    #: Whether the rule reports only where a user asks for it: a matter of style.
    opt_in: bool = False
    #: Which fixes it has and whether they are safe, as a phrase; nothing if none.
    fix: str = ""
    #: When to ignore it, as a phrase; nothing of an error that never is to be.
    ignore: str = ""
    #: Where the language has what it is about: sections of T, S and L (docs/language).
    source: str = ""

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
        """Return a finding by this rule; see `Diagnostic` for its parts."""
        return Diagnostic(
            self.name, message, span, label, labels, notes, help, fix, about
        )
