"""Find tests, and link, check and compile the libraries they run.

The library of a test is its file with what that requires and what the test itself
requires; tests that require the same share one.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import msgspec

from rapc.analysis.driver import Report, check_library
from rapc.base import files
from rapc.base.diagnostics import Severity
from rapc.base.source import SourceFile
from rapc.compiler.artifact import Artifact
from rapc.compiler.program import Program
from rapc.ir.nodes import DefineTest
from rapc.library import loader
from rapc.testing.run import Case


class Found(msgspec.Struct, frozen=True):
    """What was found: the tests, or the reports on libraries that have errors."""

    cases: tuple[Case, ...]
    reports: tuple[Report, ...]


def find(paths: Iterable[str | Path]) -> Found:
    """The tests in files (`-` is one), and in all `*.test.rap` files below folders.

    Those in compiled libraries come first.

    Raises:
        LoadError: for what cannot be read.
        SavedError: for a compiled library that this rapc cannot run.
    """
    cases: list[Case] = []
    reports: list[Report] = []
    sources: list[str] = []
    for path in dict.fromkeys(map(str, paths)):
        data = files.read_compiled(path)
        if data is None:
            sources.append(path)
        else:
            for tests, library in Artifact(data, path).suites():
                cases += [Case(test, library) for test in tests]
    for source in loader.read_tests(sources):
        found = _find_in(source)
        cases += found.cases
        reports += found.reports
    return Found(tuple(cases), tuple(reports))


def _find_in(source: SourceFile) -> Found:
    cases: list[Case] = []
    reports: list[Report] = []
    libraries: dict[tuple[str, ...], Program | None] = {}
    whole = loader.load_for_test(source, ())
    tests = _own(whole.library.tests, source)
    for test in tests:
        names = tuple([form.name for form in test.requires])
        if names not in libraries:
            loaded = loader.load_for_test(source, test.requires) if names else whole
            libraries[names] = _compiled(check_library(loaded), source, reports)
        library = libraries[names]
        if library is not None:
            cases.append(Case(test, library))
    if not tests:
        _compiled(check_library(whole), source, reports)
    return Found(tuple(cases), tuple(reports))


def _compiled(
    report: Report, source: SourceFile, reports: list[Report]
) -> Program | None:
    """A library without errors; those of another are added to the reports, once."""
    errors = [f for f in report.findings if f.severity is Severity.ERROR]
    if not errors:
        return Program(report.library, source.name)
    told = [f for earlier in reports for f in earlier.findings]
    new = tuple([finding for finding in errors if finding not in told])
    reports.append(msgspec.structs.replace(report, findings=new))
    return None


def _own(tests: Iterable[DefineTest], source: SourceFile) -> list[DefineTest]:
    """The tests that stand in a file itself, not in one that it requires."""
    return [test for test in tests if test.span.file == source.name]
