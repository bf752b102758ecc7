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
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, cast

import msgspec

from rapc.analysis import grave, suppressions
from rapc.analysis.analyzer import Analyzer, Pass, T, never
from rapc.analysis.damage import Damage
from rapc.analysis.file_census import FormKey
from rapc.analysis.selection import Selection, by_default
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.gc_paused import gc_paused
from rapc.base.later import later
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.library.library import Library
from rapc.library.loader import Loaded
from rapc.library.requiring import UNRESOLVED
from rapc.library.signature import Signature
from rapc.library.signatures import Signatures
from rapc.parser.unit import SourceUnit

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
    damage = Damage(loaded.units)
    complete = all(d.rule != UNRESOLVED.name for d in loaded.diagnostics)
    analysis = Analysis(loaded.library, complete, damage.reaches, loaded.required)
    analysis.run(reporting(chosen.enabled))
    sure = [
        diagnostic
        for analyzer, diagnostic in analysis.found
        if not damage.silences(diagnostic, analyzer.needs_whole)
    ]
    written = Written.of(loaded.units, _rules(chosen.enabled))
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
    rules = _rules(chosen.enabled)
    order = {name: at for at, name in enumerate(files)}
    findings = [
        Finding(chosen.graded(rules[d.rule]), d) for d in found if chosen.chooses(d)
    ]
    findings.sort(key=lambda finding: order_of(order, finding))
    return CheckReport(tuple(findings), files, raps)


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
        known: the results of passes that need not run, by their names.
        raps: the signatures of all RAPs, where the library is a part of another.
    """

    def __init__(
        self,
        library: Library,
        complete: bool,
        unsure: Callable[[Span], bool],
        required: Mapping[str, tuple[str, ...]],
        known: Mapping[str, object] = MappingProxyType({}),
        raps: Mapping[str, Signature] | None = None,
    ) -> None:
        #: Each finding with the pass that made it; what a file says of all its tests
        #: is part of each, and reported once.
        self.found: list[tuple[Analyzer[Any], Diagnostic]] = []
        #: The forms that are to be checked each time, by file and beginning.
        self.watched: set[FormKey] = set()
        #: The files of which all forms are to be checked if one is.
        self.watched_files: set[str] = set()
        self._library = library
        self._complete = complete
        self._unsure = unsure
        self._required = required
        self._signatures = Signatures.of(library, raps)
        self._results = dict(known)
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
        self.watched |= run.watched
        self.watched_files |= run.watched_files
        for one in run.found:
            key = (one.rule, one.span, one.message)
            if key not in self._seen:
                self._seen.add(key)
                self.found.append((analyzer, one))
        return result


class Written(msgspec.Struct, frozen=True):
    """The suppressions in the comments of some files, and what is wrong with them."""

    right: Mapping[str, Sequence[suppressions.Suppression]]
    wrong: Mapping[str, Sequence[Diagnostic]]

    @classmethod
    def of(cls, units: Iterable[SourceUnit], rules: Mapping[str, Rule]) -> Written:
        """Return what is written in some files; `rules` are those that are known."""
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
