"""Run the checks on loaded libraries and filter the findings.

The driver runs each check that owns a selected rule. A finding is left out for the
first of these reasons that applies:

1. An equal finding is already reported.
2. Another finding hides the finding (`rapc.analysis.hiding`).
3. A syntax error may cause the finding (`rapc.analysis.damage`).
4. A comment suppresses the finding (`rapc.analysis.suppressions`).
5. The user has not selected the rule for the file (`rapc.analysis.selection`).
6. Another of the libraries decides about the file.

The driver neither executes nor imports checked code, and prints no output.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence

import msgspec

from rapc.analysis import registry, suppressions
from rapc.analysis.check import Check, Pass, Whole
from rapc.analysis.damage import Damage
from rapc.analysis.hiding import visible, with_hiders
from rapc.analysis.rap_cache import RapCache
from rapc.analysis.selection import Selection, by_default
from rapc.base.diagnostics import Diagnostic, Rule, Severity
from rapc.base.files import lies_in
from rapc.base.gc_paused import gc_paused
from rapc.base.source import SourceFile, Span
from rapc.ir import nodes
from rapc.ir.nodes import DefineTest
from rapc.library.library import Library
from rapc.library.loader import STANDARD_INPUT, UNRESOLVED, Loaded
from rapc.parser.unit import SourceUnit


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


def check_library(loaded: Loaded, selection: Selection | None = None) -> CheckReport:
    """Check a loaded library; the report includes the diagnostics of loading.

    Args:
        loaded: the result of `rapc.library.loader`.
        selection: the rules that may report; None for all rules that are not opt-in.
    """
    return check_libraries([loaded], selection)


def check_libraries(
    libraries: Iterable[Loaded],
    selection: Selection | None = None,
    paths: Sequence[str] | None = None,
    before_check: Callable[[Pass], None] | None = None,
    cache: RapCache | None = None,
) -> CheckReport:
    """Check libraries that share files; each finding is reported once.

    Args:
        libraries: the libraries; the first decides about its files. From another
            library, only errors in these files are reported.
        selection: the rules that may report; None for all rules that are not opt-in.
        paths: the files and folders whose unused suppressions are reported; None for
            all files. A suppression in a required file may silence a finding that
            depends on files outside the paths.
        before_check: called before each check with the facts about the library; it
            may raise an exception to end the work.
        cache: values about RAPs from earlier checks of the first library.
    """
    chosen = selection or Selection(by_default())
    checked: list[tuple[Loaded, list[Finding]]] = []
    for one in libraries:
        own = None if checked else cache
        checked.append((one, _findings(one, chosen, before_check, own)))
    files = {name: file for one, _ in checked for name, file in one.files.items()}
    raps: dict[str, int] = {}
    for one, _ in checked:
        forms = one.library.forms
        raps |= Counter(f.span.file for f in forms if isinstance(f, nodes.DefineRap))
    return _report(_merged(checked, paths), files, raps)


def check_syntax(unit: SourceUnit, selection: Selection) -> list[Finding]:
    """Return the findings of reading a file, as a check of its library reports them."""
    rules = registry.rules()
    valid, _ = suppressions.find_suppressions(unit, rules)
    found, _ = suppressions.apply(unit.diagnostics, valid)
    return [
        Finding(selection.graded(rules[one.rule]), one)
        for one in found
        if selection.chooses(one)
    ]


def merged_reports(reports: Sequence[CheckReport]) -> CheckReport:
    """Return the report on libraries that share files, with the findings of each.

    A suppression is unused if it is unused in every library that holds its file.
    """
    files = {name: file for one in reports for name, file in one.files.items()}
    raps = {name: count for one in reports for name, count in one.raps_in.items()}
    found: dict[_Key, Finding] = {}
    for report in reports:
        for one in report.findings:
            file = one.diagnostic.span.file
            if one.rule.name != suppressions.UNUSED.name or all(
                one in other.findings for other in reports if file in other.files
            ):
                found.setdefault(_key(one.diagnostic), one)
    return _report(found.values(), files, raps)


def _report(
    found: Iterable[Finding], files: Mapping[str, SourceFile], raps: Mapping[str, int]
) -> CheckReport:
    order = {name: at for at, name in enumerate(files)}
    kept = sorted(found, key=lambda one: _order_of(order, one))
    return CheckReport(tuple(kept), files, raps)


@gc_paused()
def _findings(
    loaded: Loaded,
    chosen: Selection,
    before_check: Callable[[Pass], None] | None = None,
    cache: RapCache | None = None,
) -> list[Finding]:
    """Return the findings of one library, filtered by the reasons 1 to 5."""
    damage = Damage(loaded.units)
    complete = all(d.rule != UNRESOLVED.name for d in loaded.diagnostics)
    run = Pass(loaded.library, complete, damage.reaches, loaded.required, cache)
    certain = [
        diagnostic
        for diagnostic, whole in _found(run, chosen.enabled, before_check)
        if not damage.silences(diagnostic, whole)
    ]
    rules = registry.rules(errors_only=registry.are_errors(chosen.enabled))
    found = _unsuppressed(
        loaded, [*loaded.diagnostics, *certain], rules, chosen, damage
    )
    return [
        Finding(chosen.graded(rules[d.rule]), d) for d in found if chosen.chooses(d)
    ]


def _merged(
    checked: Sequence[tuple[Loaded, Sequence[Finding]]], paths: Sequence[str] | None
) -> Iterable[Finding]:
    """Return the findings of libraries that share files, filtered by the reason 6.

    A suppression is unused if it is unused in every library that holds its file.
    """
    found: dict[_Key, Finding] = {}
    for at, (_, findings) in enumerate(checked):
        for one in findings:
            file, rule = one.diagnostic.span.file, one.rule.name
            if at and file in checked[0][0].files and rule not in registry.errors():
                continue
            if rule == suppressions.UNUSED.name and not (
                _is_among(file, paths)
                and all(one in other for lib, other in checked if file in lib.files)
            ):
                continue
            found.setdefault(_key(one.diagnostic), one)
    return found.values()


def _is_among(file: str, paths: Sequence[str] | None) -> bool:
    """Return whether a file is among the paths or below a path."""
    if paths is None or file == STANDARD_INPUT:
        return True
    return any(lies_in(file, path) for path in paths)


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
    every = [one for valid, _ in written for one in valid]
    left, unused = suppressions.apply(found, every)
    left += [one for _, invalid in written for one in invalid]
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


def _found(
    run: Pass,
    enabled: Collection[str],
    before_check: Callable[[Pass], None] | None = None,
) -> Iterator[tuple[Diagnostic, Whole]]:
    """Yield the findings that no finding hides, each with `Check.needs_whole`.

    A check without an enabled rule runs if its findings may hide a finding. Several
    tests of a file share declarations: equal findings are yielded once.
    """
    found: dict[_Key, Diagnostic] = {}
    needs_whole: dict[str, Whole] = {}

    def find(checks: Iterable[Check]) -> None:
        for check in checks:
            if before_check is not None:
                before_check(run)
            needs_whole.update((rule.name, check.needs_whole) for rule in check.rules)
            for one in check.find(run):
                found.setdefault(_key(one), one)

    wanted = registry.checks_for(enabled)
    find(wanted)
    hiders = with_hiders({one.rule for one in found.values()})
    find(one for one in registry.checks_for(hiders) if one not in wanted)
    for one in visible(list(found.values()), _forms(run.library)):
        yield one, needs_whole[one.rule]


def _forms(library: Library) -> Iterator[tuple[Span, Span]]:
    """Yield the spans of all forms, each with the span of the form it belongs to."""
    for form in (*library.forms, *library.tests):
        yield form.span, form.span
    for method in library.methods:
        rap = library.raps.get(method.rap)
        yield method.span, method.span if rap is None else rap.span


_Key = tuple[str, Span, str]
"""The rule, span and message of a finding."""


def _key(one: Diagnostic) -> _Key:
    return one.rule, one.span, one.message


def _order_of(order: Mapping[str, int], finding: Finding) -> tuple[int, int, int, str]:
    """Return the sort key of a finding: the `order` of its file, then the position."""
    span = finding.diagnostic.span
    return order.get(span.file, -1), span.start, span.end, finding.rule.code
