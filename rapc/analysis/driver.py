"""Run the passes over what was loaded, and decide what becomes of their findings.

Orders the passes by what they need, leaves out findings about forms that could not be
read whole, applies suppressions and the user's selection, and sorts. Nothing of the
checked code is executed or imported, and nothing is printed here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from graphlib import CycleError, TopologicalSorter
from typing import Any

import msgspec

from rapc.analysis import suite, suppressions
from rapc.analysis.analyzer import Analyzer, Pass, never
from rapc.analysis.damage import Damage
from rapc.analysis.selection import Selection, by_default, errors
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.gc_paused import gc_paused
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.library.library import Library
from rapc.library.loader import Loaded
from rapc.library.requiring import UNRESOLVED
from rapc.library.signatures import Signatures


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
    rules = {n: chosen.graded(rule) for n, rule in suite.rules().items()}
    damage = Damage(loaded)
    found = [*loaded.diagnostics, *_analyze(loaded, damage, chosen.enabled)]
    found = _suppress(loaded, rules, found, chosen.enabled, damage)
    order = {name: at for at, name in enumerate(loaded.files)}
    findings = [Finding(rules[d.rule], d) for d in found if chosen.chooses(d)]
    findings.sort(key=lambda f: place_of(order, f))
    forms = loaded.library.forms
    raps = Counter(f.span.file for f in forms if isinstance(f, nodes.DefineRap))
    return CheckReport(tuple(findings), loaded.files, raps)


def check_tests(library: Library, tests: Iterable[DefineTest]) -> list[Finding]:
    """Return the errors in tests of a library that was checked before.

    The library may be a compiled one: a RAP is read only where a test names it.
    """
    alone = msgspec.structs.replace(library, forms=(), tests=tuple(tests))
    rules = suite.rules()
    wanted = needed_for(errors().enabled)
    every = _findings(alone, True, never, wanted, {})
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


def _analyze(
    loaded: Loaded, damage: Damage, enabled: Collection[str]
) -> Iterator[Diagnostic]:
    """Yield what the passes find, without what may be due to a slip of the pen.

    A pass none of whose rules is enabled runs only where others need it.
    """
    complete = all(d.rule != UNRESOLVED.name for d in loaded.diagnostics)
    wanted = needed_for(enabled)
    found = _findings(loaded.library, complete, damage.reaches, wanted, loaded.required)
    for analyzer, diagnostic in found:
        if not damage.silences(diagnostic, analyzer.needs_whole):
            yield diagnostic


def _findings(
    library: Library,
    complete: bool,
    unsure: Callable[[Span], bool],
    wanted: Iterable[Analyzer[Any]],
    required: Mapping[str, tuple[str, ...]],
) -> Iterator[tuple[Analyzer[Any], Diagnostic]]:
    """Yield what the passes `wanted` find in forms and tests, with the pass.

    What a file says of all its tests is part of each, and reported once.
    """
    results: dict[str, object] = {}
    seen: set[tuple[str, Span, str]] = set()
    signatures = Signatures.of(library)
    for analyzer in wanted:
        run = Pass(analyzer, library, signatures, results, complete, unsure, required)
        results[analyzer.name] = analyzer.run(run)
        for found in run.found:
            key = (found.rule, found.span, found.message)
            if key not in seen:
                seen.add(key)
                yield analyzer, found


def _suppress(
    loaded: Loaded,
    rules: Mapping[str, Rule],
    found: list[Diagnostic],
    enabled: Collection[str],
    damage: Damage,
) -> list[Diagnostic]:
    """Apply the suppressions in comments, and report those that are wrong or unused."""
    written: list[suppressions.Suppression] = []
    wrong: list[Diagnostic] = []
    for unit in loaded.units:
        ones, bad = suppressions.find(unit, rules)
        written += ones
        wrong += bad
    left, unused = suppressions.apply(found, written)
    for one in unused:
        if one.rule in enabled and not damage.lies_in(one.covers):
            wrong.append(suppressions.unused(one, loaded.files[one.comment.file]))
    return left + wrong


def place_of(order: Mapping[str, int], finding: Finding) -> tuple[int, int, int, str]:
    """Return what findings are sorted by: the `order` of their files, then the text."""
    span = finding.diagnostic.span
    return order.get(span.file, -1), span.start, span.end, finding.rule.code
