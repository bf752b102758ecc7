"""Findings that hide others: the cause is reported, its consequences are not.

Checks do not depend on each other. A finding declares its subject (`about`). The rows
of `HIDES` state which findings with the same subject are consequences. A finding that
is itself hidden or suppressed still hides others.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Literal, NamedTuple

from rapc.base.diagnostics import Diagnostic
from rapc.base.source import Span


class Row(NamedTuple):
    """A row of `HIDES`: the rules that hide, and the rules that are hidden."""

    by: tuple[str, ...]
    hidden: tuple[str, ...]
    #: The subject that both findings share: the same form; a name in the form; a place
    #: that contains the other place; or a variable that the first finding lists as
    #: unbound.
    same: Literal["form", "name", "place", "lack"]


_CONSTANTS = ("misspelt-constant", "foreign-constant", "mixed-values")
_RESOURCES = ("wrong-resource-kind", "not-a-resource")

HIDES = (
    # If kinds are confused, the values are confused, too.
    Row(
        ("kinds-apart",),
        (
            *_CONSTANTS,
            "swapped-arguments",
            "hopeless-goal",
            "endless-reaction",
            "empty-promise",
        ),
        "form",
    ),
    # An unexpected word may be a variable without its question mark.
    Row((*_CONSTANTS, "wrong-kind"), ("unbound-variable", "marked-constant"), "name"),
    # A fact in place of a computed value binds no variable, against the intention.
    Row(("undeclared-function", "wrong-step-arity"), ("unbound-variable",), "name"),
    Row(("undeclared-function",), ("anonymous-variable",), "place"),
    # A variable that was left out, or confused with an input, is not bound.
    Row(
        ("output-is-input", "wrong-fact-arity", "wrong-step-arity"),
        ("unbound-variable",),
        "lack",
    ),
    Row(
        ("unbound-variable",),
        ("not-a-resource", "marked-constant", "misspelt-variable"),
        "name",
    ),
    # If two resources are confused, the wrong resource is used.
    Row(_RESOURCES, ("resource-as-value",), "name"),
    Row(_RESOURCES, ("idle-resource", "unread-resource"), "form"),
    # A RAP that succeeds at once never chooses a method.
    Row(("succeeds-at-once",), ("unreachable-method", "hopeless-goal"), "form"),
    Row(("unheard-monitor",), ("endless-reaction",), "form"),
)
"""The findings that are consequences of other findings."""


def with_hiders(rules: Collection[str]) -> frozenset[str]:
    """Return some rules together with the rules that may hide their findings."""
    rows = [row for row in HIDES if not set(row.hidden).isdisjoint(rules)]
    return frozenset(rules).union(*[row.by for row in rows])


def visible(found: Sequence[Diagnostic], forms: Iterable[Span]) -> list[Diagnostic]:
    """Return the findings that no other finding hides.

    Args:
        found: the findings.
        forms: the spans of the top-level forms; spans do not overlap.
    """
    there = _Forms(forms)
    hidden: set[int] = set()
    for row in HIDES:
        by = [one for one in found if one.rule in row.by]
        if by:
            left = [one for one in found if one.rule in row.hidden]
            left = [one for one in left if id(one) not in hidden]
            hidden.update(id(one) for one in _consequences(row, by, left, there))
    return [one for one in found if id(one) not in hidden]


def _consequences(
    row: Row, by: Iterable[Diagnostic], among: Iterable[Diagnostic], forms: _Forms
) -> Iterator[Diagnostic]:
    match row.same:
        case "form":
            mixed = {forms.at(one.span) for one in by}
            yield from [one for one in among if forms.at(one.span) in mixed]
        case "name":
            names = {key for one in by for key in forms.names(one)}
            yield from [one for one in among if not names.isdisjoint(forms.names(one))]
        case "place":
            places = [subject.place for one in by for subject in one.about]
            yield from [one for one in among if any(_holds(p, one) for p in places)]
        case "lack":
            lacks = Counter(form for one in by for form in forms.lacks(one))
            lacking: dict[tuple[Span | None, str], None] = {}
            for one in among:
                for form in forms.lacks(one):
                    ((_, name),) = forms.names(one)
                    if lacks[form] > 0 and (form, name) not in lacking:
                        lacks[form] -= 1
                        lacking[form, name] = None
                    if (form, name) in lacking:
                        yield one


def _holds(place: Span, one: Diagnostic) -> bool:
    inner = one.span
    return (
        place.file == inner.file
        and place.start <= inner.start
        and inner.end <= place.end
    )


class _Forms:
    """The top-level forms of a library, by position."""

    def __init__(self, forms: Iterable[Span]) -> None:
        self._forms: dict[str, list[Span]] = {}
        for form in forms:
            self._forms.setdefault(form.file, []).append(form)
        for own in self._forms.values():
            own.sort(key=lambda form: form.start)

    def at(self, place: Span) -> Span | None:
        """Return the form at a place."""
        own = self._forms.get(place.file, [])
        at = bisect_right(own, place.start, key=lambda form: form.start) - 1
        return own[at] if at >= 0 else None

    def names(self, one: Diagnostic) -> set[tuple[Span | None, str]]:
        """Return the names that a finding is about, with the form of each name."""
        return {(self.at(s.place), s.name) for s in one.about if s.name}

    def lacks(self, one: Diagnostic) -> list[Span | None]:
        """Return, for each unbound variable that a finding lists, its form."""
        return [self.at(s.place) for s in one.about if not s.name]
