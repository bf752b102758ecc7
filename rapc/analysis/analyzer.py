"""What a pass is: one record with a name, a page of its own, its needs and its rules.

A pass looks at a linked library and reports what it finds; it may also hand a value to
the passes that need it. Which passes there are is listed in `rapc.analysis.suite`, when
each one runs and what becomes of its findings is decided in `rapc.analysis.driver`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Generic, Literal, Protocol, TypeVar

import msgspec

from rapc.base.diagnostics import Diagnostic, Rule
from rapc.base.source import Span
from rapc.library.library import Library
from rapc.library.signatures import Signatures

T = TypeVar("T")


Whole = Literal["node", "method", "form"]
"""How much around a finding must have been read for it to be sure."""


class Analyzer(msgspec.Struct, Generic[T], frozen=True, eq=False):
    """One pass.

    Args:
        name: named for the fault it finds, or for what it works out for others.
        doc: what it does, one sentence or more.
        run: the pass itself; what it returns is handed to those that need it.
        needs: passes whose results it may ask for.
        rules: the rules it may report, no others.
        needs_whole: what must have been read without a slip for a finding to be sure:
            the node it is about, its method, or all of the form.
    """

    name: str
    doc: str
    run: Callable[[Pass], T]
    needs: tuple[Analyzer[Any], ...] = ()
    rules: tuple[Rule, ...] = ()
    needs_whole: Whole = "node"


def never(place: Span) -> bool:
    """Say of no place that a slip has to do with it."""
    return False


class PassResults(Protocol):
    """What tells the result of an analyzer, which runs then if it has not run yet."""

    def __call__(self, analyzer: Analyzer[T], /) -> T:
        """Return what the analyzer returns."""


class Pass:
    """One run of one analyzer: what it looks at, and where its findings go.

    Args:
        analyzer: the analyzer that runs.
        library: what it looks at.
        signatures: what is declared in it.
        ask: tells what other analyzers return.
        complete: whether every file that the library requires was found.
        unsure: whether a slip of the pen may have to do with what is at a place.
        required: the files that files require themselves, by their names.
    """

    def __init__(
        self,
        analyzer: Analyzer[Any],
        library: Library,
        signatures: Signatures,
        ask: PassResults,
        complete: bool,
        unsure: Callable[[Span], bool] = never,
        required: Mapping[str, tuple[str, ...]] = MappingProxyType({}),
    ) -> None:
        self.library = library
        self.required = required
        self.signatures = signatures
        self.complete = complete
        self.unsure = unsure
        self.found: list[Diagnostic] = []
        self._analyzer = analyzer
        self._ask = ask
        self._rules = frozenset(rule.name for rule in analyzer.rules)

    def report(self, diagnostic: Diagnostic) -> None:
        """Add a finding.

        Raises:
            ValueError: if the analyzer does not own the rule; that is a bug.
        """
        if diagnostic.rule not in self._rules:
            raise ValueError(
                f"pass `{self._analyzer.name}` does not own rule `{diagnostic.rule}`"
            )
        self.found.append(diagnostic)

    def result(self, analyzer: Analyzer[T]) -> T:
        """Return what a needed analyzer returns; it runs when it is asked first.

        Raises:
            ValueError: if this one does not say that it needs it; that is a bug.
        """
        if analyzer not in self._analyzer.needs:
            raise ValueError(
                f"pass `{self._analyzer.name}` does not need `{analyzer.name}`"
            )
        return self._ask(analyzer)
