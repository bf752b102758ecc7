"""Apply the fixes of findings until no fix is left.

Fixes may overlap, and a fix may uncover findings with further fixes. A round applies
fixes that do not overlap, checks the library again, and the next round follows. This
module writes no files. A round keeps only the fixes that improve the library
(`_is_better`). If all fixes together do not improve the library, the round tries the
fixes in halves, and a bad fix does not prevent the good ones.

The checker withholds findings about a form in which parentheses do not match. For this
reason the fixes of the parser come first, and the next check may report withheld
faults. If no later round repairs these faults, the other fixes begin with the best
library before that.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import groupby

import msgspec

from rapc.analysis.driver import CheckReport, Finding
from rapc.base.diagnostics import Applicability, Fix, Severity, edited
from rapc.base.source import Span
from rapc.parser.rules.table import RULES
from rapc.parser.rules.text import TEXT_RULES

_CHECKS = 100
"""The maximum number of checks of one call; fixes left after that are not applied."""

_Count = tuple[int, ...]
"""Numbers of findings, the most important one first."""

_Check = Callable[[Mapping[str, str]], CheckReport]


class Mended(msgspec.Struct, frozen=True):
    """The result of applying fixes."""

    #: The texts that changed, by file name.
    texts: Mapping[str, str]
    #: The report on the library with these texts.
    report: CheckReport
    #: The number of applied fixes.
    fixed: int
    #: The fixes that were tried and rejected.
    refused: frozenset[Fix] = frozenset()


def mend(check: _Check, allowed: Callable[[str], bool], *, unsafe: bool) -> Mended:
    """Check a library and apply fixes repeatedly, until no fix is left.

    Args:
        check: checks the library, with other texts for some files.
        allowed: whether the file with a name may be changed.
        unsafe: whether to apply fixes that may change the meaning.
    """
    left = iter(range(_CHECKS))

    def offered(report: CheckReport, of_parser: bool) -> list[Fix]:
        findings = report.findings
        some = (f for f in findings if (f.rule.name in _OF_PARSER) is of_parser)
        return _applicable(some, allowed, unsafe)

    def rounds(now: Mended, of_parser: bool) -> Iterator[Mended]:
        fixes = offered(now.report, of_parser)
        while fixes:
            apart = list(_apart(fixes))
            after = _round(check, left, now, apart)
            if after is now:
                tried = frozenset(apart)
                fixes = [fix for fix in fixes if fix not in tried]
            else:
                now = after
                fixes = offered(now.report, of_parser)
                yield now

    best = Mended({}, check({}), 0)
    for now in rounds(best, of_parser=True):
        if _is_better(best.report, now.report, _of_parser):
            best = now
    best = [best, *rounds(best, of_parser=False)][-1]
    if next(left, None) is None:
        return best
    refused = frozenset(_applicable(best.report.findings, allowed, unsafe))
    return msgspec.structs.replace(best, refused=refused)


def _round(
    check: _Check, left: Iterator[int], before: Mended, fixes: Sequence[Fix]
) -> Mended:
    """Apply the fixes that improve a library; return it unchanged if none does.

    Args:
        check: checks the library with other texts.
        left: yields one item for each check that may still be made.
        before: the library before the fixes.
        fixes: fixes that do not overlap.
    """
    kept: list[Fix] = []
    now = before
    waiting = [fixes] if fixes else []
    while waiting and next(left, None) is not None:
        some = waiting.pop()
        texts = {**before.texts, **_applied([*kept, *some], before.report)}
        report = check(texts)
        if _is_better(now.report, report, _of_reader_and_parser):
            kept += some
            now = Mended(texts, report, before.fixed + len(kept))
        elif len(some) > 1:
            half = len(some) // 2
            waiting += [some[half:], some[:half]]
    return now


def _applicable(
    findings: Iterable[Finding], allowed: Callable[[str], bool], unsafe: bool
) -> list[Fix]:
    """Return the fixes that may be applied, in the order of findings."""
    wanted = {Applicability.SAFE, *([Applicability.UNSAFE] if unsafe else [])}
    fixes = (finding.diagnostic.fix for finding in findings)
    return [
        fix
        for fix in fixes
        if fix is not None
        and fix.edits
        and fix.applicability in wanted
        and all(allowed(edit.span.file) for edit in fix.edits)
    ]


def _apart(fixes: Iterable[Fix]) -> Iterator[Fix]:
    """Yield the fixes that overlap none of the preceding fixes."""
    taken: dict[str, list[tuple[int, int]]] = {}
    for fix in fixes:
        spans = [edit.span for edit in fix.edits]
        if all(_is_free(span, taken.get(span.file, [])) for span in spans):
            for span in spans:
                insort(taken.setdefault(span.file, []), (span.start, span.end))
            yield fix


def _is_free(span: Span, taken: Sequence[tuple[int, int]]) -> bool:
    """Return whether a span overlaps none of some sorted, disjoint stretches."""
    at = bisect_right(taken, (span.start, span.end))
    before = at == 0 or taken[at - 1][1] < span.start
    return before and (at == len(taken) or span.end < taken[at][0])


def _applied(fixes: Iterable[Fix], report: CheckReport) -> dict[str, str]:
    """Return the new texts of the files that some fixes change."""
    edits = sorted(
        (edit for fix in fixes for edit in fix.edits),
        key=lambda edit: (edit.span.file, edit.span.start),
    )
    return {
        file: edited(report.files[file].text, group)
        for file, group in groupby(edits, key=lambda edit: edit.span.file)
    }


def _is_better(
    before: CheckReport, after: CheckReport, most: Callable[[CheckReport], _Count]
) -> bool:
    """Return whether a library is better after fixes than before.

    A library is better if the count `most` is lower. If the count is equal, no rule may
    report more errors, and there must be fewer errors, or as many errors and fewer
    findings.
    """
    if most(after) != most(before):
        return most(after) < most(before)
    old, new = _errors(before), _errors(after)
    fewer = (new.total(), len(after.findings)) < (old.total(), len(before.findings))
    return new <= old and fewer


def _of_parser(report: CheckReport) -> _Count:
    """Return the number of findings of the parser."""
    return (sum(f.rule.name in _OF_PARSER for f in report.findings),)


def _of_reader_and_parser(report: CheckReport) -> _Count:
    """Return the number of findings of the reader, and of reader and parser together.

    Where the reader finds an error, the parser withholds its own findings.
    """
    return (
        sum(f.rule.name in _OF_READER for f in report.findings),
        *_of_parser(report),
    )


def _errors(report: CheckReport) -> Counter[str]:
    """Return the number of errors by rule."""
    findings = report.findings
    return Counter(f.rule.name for f in findings if f.severity is Severity.ERROR)


_OF_READER = frozenset(rule.name for rule in TEXT_RULES) - {"unknown-form"}
"""The rules of the reader: parentheses and the like."""

_OF_PARSER = frozenset(rule.name for rule in RULES)
"""The rules of the parser."""
