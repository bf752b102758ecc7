"""Findings that hide others: a slip is reported, its consequences are not.

Checks do not know of each other. A finding says what it is `about`; the rows of `HIDES`
say which findings about the same are consequences. A finding that is hidden itself, or
suppressed, still hides others.
"""

from __future__ import annotations

from bisect import bisect_right
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Literal, NamedTuple

from rapc.base.diagnostics import Diagnostic
from rapc.base.source import Span


class Row(NamedTuple):
    """One reason to hide findings: the rules that hide, and those that are hidden."""

    by: tuple[str, ...]
    hidden: tuple[str, ...]
    #: What both are about: the same form; a name in it; a place that holds the other;
    #: or a variable that nothing binds, one for each that the first finding lacks.
    same: Literal["form", "name", "place", "lack"]


_CONSTANTS = ("misspelt-constant", "foreign-constant", "mixed-values")
_RESOURCES = ("wrong-resource-kind", "not-a-resource")

HIDES = (
    # Where kinds are mixed up, so are the values.
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
    # A word that does not belong may be a variable that has lost its question mark.
    Row((*_CONSTANTS, "wrong-kind"), ("unbound-variable", "marked-constant"), "name"),
    # A fact in place of a computed value binds nothing, though it was meant to.
    Row(("undeclared-function", "wrong-step-arity"), ("unbound-variable",), "name"),
    Row(("undeclared-function",), ("anonymous-variable",), "place"),
    # The variable that was left out, or meant in place of an input, is not bound.
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
    # A resource that is taken for another one is used where that one should be.
    Row(_RESOURCES, ("resource-as-value",), "name"),
    Row(_RESOURCES, ("idle-resource", "unread-resource"), "form"),
    # What succeeds at once never chooses a method.
    Row(("succeeds-at-once",), ("unreachable-method", "hopeless-goal"), "form"),
    Row(("unheard-monitor",), ("endless-reaction",), "form"),
)
"""Which findings are consequences of others."""


def with_hiders(rules: Collection[str]) -> frozenset[str]:
    """Return some rules with those that may hide findings by them."""
    rows = [row for row in HIDES if not set(row.hidden).isdisjoint(rules)]
    return frozenset(rules).union(*[row.by for row in rows])


def visible(found: Sequence[Diagnostic], forms: Iterable[Span]) -> list[Diagnostic]:
    """Return the findings that no other one hides.

    Args:
        found: the findings.
        forms: where the top-level forms are; they do not overlap.
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
    """The top-level forms of a library, by their places."""

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
        """Return the names that a finding is about, with their forms."""
        return {(self.at(s.place), s.name) for s in one.about if s.name}

    def lacks(self, one: Diagnostic) -> list[Span | None]:
        """Return the form of each variable that a finding lacks."""
        return [self.at(s.place) for s in one.about if not s.name]
