"""Run the passes over what was loaded, and decide what becomes of their findings.

Runs those that own a rule that the user wants, and those whose results are asked for;
leaves out findings about forms that could not be read whole, applies suppressions and
the user's selection, and sorts. Nothing of the checked code is executed or imported,
and nothing is printed here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cache
from graphlib import CycleError, TopologicalSorter
from typing import TYPE_CHECKING, Any, cast

import msgspec

from rapc.analysis import grave, suppressions
from rapc.analysis.analyzer import Analyzer, Pass, T, never
from rapc.analysis.damage import Damage
from rapc.analysis.selection import Selection, by_default
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.gc_paused import gc_paused
from rapc.base.later import later
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.library.library import Library
from rapc.library.loader import UNRESOLVED, Loaded
from rapc.library.signatures import Signatures

if TYPE_CHECKING:
    from rapc.analysis import suite
else:
    suite = later("rapc.analysis.suite")


class Finding(msgspec.Struct, frozen=True):
    """A diagnostic with the rule that it breaks."""

    rule: Rule
    diagnostic: Diagnostic

    @property
    def severity(self) -> Severity:
        """Return how grave it is."""
        return self.rule.severity


class CheckReport(msgspec.Struct, frozen=True):
    """What checking came to: the findings in the order of files and text."""

    findings: tuple[Finding, ...]
    #: Every file that was read, by the name that spans carry.
    files: Mapping[str, SourceFile]
    #: How many RAPs stand in each file that has some.
    raps_in: Mapping[str, int] = {}

    @property
    def raps(self) -> int:
        """Return how many RAPs were checked."""
        return sum(self.raps_in.values())

    def worst(self) -> Severity | None:
        """The gravest severity found, or None."""
        return max((finding.severity for finding in self.findings), default=None)


@gc_paused()
def check_library(loaded: Loaded, selection: Selection | None = None) -> CheckReport:
    """Check a loaded library; its own diagnostics are part of the report.

    Args:
        loaded: what `rapc.library.loader` made of the files.
        selection: the rules that may report; those that are not opt-in if None.
    """
    chosen = selection or Selection(by_default())
    damage = Damage(loaded.units)
    complete = all(d.rule != UNRESOLVED.name for d in loaded.diagnostics)
    analysis = Analysis(loaded.library, complete, damage.reaches, loaded.required)
    analysis.run(reporting(chosen.enabled))
    sure = [
        diagnostic
        for analyzer, diagnostic in analysis.found
        if not damage.silences(diagnostic, analyzer.needs_whole)
    ]
    rules = _rules(chosen.enabled)
    found = _unsuppressed(loaded, [*loaded.diagnostics, *sure], rules, chosen, damage)
    findings = [
        Finding(chosen.graded(rules[d.rule]), d) for d in found if chosen.chooses(d)
    ]
    order = {name: at for at, name in enumerate(loaded.files)}
    findings.sort(key=lambda finding: order_of(order, finding))
    forms = loaded.library.forms
    raps = Counter(f.span.file for f in forms if isinstance(f, nodes.DefineRap))
    return CheckReport(tuple(findings), loaded.files, raps)


def _unsuppressed(
    loaded: Loaded,
    found: Iterable[Diagnostic],
    rules: Mapping[str, Rule],
    chosen: Selection,
    damage: Damage,
) -> list[Diagnostic]:
    """Return the findings left, with those about suppressions wrong or unused.

    A suppression is not unused if a form lies in it that could not be read whole.
    """
    units = {unit.file.name: unit for unit in loaded.units}
    written = [
        suppressions.find_suppressions(units[name], rules)
        for name in loaded.files
        if name in units
    ]
    every = [one for right, _ in written for one in right]
    left, unused = suppressions.apply(found, every)
    left += [one for _, wrong in written for one in wrong]
    for one in unused:
        if one.rule in chosen.enabled and not damage.lies_in(one.covers):
            left.append(suppressions.unused(one, loaded.files[one.comment.file]))
    return left


def check_tests(library: Library, tests: Iterable[DefineTest]) -> list[Finding]:
    """Return the errors in tests of a library that was checked before.

    The library may be a compiled one: a RAP is read only where a test names it.
    """
    alone = msgspec.structs.replace(library, forms=(), tests=tuple(tests))
    analysis = Analysis(alone, True, never, {}).run(reporting(grave.errors()))
    found = [Finding(grave.rules()[d.rule], d) for _, d in analysis.found]
    return [finding for finding in found if finding.severity is Severity.ERROR]


@cache
def passes() -> tuple[Analyzer[Any], ...]:
    """The passes of the suite, each behind those that it needs."""
    return ordered(suite.ANALYZERS)


@cache
def _passes_for_errors() -> tuple[Analyzer[Any], ...]:
    return ordered(grave.ANALYZERS)


def _rules(enabled: Collection[str]) -> Mapping[str, Rule]:
    """Return all rules, or fewer where none but errors may report."""
    return grave.rules() if grave.errors().issuperset(enabled) else suite.rules()


def reporting(enabled: Collection[str]) -> list[Analyzer[Any]]:
    """Return the passes that report by one of the enabled rules, in their order."""
    among = _passes_for_errors() if grave.errors().issuperset(enabled) else passes()
    return [one for one in among if any(r.name in enabled for r in one.rules)]


def ordered(analyzers: Sequence[Analyzer[Any]]) -> tuple[Analyzer[Any], ...]:
    """The analyzers in an order in which each follows what it needs.

    Raises:
        ValueError: if one is not documented, needs what is not listed, shares a name
            or a rule with another, or needs itself through others. That is a bug.
    """
    by_name = {analyzer.name: analyzer for analyzer in analyzers}
    if len(by_name) != len(analyzers):
        raise ValueError("two passes have one name")
    graph: TopologicalSorter[str] = TopologicalSorter()
    codes: set[str] = set()
    for analyzer in analyzers:
        _must_be_documented(analyzer, codes)
        graph.add(analyzer.name, *(need.name for need in analyzer.needs))
        for need in analyzer.needs:
            if by_name.get(need.name) is not need:
                message = (
                    f"pass `{analyzer.name}` needs `{need.name}`, not in the suite"
                )
                raise ValueError(message)
    try:
        graph.prepare()
    except CycleError as error:
        circle = " -> ".join(error.args[1])
        raise ValueError(f"passes need each other in a circle: {circle}") from None
    order: list[str] = []
    while ready := sorted(graph.get_ready()):
        order += ready
        graph.done(*ready)
    return tuple(by_name[name] for name in order)


def _must_be_documented(analyzer: Analyzer[Any], codes: set[str]) -> None:
    if not analyzer.name or not analyzer.doc:
        raise ValueError(f"pass `{analyzer.name}` is not documented")
    for rule in analyzer.rules:
        if not (rule.summary and rule.why and rule.example and rule.better):
            raise ValueError(f"rule `{rule.name}` is not documented")
        if rule.code in codes or rule.name in codes:
            raise ValueError(f"rule `{rule.name}` ({rule.code}) exists already")
        codes.update((rule.code, rule.name))


class Analysis:
    """What the passes come to; one runs when its result is asked for first.

    Args:
        library: what they look at.
        complete: whether every file that the library requires was found.
        unsure: whether a slip of the pen may have to do with what is at a place.
        required: the files that files require themselves, by their names.
    """

    def __init__(
        self,
        library: Library,
        complete: bool,
        unsure: Callable[[Span], bool],
        required: Mapping[str, tuple[str, ...]],
    ) -> None:
        #: Each finding with the pass that made it; what a file says of all its tests
        #: is part of each, and reported once.
        self.found: list[tuple[Analyzer[Any], Diagnostic]] = []
        self._library = library
        self._complete = complete
        self._unsure = unsure
        self._required = required
        self._signatures = Signatures.of(library)
        self._results: dict[str, object] = {}
        self._seen: set[tuple[str, Span, str]] = set()

    def run(self, wanted: Iterable[Analyzer[Any]]) -> Analysis:
        """Run passes, and those whose results they ask for; return all they come to."""
        for analyzer in wanted:
            self.result(analyzer)
        return self

    def result(self, analyzer: Analyzer[T]) -> T:
        """Return what a pass returns, which runs now if it has not run yet."""
        if not self.has_run(analyzer):
            self._results[analyzer.name] = self._run(analyzer)
        return cast(T, self._results[analyzer.name])

    def has_run(self, analyzer: Analyzer[Any]) -> bool:
        """Whether a pass has run."""
        return analyzer.name in self._results

    def _run(self, analyzer: Analyzer[T]) -> T:
        run = Pass(
            analyzer,
            self._library,
            self._signatures,
            self.result,
            self._complete,
            self._unsure,
            self._required,
        )
        result = analyzer.run(run)
        for one in run.found:
            key = (one.rule, one.span, one.message)
            if key not in self._seen:
                self._seen.add(key)
                self.found.append((analyzer, one))
        return result


def order_of(order: Mapping[str, int], finding: Finding) -> tuple[int, int, int, str]:
    """Return what findings are sorted by: the `order` of their files, then the text."""
    span = finding.diagnostic.span
    return order.get(span.file, -1), span.start, span.end, finding.rule.code
