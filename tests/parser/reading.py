"""What the tests of the front end share: shorter ways to ask."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise

from rapc.base.diagnostics import Diagnostic
from rapc.base.source import SourceFile, Span
from rapc.parser.parse import parse
from rapc.parser.reader import read
from rapc.parser.syntax import Datum, List, Reading
from rapc.parser.unit import SourceUnit

FILE = "test.rap"


def reading(text: str) -> Reading:
    """A text read to data."""
    return read(SourceFile(FILE, text))


@lru_cache(maxsize=4)
def parsed(text: str) -> SourceUnit:
    """A text read to IR."""
    return parse(SourceFile(FILE, text))


def rules(text: str) -> list[str]:
    """The names of the rules that a text breaks."""
    return [found.rule for found in parsed(text).diagnostics]


def only(text: str) -> Diagnostic:
    """The one finding in a text."""
    (found,) = parsed(text).diagnostics
    return found


def shown(text: str, span: Span) -> str:
    """The stretch of a text that a span covers."""
    return text[span.start : span.end]


def fixed(text: str) -> str:
    """A text with all fixes applied that are offered for it."""
    fixes = [found.fix for found in parsed(text).diagnostics if found.fix]
    edits = [edit for fix in fixes for edit in fix.edits]
    for edit in sorted(edits, key=lambda edit: -edit.span.start):
        text = text[: edit.span.start] + edit.content + text[edit.span.end :]
    return text


Plain = tuple[str, object, int, int]
"""A datum as class name, value (for lists their items), start and end."""


def plain(datum: Datum) -> Plain:
    """A datum in a form that tests can compare and print."""
    kind = type(datum).__name__
    if isinstance(datum, List):
        items = tuple(plain(item) for item in datum.items)
        return (kind, items, datum.start, datum.end)
    value = getattr(datum, "name", None)
    if value is None:
        value = getattr(datum, "value", None)
    return (kind, value, datum.start, datum.end)


def hold_places(text: str) -> None:
    """Everything said lies in the text, and fixes can be carried out."""
    made = parsed(text)
    for found in made.diagnostics:
        spans = [found.span, *(label.span for label in found.labels)]
        edits = sorted(found.fix.edits, key=lambda e: e.span.start) if found.fix else []
        for span in (*spans, *(edit.span for edit in edits)):
            assert span.file == FILE
            assert 0 <= span.start <= span.end <= len(text) + 1
        for one, other in pairwise(edits):
            assert one.span.end <= other.span.start
    for form in made.forms:
        assert 0 <= form.span.start < form.span.end <= len(text)
