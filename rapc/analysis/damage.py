"""What a slip of the pen silences: findings that may be due to it, and no others.

From a form with a slip something was left out, so that passes may miss there what the
author has written. How far that reaches depends on the pass (`Check.needs_whole`):

- A pass that looks at a `node` alone is silenced where the slip lies in that node, or
  in the arguments of the declaration that the node is held against.
- What a pass says about a `method` may be due to a slip in that method, or outside of
  all methods; but not to one in another method.
- Some need the whole `form`: a variable used only once may be used in what is lost.

Where parentheses had to be put right nobody can say what belongs where: all findings in
such a form are withheld.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable

import msgspec

from rapc.analysis.check import Whole
from rapc.base.diagnostics import Diagnostic
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.parser.rules.forms import FORM_RULES
from rapc.parser.rules.slips import SLIP_RULES
from rapc.parser.unit import SourceUnit

_OF_FORMS = frozenset(rule.name for rule in (*FORM_RULES, *SLIP_RULES))
"""The rules about forms whose parentheses are in order."""


class _Damaged(msgspec.Struct, frozen=True):
    """A form from which something was left out."""

    form: nodes.TopForm | nodes.DefineTest
    #: Where the slips begin, ascending; none if the parentheses are not in order.
    slips: tuple[int, ...]
    #: Where its arguments are declared; empty if it declares none.
    head: Span

    def lies_in(self, span: Span) -> bool:
        """Whether a slip lies in a part of the form."""
        at = bisect_left(self.slips, span.start)
        return at < len(self.slips) and self.slips[at] < span.end

    def method_at(self, offset: int) -> nodes.Method | None:
        """Return the method at an offset."""
        methods = self.form.methods if isinstance(self.form, nodes.DefineRap) else ()
        return next((m for m in methods if m.span.start <= offset < m.span.end), None)


class Damage:
    """The forms of a library from which something was left out.

    Args:
        units: its files as they were read, those at least that have slips.
    """

    def __init__(self, units: Iterable[SourceUnit]) -> None:
        self._forms: dict[str, list[_Damaged]] = {}
        for unit in units:
            if unit.partial:
                self._forms[unit.file.name] = _damaged(unit)

    def silences(self, finding: Diagnostic, whole: Whole) -> bool:
        """Whether a finding of a pass that needs so much may be due to a slip."""
        if self.reaches(finding.span, whole):
            return True
        labels = [label.span for label in finding.labels]
        return any(self._head_is_damaged(label) for label in labels)

    def reaches(self, place: Span, whole: Whole = "node") -> bool:
        """Whether a slip may have to do with what is found at a place."""
        here = self._at(place)
        return here is not None and _reaches(here, place, whole)

    def lies_in(self, stretch: Span) -> bool:
        """Whether a damaged form lies in a stretch of a text, or is around it."""
        found = self._forms.get(stretch.file, [])
        at = bisect_left(found, stretch.end, key=lambda one: one.form.span.start) - 1
        return at >= 0 and stretch.start < found[at].form.span.end

    def _head_is_damaged(self, place: Span) -> bool:
        """Whether a name at a place was declared with arguments that were lost."""
        there = self._at(place)
        if there is None or not there.head.start <= place.start < there.head.end:
            return False
        return not there.slips or there.lies_in(there.head)

    def _at(self, place: Span) -> _Damaged | None:
        """The damaged form at a place; top-level forms do not overlap."""
        found = self._forms.get(place.file, [])
        at = bisect_right(found, place.start, key=lambda one: one.form.span.start) - 1
        inside = at >= 0 and place.start < found[at].form.span.end
        return found[at] if inside else None


def _reaches(here: _Damaged, place: Span, whole: Whole) -> bool:
    """Whether slips in a form concern a finding there."""
    if not here.slips or whole == "form":
        return True
    if whole == "node":
        return here.lies_in(place)
    own = here.method_at(place.start)
    if own is None or here.lies_in(own.span):
        return True
    return any(here.method_at(slip) is None for slip in here.slips)


def _damaged(unit: SourceUnit) -> list[_Damaged]:
    """The damaged forms of a file, in the order of the text."""
    starts = sorted(d.span.start for d in unit.diagnostics if d.rule in _OF_FORMS)
    found = []
    for partial in unit.partial:
        form = partial.form
        first = bisect_left(starts, form.span.start)
        last = bisect_left(starts, form.span.end)
        slips_ = () if partial.guessed else tuple(starts[first:last])
        found.append(_Damaged(form, slips_, _head(unit.file, form)))
    found.sort(key=lambda one: one.form.span.start)
    return found


def _head(source: SourceFile, form: nodes.TopForm | nodes.DefineTest) -> Span:
    """Return where the arguments of a form are: a RAP's index, all of a declaration."""
    if isinstance(form, nodes.DefineTest):
        return Span(source.name, 0, 0)
    if not isinstance(form, nodes.DefineRap):
        return form.span
    start = form.name_span.start
    end = source.text.find(")", form.name_span.end)
    return Span(source.name, start, form.span.end if end < 0 else end)
