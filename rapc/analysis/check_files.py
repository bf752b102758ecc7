"""Check files by their paths: test files one by one, all others as one library.

What the tests of a file run is what `rapc.library.test_files` says. A finding that more
than one of these libraries has, in a file that they share, is reported once.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import msgspec

from rapc.analysis import suppressions
from rapc.analysis.driver import CheckReport, Finding, check_library, place_of
from rapc.analysis.selection import Selection
from rapc.base.files import TEST_SUFFIX
from rapc.base.source import Span
from rapc.library import loader
from rapc.library.test_files import load_tests


def check_files(
    paths: Iterable[str],
    selection: Selection | None = None,
    texts: Mapping[str, str] | None = None,
) -> CheckReport:
    """Check files and folders; test files that are named are checked as they are run.

    Args:
        paths: files, folders (all `.rap` below but tests), `-` for standard input.
        selection: the rules that may report; those that are not opt-in if None.
        texts: what stands for the texts of some files, by name.

    Raises:
        LoadError: for what cannot be read.
    """
    given = list(dict.fromkeys(paths))
    named = [path for path in given if path.endswith(TEST_SUFFIX)]
    others = [path for path in given if path not in named]
    reports = []
    if others or not named:
        reports.append(check_library(loader.load(others, texts=texts), selection))
    for path in named:
        for source in loader.read_tests([path], texts):
            for loaded in load_tests(source, texts).libraries:
                reports.append(check_library(loaded, selection))
    return reports[0] if len(reports) == 1 else _joined(reports)


def _joined(reports: Iterable[CheckReport]) -> CheckReport:
    """Return one report on several libraries, each finding once.

    A suppression is unused if no library that holds its file has a use for it.
    """
    every = list(reports)
    files = {name: file for one in every for name, file in one.files.items()}
    forms = {form.span: form for one in every for form in one.library.forms}
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
    findings = sorted(found.values(), key=lambda one: place_of(order, one))
    library = every[0].library
    joined = msgspec.structs.replace(library, files=files, forms=tuple(forms.values()))
    return CheckReport(tuple(findings), joined)
