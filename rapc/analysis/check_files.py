"""Check files by path: a test file alone, all other files as one library.

`rapc.library.loader` determines which files a test file runs with. A finding that two
of these libraries have in a shared file is reported once. The library of all other
files decides about the files in that library. A test may require a part of the
library; there only errors count, because an error prevents the test from running.
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
    """Check files and folders; a test file is checked as it is run.

    Args:
        paths: files, folders (all `.rap` files below), `-` for standard input.
        selection: the rules that may report; None for all rules that are not opt-in.
        texts: by file name, a text that replaces the text of the file.
        parser: the function that parses a file.

    Raises:
        LoadError: if a path cannot be read.
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
    """Return a report without findings about suppressions in required files.

    These suppressions may silence findings that depend on files outside the paths.
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
    """Return whether a file is among the paths or below a path."""
    return file == loader.STANDARD_INPUT or any(lies_in(file, path) for path in given)


def _joined(every: Sequence[CheckReport]) -> CheckReport:
    """Merge the reports on the library and the test files, without duplicates.

    A suppression is unused if it is unused in every library that holds its file.
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
