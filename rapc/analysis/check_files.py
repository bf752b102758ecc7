"""Check files by their paths: test files one by one, all others as one library.

What the tests of a file run is what `rapc.library.test_files` says. A finding that more
than one of these libraries has, in a file that they share, is reported once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING

from rapc.analysis import suppressions
from rapc.analysis.driver import CheckReport, Finding, check_library, order_of
from rapc.analysis.selection import Selection
from rapc.base.files import TEST_SUFFIX, lies_in
from rapc.base.source import SourceFile, Span
from rapc.library import loader
from rapc.library.loader import Loaded, Parse
from rapc.library.test_files import load_tests
from rapc.parser.parse import parse

if TYPE_CHECKING:
    from rapc.analysis.cache import Cache


def check_files(
    paths: Iterable[str],
    selection: Selection | None = None,
    texts: Mapping[str, str] | None = None,
    *,
    parser: Parse = parse,
    cache: Cache | None = None,
) -> CheckReport:
    """Check files and folders; test files that are named are checked as they are run.

    Args:
        paths: files, folders (all `.rap` below but tests), `-` for standard input.
        selection: the rules that may report; those that are not opt-in if None.
        texts: what stands for the texts of some files, by name.
        parser: what makes units of files, unless there is a cache, which has its own.
        cache: what earlier checks of these paths came to, and where this one is kept.

    Raises:
        LoadError: for what cannot be read.
    """
    check = partial(check_library, selection=selection)
    reports: list[CheckReport] = []
    given = list(paths)
    for load in _loads(given, texts):
        if cache is None:
            reports += map(check, load(parser))
        else:
            reports += cache.reports(load)
    if cache is not None:
        cache.save()
    return _judged(reports[0] if len(reports) == 1 else _joined(reports), given)


def _loads(
    paths: Iterable[str], texts: Mapping[str, str] | None
) -> Iterator[Callable[[Parse], Sequence[Loaded]]]:
    """Yield what loads the libraries: one of all files, those of each file of tests."""
    given = list(dict.fromkeys(paths))
    named = [path for path in given if path.endswith(TEST_SUFFIX)]
    others = [path for path in given if path not in named]
    if others or not named:
        yield lambda parser: [loader.load(others, texts=texts, parser=parser)]
    for source in loader.read_tests(named, texts):
        yield partial(_of_tests, source, texts)


def _of_tests(
    source: SourceFile, texts: Mapping[str, str] | None, parser: Parse
) -> Sequence[Loaded]:
    return load_tests(source, texts, parser).libraries


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


def _joined(reports: Iterable[CheckReport]) -> CheckReport:
    """Return one report on several libraries, each finding once.

    A suppression is unused if no library that holds its file has a use for it.
    """
    every = list(reports)
    files = {name: file for one in every for name, file in one.files.items()}
    raps = {name: number for one in every for name, number in one.raps_in.items()}
    found: dict[tuple[str, Span, str], Finding] = {}
    for report in every:
        for finding in report.findings:
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
