"""What a check is, and what the checks of a library work on.

A check is a generator that yields findings by the rules that it owns:

    @check(UNKNOWN, needs_whole="form")
    def unknown_rap(run: Pass) -> Iterator[Diagnostic]:
        \"\"\"Find steps that name no RAP.\"\"\"
        for use in run.result(INDEX).uses():
            ...
            yield UNKNOWN.at(use.span, f"no RAP is called `{use.name}`")

A fact is a value about the library that several checks need. Checks ask for facts, not
for each other. `rapc.analysis.registry` lists the checks; `rapc.analysis.driver` runs
them and filters their findings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, Generic, Literal, TypeVar, cast

import msgspec

from rapc.base.diagnostics import Diagnostic, Rule
from rapc.base.source import Span
from rapc.library.library import Library
from rapc.library.signatures import Signatures

T = TypeVar("T")

Whole = Literal["node", "method", "form"]
"""How much around a finding must have been read for it to be sure."""


class Fact(msgspec.Struct, Generic[T], frozen=True, eq=False):
    """A value about a library, computed when a check asks for it first."""

    compute: Callable[[Pass], T]


class Check(msgspec.Struct, frozen=True, eq=False):
    """A generator of findings."""

    name: str
    #: The rules that the findings break.
    rules: tuple[Rule, ...]
    find: Callable[[Pass], Iterable[Diagnostic]]
    #: What must have been read without a slip for a finding to be sure: the node that
    #: it is about, its method, or all of the form.
    needs_whole: Whole


def check(
    *rules: Rule, needs_whole: Whole = "node"
) -> Callable[[Callable[[Pass], Iterable[Diagnostic]]], Check]:
    """Return a decorator that makes a generator of findings a check."""

    def made(find: Callable[[Pass], Iterable[Diagnostic]]) -> Check:
        return Check(find.__name__, rules, find, needs_whole)

    return made


def never(place: Span) -> bool:
    """Return False: no form is damaged."""
    return False


class Pass:
    """One pass over a library: what its checks look at, and the facts computed so far.

    Args:
        library: the library.
        complete: whether every file that the library requires was found.
        unsure: whether a slip of the pen may have to do with what is at a place.
        required: the files that files require themselves, by their names.
    """

    def __init__(
        self,
        library: Library,
        complete: bool = True,
        unsure: Callable[[Span], bool] = never,
        required: Mapping[str, tuple[str, ...]] = MappingProxyType({}),
    ) -> None:
        self.library = library
        self.signatures = Signatures.of(library)
        self.complete = complete
        self.unsure = unsure
        self.required = required
        self._facts: dict[Fact[Any], object] = {}

    def result(self, fact: Fact[T]) -> T:
        """Return the value of a fact, which is computed once."""
        if fact not in self._facts:
            self._facts[fact] = fact.compute(self)
        return cast(T, self._facts[fact])
