"""Findings that a syntax error may cause, and that are therefore withheld.

The parser leaves out parts of a form with a syntax error. A check may then miss code
that the author has written. The reach of the error depends on the check
(`Check.needs_whole`):

- `node`: the finding is withheld if the error lies in the node of the finding, or in
  the arguments of the declaration that the check compares the node with.
- `method`: the finding is withheld if the error lies in the same method, or outside of
  all methods; an error in another method does not count.
- `form`: the finding is withheld if the error lies anywhere in the form. For example, a
  variable used only once may have a second use in the lost text.

If the reader had to repair parentheses, the structure of the form is not certain. All
findings in that form are withheld.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator

import msgspec

from rapc.analysis.check import Whole
from rapc.base.diagnostics import Diagnostic
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.parser.rules.forms import FORM_RULES
from rapc.parser.rules.slips import SLIP_RULES
from rapc.parser.unit import SourceUnit

_OF_FORMS = frozenset(rule.name for rule in (*FORM_RULES, *SLIP_RULES))
"""The rules about forms whose parentheses match."""


_Part = tuple[Span, str]
"""The span of a form that defines a RAP or adds a method, and the name of the RAP."""


def _rap_of(form: nodes.TopForm | nodes.DefineTest) -> str:
    """Return the RAP that a form defines completely or in part; else no text."""
    if isinstance(form, nodes.DefineMethod):
        return form.rap
    return form.name if isinstance(form, nodes.DefineRap) else ""


class _Damaged(msgspec.Struct, frozen=True):
    """A form with parts left out."""

    form: nodes.TopForm | nodes.DefineTest
    #: The start of each syntax error, ascending; empty if parentheses do not match.
    slips: tuple[int, ...]
    #: The span of the declared arguments; empty without a declaration of arguments.
    head: Span

    def lies_in(self, span: Span) -> bool:
        """Return whether a syntax error lies in a part of the form."""
        at = bisect_left(self.slips, span.start)
        return at < len(self.slips) and self.slips[at] < span.end

    def method_at(self, offset: int) -> nodes.Method | None:
        """Return the method at an offset."""
        methods = _methods(self.form)
        return next((m for m in methods if m.span.start <= offset < m.span.end), None)


def _methods(form: nodes.TopForm | nodes.DefineTest) -> tuple[nodes.Method, ...]:
    if isinstance(form, nodes.DefineMethod):
        return (form.method,)
    return form.methods if isinstance(form, nodes.DefineRap) else ()


class Damage:
    """The forms of a library with parts left out.

    Args:
        units: the parsed files of the library, at least all files with syntax errors.
    """

    def __init__(self, units: Iterable[SourceUnit]) -> None:
        self._forms: dict[str, list[_Damaged]] = {}
        #: The forms of each RAP with added methods, by file; and those damaged, by RAP.
        self._parts: dict[str, list[_Part]] = {}
        self._of_rap: dict[str, list[_Damaged]] = {}
        units = list(units)
        for unit in units:
            if unit.partial:
                self._forms[unit.file.name] = _damaged(unit)
        if self._forms:
            self._join(units)

    def _join(self, units: Iterable[SourceUnit]) -> None:
        """Record which forms define a RAP together."""
        forms = [form for unit in units for form in unit.forms]
        added = {form.rap for form in forms if isinstance(form, nodes.DefineMethod)}
        for form in forms if added else ():
            if (name := _rap_of(form)) in added:
                self._parts.setdefault(form.span.file, []).append((form.span, name))
        for damaged in (one for many in self._forms.values() for one in many):
            if (name := _rap_of(damaged.form)) in added:
                self._of_rap.setdefault(name, []).append(damaged)

    def silences(self, finding: Diagnostic, whole: Whole) -> bool:
        """Return whether a finding of a check with this need may be due to an error."""
        if self.reaches(finding.span, whole):
            return True
        labels = [label.span for label in finding.labels]
        return any(self._head_is_damaged(label) for label in labels)

    def reaches(self, place: Span, whole: Whole = "node") -> bool:
        """Return whether a syntax error may affect the code at a place."""
        here = self._at(place)
        if here is not None and _reaches(here, place, whole):
            return True
        return any(_reaches_others(one, whole) for one in self._others(place, whole))

    def _others(self, place: Span, whole: Whole) -> Iterator[_Damaged]:
        """Yield the other damaged forms of the RAP whose form is at a place.

        For a check that needs a node, only if the node is the whole form.
        """
        for form, name in self._parts.get(place.file, ()):
            inside = form.start <= place.start < form.end
            if place.contains(form) or (inside and whole != "node"):
                for one in self._of_rap.get(name, ()):
                    if one.form.span != form:
                        yield one

    def lies_in(self, stretch: Span) -> bool:
        """Return whether a damaged form overlaps a span of text."""
        found = self._forms.get(stretch.file, [])
        at = bisect_left(found, stretch.end, key=lambda one: one.form.span.start) - 1
        return at >= 0 and stretch.start < found[at].form.span.end

    def _head_is_damaged(self, place: Span) -> bool:
        """Return whether the declaration of the name at a place has lost arguments."""
        there = self._at(place)
        if there is None or not there.head.start <= place.start < there.head.end:
            return False
        return not there.slips or there.lies_in(there.head)

    def _at(self, place: Span) -> _Damaged | None:
        """Return the damaged form at a place; top-level forms do not overlap."""
        found = self._forms.get(place.file, [])
        at = bisect_right(found, place.start, key=lambda one: one.form.span.start) - 1
        inside = at >= 0 and place.start < found[at].form.span.end
        return found[at] if inside else None


def _reaches_others(here: _Damaged, whole: Whole) -> bool:
    """Return whether the syntax errors of a form affect other forms of its RAP."""
    if not here.slips or whole != "method":
        return True
    return any(here.method_at(slip) is None for slip in here.slips)


def _reaches(here: _Damaged, place: Span, whole: Whole) -> bool:
    """Return whether the syntax errors of a form affect a finding at a place."""
    if not here.slips or whole == "form":
        return True
    if whole == "node":
        return here.lies_in(place)
    own = here.method_at(place.start)
    if own is None or here.lies_in(own.span):
        return True
    return any(here.method_at(slip) is None for slip in here.slips)


def _damaged(unit: SourceUnit) -> list[_Damaged]:
    """Return the damaged forms of a file, in the order of the text."""
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
    """Return the span of the arguments: a RAP's index, or a whole declaration."""
    if isinstance(form, nodes.DefineTest):
        return Span(source.name, 0, 0)
    if not isinstance(form, nodes.DefineRap):
        return form.span
    start = form.name_span.start
    end = source.text.find(")", form.name_span.end)
    return Span(source.name, start, form.span.end if end < 0 else end)
