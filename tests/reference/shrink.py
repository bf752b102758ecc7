"""Make a case that disagrees smaller while it still does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import msgspec

from tests.reference.case import Case

Judge = Callable[[Case], str]

_FIELDS = ("tasks", "host", "solvers", "at", "rows", "facts", "forms")

_KEPT = ("declare", "define-query")
"""How the heads of forms begin that are left as they are."""

_OPEN = (
    *("define-rap", "define-method", "method", "task-net"),
    *("and", "or", "resources", "notations"),
)
"""The heads of lists from which parts may be left out."""


def shrink(case: Case, judge: Judge) -> Case:
    """Leave out whatever can be left out without another verdict."""
    verdict = judge(case)
    before = None
    while case != before:
        before = case
        for field in _FIELDS:
            case = _shrink_field(case, field, verdict, judge)
    return case


def _shrink_field(case: Case, field: str, verdict: str, judge: Judge) -> Case:
    skip = 0
    while True:
        for number, smaller in enumerate(_fewer(getattr(case, field))):
            other = msgspec.structs.replace(case, **{field: smaller})
            if number >= skip and judge(other) == verdict:
                case, skip = other, number
                break
        else:
            return case


def _fewer(parts: tuple[Any, ...]) -> Iterator[tuple[Any, ...]]:
    """A sequence with one element less, or with one element smaller."""
    for index, part in enumerate(parts):
        if not (isinstance(part, tuple) and str(part[0]).startswith(_KEPT)):
            yield (*parts[:index], *parts[index + 1 :])
    for index, part in enumerate(parts):
        for less in _smaller(part):
            yield (*parts[:index], less, *parts[index + 1 :])


def _smaller(value: Any) -> Iterator[Any]:
    """A list with one part less, or with a formula in place of one that holds it."""
    if isinstance(value, msgspec.Struct):
        for name in ("asserts", "erases", "signals", "data"):
            for less in _fewer(getattr(value, name, ())):
                yield msgspec.structs.replace(value, **{name: less})
    if not isinstance(value, tuple) or str(value[0]).startswith(_KEPT):
        return
    if value[0] in ("and", "or", "not"):
        yield from value[1:]
    opened = value[0] in _OPEN or _is_step(value)
    for index, part in enumerate(value):
        if not isinstance(part, tuple):
            continue
        if opened and part[0] != "index":
            yield (*value[:index], *value[index + 1 :])
        for less in _smaller(part):
            yield (*value[:index], less, *value[index + 1 :])


def _is_step(value: tuple[Any, ...]) -> bool:
    head = value[0]
    return isinstance(head, str) and head[0] == "t" and head[1:].isdigit()
