"""Findings of before, shown where their forms are now."""

from __future__ import annotations

from collections.abc import Iterator

import msgspec

from rapc.analysis.change import Change
from rapc.analysis.kept import State, form_at
from rapc.base.diagnostics import Diagnostic
from rapc.base.source import Span


class Moving:
    """Moves findings to where their forms are now.

    Args:
        old: the library as it was.
        change: what has changed.
    """

    def __init__(self, old: State, change: Change) -> None:
        self._change = change
        self._before = {
            one.name: [(form.start, form.end) for form in one.forms]
            for one in old.files
            if one.name in change.files
        }

    def moved(self, one: Diagnostic) -> Diagnostic:
        """Return a finding with its places as they are now.

        All of them must be in forms that are still there.
        """
        if not any(span.file in self._change.files for span in spans_of(one)):
            return one
        replace, at = msgspec.structs.replace, self._place
        labels = [replace(label, span=at(label.span)) for label in one.labels]
        fix = one.fix
        if fix is not None:
            edits = [replace(edit, span=at(edit.span)) for edit in fix.edits]
            fix = replace(fix, edits=tuple(edits))
        return replace(one, span=at(one.span), labels=tuple(labels), fix=fix)

    def _place(self, span: Span) -> Span:
        if span.file not in self._change.files:
            return span
        start = form_at(self._before[span.file], span)
        _, now = self._change.moved[span.file, start]
        return Span(span.file, span.start - start + now, span.end - start + now)


def spans_of(found: Diagnostic) -> Iterator[Span]:
    """Yield every place that a finding tells of."""
    yield found.span
    for label in found.labels:
        yield label.span
    for edit in found.fix.edits if found.fix is not None else ():
        yield edit.span
