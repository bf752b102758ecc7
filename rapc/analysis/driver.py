"""Run the passes over what was loaded, and decide what becomes of their findings.

Orders the passes by what they need, leaves out findings about forms that could not be
read whole, applies suppressions and the user's selection, and sorts. Nothing of the
checked code is executed or imported, and nothing is printed here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import cache
from graphlib import CycleError, TopologicalSorter
from types import MappingProxyType
from typing import Any, cast

import msgspec

from rapc.analysis import suite, suppressions
from rapc.analysis.analyzer import Analyzer, Pass, T, never
from rapc.analysis.damage import Damage
from rapc.analysis.file_census import FormKey
from rapc.analysis.selection import Selection, by_default, errors
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.gc_paused import gc_paused
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.library.library import Library
from rapc.library.loader import Loaded
from rapc.library.requiring import UNRESOLVED
from rapc.library.signature import Signature
from rapc.library.signatures import Signatures
from rapc.parser.unit import SourceUnit


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
    return examined(loaded, selection or Selection(by_default())).report


class Examined(msgspec.Struct, frozen=True):
    """A library that was checked, with all that was found out on the way."""

    report: CheckReport
    loaded: Loaded
    #: What the passes found, no matter who may report; suppressed findings, too.
    analysis: Analysis
    written: Written


@gc_paused()
def examined(loaded: Loaded, chosen: Selection) -> Examined:
    """Check a loaded library; see `check_library`."""
    damage = Damage(loaded)
    complete = all(d.rule != UNRESOLVED.name for d in loaded.diagnostics)
    wanted = needed_for(chosen.enabled)
    analysis = analyzed(
        loaded.library, wanted, complete, damage.reaches, loaded.required
    )
    sure = [
        diagnostic
        for analyzer, diagnostic in analysis.found
        if not damage.silences(diagnostic, analyzer.needs_whole)
    ]
    written = Written.of(loaded.units)
    found = [*loaded.diagnostics, *sure]
    left = written.applied(found, loaded.files, chosen, damage.lies_in)
    forms = loaded.library.forms
    raps = Counter(f.span.file for f in forms if isinstance(f, nodes.DefineRap))
    report = reported(left, loaded.files, raps, chosen)
    return Examined(report, loaded, analysis, written)


def reported(
    found: Iterable[Diagnostic],
    files: Mapping[str, SourceFile],
    raps: Mapping[str, int],
    chosen: Selection,
) -> CheckReport:
    """Return the report on what was found, as far as it is chosen, in order.

    Args:
        found: what suppressions have left.
        files: the files, first read first.
        raps: how many RAPs stand in each file that has some.
        chosen: the rules that may report.
    """
    rules = {name: chosen.graded(rule) for name, rule in suite.rules().items()}
    order = {name: at for at, name in enumerate(files)}
    findings = [Finding(rules[d.rule], d) for d in found if chosen.chooses(d)]
    findings.sort(key=lambda finding: order_of(order, finding))
    return CheckReport(tuple(findings), files, raps)


def check_tests(library: Library, tests: Iterable[DefineTest]) -> list[Finding]:
    """Return the errors in tests of a library that was checked before.

    The library may be a compiled one: a RAP is read only where a test names it.
    """
    alone = msgspec.structs.replace(library, forms=(), tests=tuple(tests))
    rules = suite.rules()
    wanted = needed_for(errors().enabled)
    every = analyzed(alone, wanted, True, never, {}).found
    found = [Finding(rules[d.rule], d) for _, d in every]
    return [finding for finding in found if finding.severity is Severity.ERROR]


@cache
def passes() -> tuple[Analyzer[Any], ...]:
    """The passes of the suite in the order in which they run."""
    return ordered(suite.ANALYZERS)


def needed_for(enabled: Collection[str]) -> list[Analyzer[Any]]:
    """Return the passes that the enabled rules need, in the order in which they run."""
    chosen: list[Analyzer[Any]] = []
    needed: set[str] = set()
    for analyzer in reversed(passes()):
        if analyzer.name in needed or any(r.name in enabled for r in analyzer.rules):
            chosen.append(analyzer)
            needed.update(need.name for need in analyzer.needs)
    return chosen[::-1]


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


class Analysis(msgspec.Struct, frozen=True):
    """What the passes came to."""

    #: Each finding with the pass that made it; what a file says of all its tests is
    #: part of each, and reported once.
    found: Sequence[tuple[Analyzer[Any], Diagnostic]]
    #: What each pass returned, by its name.
    results: Mapping[str, object]
    #: The forms that are to be checked each time, by file and beginning.
    watched: frozenset[FormKey]
    #: The files of which all forms are to be checked if one is.
    watched_files: frozenset[str]

    def result(self, analyzer: Analyzer[T]) -> T:
        """Return what a pass that ran has returned."""
        return cast(T, self.results[analyzer.name])


def analyzed(
    library: Library,
    wanted: Iterable[Analyzer[Any]],
    complete: bool,
    unsure: Callable[[Span], bool],
    required: Mapping[str, tuple[str, ...]],
    known: Mapping[str, object] = MappingProxyType({}),
    raps: Mapping[str, Signature] | None = None,
) -> Analysis:
    """Run passes over the forms and tests of a library.

    Args:
        library: what they look at.
        wanted: the passes in the order in which they run.
        complete: whether every file that the library requires was found.
        unsure: whether a slip of the pen may have to do with what is at a place.
        required: the files that files require themselves, by their names.
        known: the results of passes that need not run, by their names.
        raps: the signatures of all RAPs, where the library is a part of another.
    """
    results: dict[str, object] = dict(known)
    found: list[tuple[Analyzer[Any], Diagnostic]] = []
    seen: set[tuple[str, Span, str]] = set()
    watched: set[FormKey] = set()
    watched_files: set[str] = set()
    signatures = Signatures.of(library, raps)
    for analyzer in wanted:
        if analyzer.name in results:
            continue
        run = Pass(analyzer, library, signatures, results, complete, unsure, required)
        results[analyzer.name] = analyzer.run(run)
        watched |= run.watched
        watched_files |= run.watched_files
        for one in run.found:
            key = (one.rule, one.span, one.message)
            if key not in seen:
                seen.add(key)
                found.append((analyzer, one))
    return Analysis(found, results, frozenset(watched), frozenset(watched_files))


class Written(msgspec.Struct, frozen=True):
    """The suppressions in the comments of some files, and what is wrong with them."""

    right: Mapping[str, Sequence[suppressions.Suppression]]
    wrong: Mapping[str, Sequence[Diagnostic]]

    @classmethod
    def of(cls, units: Iterable[SourceUnit]) -> Written:
        """Return what is written in some files."""
        rules = suite.rules()
        found = {
            unit.file.name: suppressions.find_suppressions(unit, rules)
            for unit in units
        }
        return cls(
            {name: right for name, (right, _) in found.items() if right},
            {name: wrong for name, (_, wrong) in found.items() if wrong},
        )

    def applied(
        self,
        found: Iterable[Diagnostic],
        files: Mapping[str, SourceFile],
        chosen: Selection,
        damaged: Callable[[Span], bool],
    ) -> list[Diagnostic]:
        """Return the findings left, with those about suppressions wrong or unused.

        Args:
            found: all findings in the files.
            files: the files.
            chosen: the rules that may report.
            damaged: whether a form that could not be read whole lies in a stretch.
        """
        every = [one for name in files for one in self.right.get(name, ())]
        left, unused = suppressions.apply(found, every)
        left += [one for name in files for one in self.wrong.get(name, ())]
        for one in unused:
            if one.rule in chosen.enabled and not damaged(one.covers):
                left.append(suppressions.unused(one, files[one.comment.file]))
        return left


def order_of(order: Mapping[str, int], finding: Finding) -> tuple[int, int, int, str]:
    """Return what findings are sorted by: the `order` of their files, then the text."""
    span = finding.diagnostic.span
    return order.get(span.file, -1), span.start, span.end, finding.rule.code
