"""Checks, facts, and the pass that holds the input of all checks.

A check is a generator that yields findings of its rules:

    @check(UNKNOWN, needs_whole="form")
    def unknown_rap(run: Pass) -> Iterator[Diagnostic]:
        \"\"\"Find steps that name no RAP.\"\"\"
        for use in run.result(INDEX).uses():
            ...
            yield UNKNOWN.at(use.span, f"unknown RAP `{use.name}`")

A fact is a value about the library that several checks need. A check requests facts,
never other checks. `rapc.analysis.registry` lists the checks; `rapc.analysis.driver`
runs the checks and filters the findings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, Generic, Literal, TypeVar, cast

import msgspec

from rapc.analysis.rap_cache import RapCache, Values
from rapc.base.diagnostics import Diagnostic, Rule
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.library.signatures import Signatures

T = TypeVar("T")

Whole = Literal["node", "method", "form"]
"""The part of a form that must have been read for a finding to be certain."""


class Fact(msgspec.Struct, Generic[T], frozen=True, eq=False):
    """A value about a library, computed when the first check requests the value."""

    compute: Callable[[Pass], T]


class RapFact(msgspec.Struct, Generic[T], frozen=True, eq=False):
    """A value about a RAP, computed when the first check requests the value.

    The value depends only on the RAP, on the RAPs that its steps reach, and on the
    declarations, rules and queries of the library. See `rapc.analysis.rap_cache`.
    """

    compute: Callable[[Pass, nodes.DefineRap], T]


class Check(msgspec.Struct, frozen=True, eq=False):
    """A generator of findings."""

    name: str
    #: The rules of the findings.
    rules: tuple[Rule, ...]
    find: Callable[[Pass], Iterable[Diagnostic]]
    #: The part that must have been read without a syntax error for a finding to be
    #: certain: the node of the finding, its method, or the whole form.
    needs_whole: Whole


def check(
    *rules: Rule, needs_whole: Whole = "node"
) -> Callable[[Callable[[Pass], Iterable[Diagnostic]]], Check]:
    """Return a decorator that turns a generator of findings into a check."""

    def made(find: Callable[[Pass], Iterable[Diagnostic]]) -> Check:
        return Check(find.__name__, rules, find, needs_whole)

    return made


def never(place: Span) -> bool:
    """Return False: no form is damaged."""
    return False


class Pass:
    """A pass over a library: the input of checks and the computed facts.

    Args:
        library: the library.
        complete: whether every file that the library requires was found.
        unsure: whether a syntax error may affect the text at a place.
        required: by file name, the files that the file itself requires.
        cache: values about RAPs from earlier checks of the library.
    """

    def __init__(
        self,
        library: Library,
        complete: bool = True,
        unsure: Callable[[Span], bool] = never,
        required: Mapping[str, tuple[str, ...]] = MappingProxyType({}),
        cache: RapCache | None = None,
    ) -> None:
        self.library = library
        self.signatures = Signatures.of(library)
        self.complete = complete
        self.unsure = unsure
        self.required = required
        self._facts: dict[Fact[Any], object] = {}
        #: The values about RAPs, by the `id` of the RAP.
        self._of_raps: dict[int, Values] = {}
        if cache is not None:
            self._of_raps = cache.values(library, complete, unsure)

    def result(self, fact: Fact[T]) -> T:
        """Return the value of a fact; the value is computed once."""
        if fact not in self._facts:
            self._facts[fact] = fact.compute(self)
        return cast(T, self._facts[fact])

    def of(self, fact: RapFact[T], rap: nodes.DefineRap) -> T:
        """Return the value of a fact about a RAP; the value is computed once."""
        values = self._of_raps.setdefault(id(rap), {})
        if fact not in values:
            values[fact] = fact.compute(self, rap)
        return cast(T, values[fact])

    def keep(self, *facts: Fact[Any]) -> None:
        """Forget the values of all other facts, and those about RAPs."""
        for one in self._facts.keys() - facts:
            del self._facts[one]  # one by one: another thread may run after each
        self._of_raps = {}

    def known(self, fact: Fact[T]) -> T | None:
        """Return the value of a fact if it was computed."""
        return cast(T | None, self._facts.get(fact))
