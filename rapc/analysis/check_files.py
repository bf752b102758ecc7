"""Check files by path: a test file alone, all other files as one library.

What the tests of a file run is what `rapc.library.loader` says. A finding that more
than one of these libraries has, in a file that they share, is reported once. A file of
the one library is judged there: what a test requires of it may be a part, in which only
errors count, for they keep the test from being run.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence

from rapc.analysis import registry, suppressions
from rapc.analysis.driver import CheckReport, Finding, check_library, order_of
from rapc.analysis.selection import Selection
from rapc.base.files import TEST_SUFFIX, lies_in, path_of
from rapc.base.source import Span
from rapc.library import loader
from rapc.library.loader import Loaded, Names, Parse, alike, load_tests
from rapc.parser.parse import parse


def check_files(
    paths: Iterable[str],
    selection: Selection | None = None,
    texts: Mapping[str, str] | None = None,
    *,
    parser: Parse = parse,
) -> CheckReport:
    """Check files and folders; test files are checked as they are run.

    Args:
        paths: files, folders (all `.rap` files below), `-` for standard input.
        selection: the rules that may report; those that are not opt-in if None.
        texts: what stands for the texts of some files, by name.
        parser: what makes units of files.

    Raises:
        LoadError: for what cannot be read.
    """
    given = list(paths)
    loaded = _loads(given, texts, parser)
    reports = [check_library(library, selection) for library in loaded]
    return _judged(reports[0] if len(reports) == 1 else _joined(reports), given)


def _loads(
    paths: Iterable[str], texts: Mapping[str, str] | None, parser: Parse
) -> Iterator[Loaded]:
    """Yield the library of all files, then a library for each test file."""
    given = list(dict.fromkeys(paths))
    named = [path for path in given if path.endswith(TEST_SUFFIX)]
    others = [path for path in given if path not in named]
    folders = [path for path in others if os.path.isdir(path_of(path))]
    names: Names = {}
    yield loader.load(others, texts=texts, parser=parser, names=names)
    for sources in alike(loader.read_tests([*named, *folders], texts), parser):
        yield from load_tests(sources, texts, parser, names).libraries


def _judged(report: CheckReport, given: Sequence[str]) -> CheckReport:
    """Return a report without what it says of suppressions in files that it requires.

    What they silence may be due to files that nobody has named.
    """
    left = [
        one
        for one in report.findings
        if one.rule.name != suppressions.UNUSED.name
        or _is_given(one.diagnostic.span.file, given)
    ]
    if len(left) == len(report.findings):
        return report
    return CheckReport(tuple(left), report.files, report.raps_in)


def _is_given(file: str, given: Sequence[str]) -> bool:
    """Whether a file is among the paths that were named, or below one of them."""
    return file == loader.STANDARD_INPUT or any(lies_in(file, path) for path in given)


def _joined(every: Sequence[CheckReport]) -> CheckReport:
    """Return one report on the library and the test files; no finding occurs twice.

    A suppression is unused if no library that holds its file has a use for it.
    """
    own = every[0].files
    files = {name: file for one in every for name, file in one.files.items()}
    raps = {name: number for one in every for name, number in one.raps_in.items()}
    found: dict[tuple[str, Span, str], Finding] = {}
    for report in every:
        for finding in report.findings:
            if (
                report is not every[0]
                and finding.diagnostic.span.file in own
                and finding.rule.name not in registry.errors()
            ):
                continue
            if finding.rule.name != suppressions.UNUSED.name or all(
                finding in other.findings
                for other in every
                if finding.diagnostic.span.file in other.files
            ):
                diagnostic = finding.diagnostic
                key = diagnostic.rule, diagnostic.span, diagnostic.message
                found.setdefault(key, finding)
    order = {name: at for at, name in enumerate(files)}
    findings = sorted(found.values(), key=lambda one: order_of(order, one))
    return CheckReport(tuple(findings), files, raps)
