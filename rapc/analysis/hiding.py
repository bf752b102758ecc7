"""Findings that hide others: the cause is reported, its consequences are not.

Checks do not depend on each other. A finding declares its subjects (`about`): names
with their places, or variables that are missing, without names. The rows of `HIDES`
state which findings with the same subject are consequences. A finding that is itself
hidden or suppressed still hides others.
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
    #: The subject that both findings share:
    #: - `form`: the top-level form of the finding.
    #: - `name`: a name in the same form.
    #: - `place`: the place of the hidden finding lies in a subject of the first one.
    #: - `missing`: the first finding states that variables of a form are missing, but
    #:   not which. It hides findings about as many different variables of the form.
    #: - `library`: any place.
    same: Literal["form", "name", "place", "missing", "library"]


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
    # A query that uses itself in place of a fact has the arguments of that fact.
    Row(
        ("query-in-a-circle",),
        ("unbound-variable", "not-a-fact"),
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
        "missing",
    ),
    Row(
        ("unbound-variable",),
        ("not-a-resource", "marked-constant", "misspelt-variable", "stray-variable"),
        "name",
    ),
    Row(("misspelt-variable", "marked-constant"), ("stray-variable",), "name"),
    Row(
        (
            "unbound-variable",
            "misspelt-variable",
            "marked-constant",
            "stray-variable",
        ),
        ("idle-part",),
        "name",
    ),
    # A variable in place of an input makes a formula hold for any value.
    Row(("stray-variable",), ("succeeds-at-once", "unreachable-method"), "form"),
    Row(("unheard-monitor", "vain-protection"), ("stray-variable",), "form"),
    Row(("idle-part",), ("succeeds-at-once",), "form"),
    Row(("standing-task-ends",), ("monitor-always-holds",), "form"),
    Row(("monitor-always-holds", "age-in-monitor"), ("idle-wait",), "form"),
    Row(("stray-variable",), ("uncompared-number", "idle-wait"), "form"),
    Row(("uncompared-number",), ("idle-part",), "name"),
    Row(
        ("monitor-always-holds", "settled-comparison", "contradiction"),
        ("idle-part", "stray-variable"),
        "form",
    ),
    # If two resources are confused, the wrong resource is used.
    Row(_RESOURCES, ("resource-as-value",), "name"),
    Row(_RESOURCES, ("idle-resource", "unread-resource"), "form"),
    # A RAP that succeeds at once never chooses a method.
    Row(("succeeds-at-once",), ("unreachable-method", "hopeless-goal"), "form"),
    Row(("unheard-monitor",), ("endless-reaction",), "form"),
    Row(("unheard-monitor",), ("idle-net",), "form"),
    # Methods that were copied and then spoilt are reported for the spoilt part.
    Row(("unreachable-method", *_CONSTANTS), ("copied-method",), "form"),
    # A goal that nothing brings about is found with its cause.
    Row(
        (
            "hopeless-goal",
            "unreachable-method",
            "vain-protection",
            "endless-reaction",
        ),
        ("contrary-step", "needless-step"),
        "form",
    ),
    Row(("kinds-apart",), ("unordered-steps", "copied-step"), "form"),
    # A plan without its RAPs or its goal has nothing to plan with.
    Row(("no-operator",), ("nothing-to-plan-with",), "form"),
    Row(("unbound-variable", "plan-without-goal"), ("left-out-of-planning",), "form"),
    # A step or a method that is missing leaves a RAP without a caller.
    Row(
        (
            "endless-reaction",
            "first-otherwise",
            "hopeless-goal",
            "idle-net",
            "idle-resource",
            "needless-step",
            "needs-itself",
            "unknown-rap",
            "unknown-tag",
            "unlimited-loop",
            "unordered-steps",
        ),
        ("forgotten-rap",),
        "library",
    ),
    # A loop that is lost or never begins needs no limit.
    Row(
        (
            *_RESOURCES,
            "idle-loop",
            "idle-net",
            "idle-resource",
            "succeeds-at-once",
            "unbound-variable",
            "unreachable-method",
        ),
        ("unlimited-loop",),
        "form",
    ),
    Row(("unbound-variable",), ("idle-precondition", "needless-step"), "form"),
    Row(("standing-task-ends", "idle-loop"), ("early-end",), "form"),
    # A misspelt value differs from the value in other clauses.
    Row((*_CONSTANTS, "wrong-kind", "kinds-apart"), ("contrary-step",), "library"),
    Row(("unordered-steps",), ("idle-step",), "form"),
    # A loop as a precondition queries what the loop was to bind.
    Row(("idle-precondition",), ("uncompared-number", "idle-part"), "form"),
    Row(("unused-claim", "misspelt-thing"), ("vain-claim",), "form"),
)
"""The findings that are consequences of other findings."""


def with_hiders(rules: Collection[str]) -> frozenset[str]:
    """Return some rules together with the rules that may hide their findings."""
    rows = [row for row in HIDES if not set(row.hidden).isdisjoint(rules)]
    return frozenset(rules).union(*[row.by for row in rows])


def visible(
    found: Sequence[Diagnostic], forms: Iterable[tuple[Span, Span]]
) -> list[Diagnostic]:
    """Return the findings that no other finding hides.

    Args:
        found: the findings.
        forms: the spans of the top-level forms, which do not overlap, each with the
            span of the form that it belongs to: for an added method that of the RAP.
    """
    by_position = _Forms(forms)
    hidden: set[int] = set()
    for row in HIDES:
        causes = [finding for finding in found if finding.rule in row.by]
        if causes:
            left = [finding for finding in found if finding.rule in row.hidden]
            left = [finding for finding in left if id(finding) not in hidden]
            consequences = _consequences(row, causes, left, by_position)
            hidden.update(id(finding) for finding in consequences)
    return [finding for finding in found if id(finding) not in hidden]


def _consequences(
    row: Row, causes: Iterable[Diagnostic], among: Iterable[Diagnostic], forms: _Forms
) -> Iterator[Diagnostic]:
    """Yield the findings of `among` that share a subject with a cause."""
    match row.same:
        case "library":
            yield from among
        case "form":
            of_causes = {forms.at(cause.span) for cause in causes}
            yield from [one for one in among if forms.at(one.span) in of_causes]
        case "name":
            names = {key for cause in causes for key in forms.names(cause)}
            yield from [one for one in among if not names.isdisjoint(forms.names(one))]
        case "place":
            places = [subject.place for cause in causes for subject in cause.about]
            yield from [
                one for one in among if any(p.contains(one.span) for p in places)
            ]
        case "missing":
            # How many variables of each form a cause has not yet explained.
            unexplained = Counter(form for one in causes for form in forms.missing(one))
            explained: set[tuple[Span | None, str]] = set()
            for one in among:
                for form in forms.missing(one):
                    ((_, name),) = forms.names(one)
                    if unexplained[form] > 0 and (form, name) not in explained:
                        unexplained[form] -= 1
                        explained.add((form, name))
                    if (form, name) in explained:
                        yield one


class _Forms:
    """The top-level forms of a library, by position."""

    def __init__(self, forms: Iterable[tuple[Span, Span]]) -> None:
        self._forms: dict[str, list[tuple[Span, Span]]] = {}
        for form, whole in forms:
            self._forms.setdefault(form.file, []).append((form, whole))
        for own in self._forms.values():
            own.sort(key=lambda one: one[0].start)

    def at(self, place: Span) -> Span | None:
        """Return the form at a place; for an added method its RAP."""
        own = self._forms.get(place.file, [])
        at = bisect_right(own, place.start, key=lambda one: one[0].start) - 1
        return own[at][1] if at >= 0 else None

    def names(self, finding: Diagnostic) -> set[tuple[Span | None, str]]:
        """Return the names that a finding is about, with the form of each name."""
        return {(self.at(s.place), s.name) for s in finding.about if s.name}

    def missing(self, finding: Diagnostic) -> list[Span | None]:
        """Return the form of each missing variable that a finding declares."""
        return [self.at(s.place) for s in finding.about if not s.name]
