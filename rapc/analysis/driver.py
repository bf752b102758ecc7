"""Run the checks on a loaded library and filter the findings.

The driver runs each check that owns a selected rule. Then the driver leaves out
findings about forms with syntax errors, applies suppressions and the user's selection,
and sorts. The driver neither executes nor imports checked code, and prints no output.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping

import msgspec

from rapc.analysis import registry, suppressions
from rapc.analysis.check import Pass, Whole
from rapc.analysis.damage import Damage
from rapc.analysis.hiding import visible
from rapc.analysis.selection import Selection, by_default
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.gc_paused import gc_paused
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.library.library import Library
from rapc.library.loader import UNRESOLVED, Loaded


class Finding(msgspec.Struct, frozen=True):
    """A diagnostic with its rule."""

    rule: Rule
    diagnostic: Diagnostic

    @property
    def severity(self) -> Severity:
        """Return the severity of the finding."""
        return self.rule.severity


class CheckReport(msgspec.Struct, frozen=True):
    """The result of a check: the findings in the order of files and text."""

    findings: tuple[Finding, ...]
    #: Every file that was read, by the file name in spans.
    files: Mapping[str, SourceFile]
    #: The number of RAPs in each file that has RAPs.
    raps_in: Mapping[str, int] = {}

    @property
    def raps(self) -> int:
        """Return the number of checked RAPs."""
        return sum(self.raps_in.values())

    def worst(self) -> Severity | None:
        """Return the highest severity of the findings, or None."""
        return max((finding.severity for finding in self.findings), default=None)


@gc_paused()
def check_library(loaded: Loaded, selection: Selection | None = None) -> CheckReport:
    """Check a loaded library; the report includes the diagnostics of loading.

    Args:
        loaded: the result of `rapc.library.loader`.
        selection: the rules that may report; None for all rules that are not opt-in.
    """
    chosen = selection or Selection(by_default())
    damage = Damage(loaded.units)
    complete = all(d.rule != UNRESOLVED.name for d in loaded.diagnostics)
    run = Pass(loaded.library, complete, damage.reaches, loaded.required)
    sure = [
        diagnostic
        for diagnostic, whole in _found(run, chosen.enabled)
        if not damage.silences(diagnostic, whole)
    ]
    rules = registry.rules(errors_only=registry.are_errors(chosen.enabled))
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
    """Return the findings left, and findings about invalid or unused suppressions.

    A suppression that covers a form with a syntax error does not count as unused.
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
    """Return the errors in tests of a library that has been checked.

    If the library is compiled, a RAP is read only if a test names the RAP.
    """
    run = Pass(msgspec.structs.replace(library, forms=(), tests=tuple(tests)))
    rules = registry.rules(errors_only=True)
    every = [Finding(rules[one.rule], one) for one, _ in _found(run, registry.errors())]
    return [finding for finding in every if finding.severity is Severity.ERROR]


def _found(run: Pass, enabled: Collection[str]) -> Iterator[tuple[Diagnostic, Whole]]:
    """Yield the findings that no finding hides, and the need of each finding.

    The findings about declarations shared by all tests of a file are yielded once.
    """
    found: dict[tuple[str, Span, str], Diagnostic] = {}
    whole: dict[str, Whole] = {}
    for check in registry.checks_for(enabled):
        whole.update((rule.name, check.needs_whole) for rule in check.rules)
        for one in check.find(run):
            found.setdefault((one.rule, one.span, one.message), one)
    forms = (*run.library.forms, *run.library.tests)
    for one in visible(list(found.values()), [form.span for form in forms]):
        yield one, whole[one.rule]


def order_of(order: Mapping[str, int], finding: Finding) -> tuple[int, int, int, str]:
    """Return the sort key of a finding: the `order` of its file, then the position."""
    span = finding.diagnostic.span
    return order.get(span.file, -1), span.start, span.end, finding.rule.code
