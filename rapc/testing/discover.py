"""Find tests, and link, check and compile their libraries.

The library of a test is its file with all files that this file and the test require.
Tests that require the same files share a library.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping
from pathlib import Path

import msgspec

from rapc.analysis.driver import CheckReport, Finding, check_library, check_tests
from rapc.analysis.selection import errors
from rapc.base import files
from rapc.base.source import SourceFile, Span
from rapc.compiler.program import Program
from rapc.ir.nodes import DefineTest
from rapc.library import loader
from rapc.library.loader import load_tests
from rapc.library.saved import SavedLibrary
from rapc.testing.run import Case


class FoundTests(msgspec.Struct, frozen=True):
    """The tests found, or the reports on libraries with errors."""

    cases: tuple[Case, ...]
    reports: tuple[CheckReport, ...]


def find(
    paths: Iterable[str | Path], texts: Mapping[str, str] | None = None
) -> FoundTests:
    """Return the tests in files (`-` is one), and in `*.test.rap` below folders.

    The tests of compiled libraries come first. `texts` has the texts of files by name.

    Raises:
        LoadError: for a path that cannot be read.
        SavedError: for a compiled library that this rapc cannot run.
    """
    cases: list[Case] = []
    reports: list[CheckReport] = []
    sources: list[str] = []
    for path in dict.fromkeys(map(str, paths)):
        data = None if path in (texts or ()) else files.read_compiled(path)
        if data is None:
            sources.append(path)
        else:
            for tests, linked, name in SavedLibrary(data, path).suites():
                library = Program(linked, name)
                faults = _by_test(check_tests(linked, tests), tests)
                cases += [Case(t, library, tuple(faults[t.span])) for t in tests]
    for source in loader.read_tests(sources, texts):
        cases += _find_in(source, reports)
    return FoundTests(tuple(cases), tuple(reports))


def _find_in(source: SourceFile, reports: list[CheckReport]) -> list[Case]:
    """Return the tests of a file; check tests with equal requirements together.

    An error in a test prevents only the run of this test. An error in a library is
    added to `reports` once.
    """
    file = load_tests([source])
    own = file.tests
    cases: dict[Span, Case] = {}
    for loaded in file.libraries:
        report = check_library(loaded, errors())
        faults = _by_test(report.findings, own)
        in_tests = {id(finding) for one in faults.values() for finding in one}
        found = report.findings
        elsewhere = [finding for finding in found if id(finding) not in in_tests]
        if elsewhere:
            _tell(report, elsewhere, reports)
            continue
        program = Program(loaded.library, source.name)
        for test in loaded.library.tests:
            cases[test.span] = Case(test, program, tuple(faults[test.span]))
    return [cases[test.span] for test in own if test.span in cases]


def _tell(
    report: CheckReport, errors: Iterable[Finding], reports: list[CheckReport]
) -> None:
    """Add a report on the errors of a library that no report contains yet."""
    told = [f for earlier in reports for f in earlier.findings]
    new = tuple([finding for finding in errors if finding not in told])
    reports.append(msgspec.structs.replace(report, findings=new))


def _by_test(
    found: Iterable[Finding], tests: Iterable[DefineTest]
) -> dict[Span, list[Finding]]:
    """Return the findings whose position is in a test, by position of the test."""
    spans = sorted((t.span for t in tests), key=lambda span: (span.file, span.start))
    faults: dict[Span, list[Finding]] = {span: [] for span in spans}
    for finding in found:
        place = finding.diagnostic.span
        here = (place.file, place.start)
        at = bisect_right(spans, here, key=lambda span: (span.file, span.start)) - 1
        if at >= 0 and spans[at].file == place.file and place.start < spans[at].end:
            faults[spans[at]].append(finding)
    return faults
