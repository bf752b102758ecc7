"""Carry out the fixes that findings bring, until there is none left to carry out.

Fixes may overlap, and one may bring others to light: so a round carries out those that
do not touch each other, the library is checked again, and so on. Nothing is written
here. A round that would bring in errors that were not there before is not kept; but
where the text of a form was not in order, what else is wrong there was not told, and
comes to light when the text is put right.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import groupby

import msgspec

from rapc.analysis.driver import CheckReport, Finding
from rapc.base.diagnostics import Applicability, Fix, Severity
from rapc.base.source import Span
from rapc.parser.rules.forms import FORM_RULES
from rapc.parser.rules.slips import SLIP_RULES
from rapc.parser.rules.text import TEXT_RULES

_ROUNDS = 20
"""After so many rounds fixes that bring each other about are left as they are."""


class Mended(msgspec.Struct, frozen=True):
    """What carrying out fixes came to."""

    #: The texts that changed, by the names of their files.
    texts: Mapping[str, str]
    #: The report on the library with these texts.
    report: CheckReport
    #: How many fixes were carried out.
    fixed: int


def mend(
    check: Callable[[Mapping[str, str]], CheckReport],
    allowed: Callable[[str], bool],
    *,
    unsafe: bool,
) -> Mended:
    """Check a library, carry out fixes, and check it again, while there are any.

    Args:
        check: checks the library with other texts for some of its files.
        allowed: whether the file of a name may be changed.
        unsafe: whether fixes that may change the meaning are carried out as well.
    """
    texts: dict[str, str] = {}
    report = check(texts)
    fixed = 0
    for _ in range(_ROUNDS):
        chosen = list(_chosen(report.findings, allowed, unsafe))
        if not chosen:
            break
        tried = texts | _applied(chosen, report)
        after = check(tried)
        if _is_worse(report, after):
            break
        texts, report, fixed = tried, after, fixed + len(chosen)
    return Mended(texts, report, fixed)


def _applicable(fix: Fix | None, unsafe: bool) -> bool:
    wanted = {Applicability.SAFE, *([Applicability.UNSAFE] if unsafe else [])}
    return fix is not None and bool(fix.edits) and fix.applicability in wanted


def _chosen(
    findings: Iterable[Finding], allowed: Callable[[str], bool], unsafe: bool
) -> Iterator[Fix]:
    """Yield fixes that do not touch each other, in the order of their findings."""
    taken: dict[str, list[tuple[int, int]]] = {}
    for finding in findings:
        fix = finding.diagnostic.fix
        if fix is None or not _applicable(fix, unsafe):
            continue
        spans = [edit.span for edit in fix.edits]
        if all(
            allowed(span.file) and _is_free(span, taken.get(span.file, []))
            for span in spans
        ):
            for span in spans:
                insort(taken.setdefault(span.file, []), (span.start, span.end))
            yield fix


def _is_free(span: Span, taken: Sequence[tuple[int, int]]) -> bool:
    """Whether a span touches none of some stretches that are sorted and lie apart."""
    at = bisect_right(taken, (span.start, span.end))
    before = at == 0 or taken[at - 1][1] < span.start
    return before and (at == len(taken) or span.end < taken[at][0])


def _applied(fixes: Iterable[Fix], report: CheckReport) -> dict[str, str]:
    """Return the texts of the files that some fixes change, changed."""
    edits = sorted(
        (edit for fix in fixes for edit in fix.edits),
        key=lambda edit: (edit.span.file, edit.span.start),
    )
    texts = {}
    for file, group in groupby(edits, key=lambda edit: edit.span.file):
        text, at = report.files[file].text, 0
        pieces = []
        for edit in group:
            pieces += [text[at : edit.span.start], edit.content]
            at = edit.span.end
        texts[file] = "".join([*pieces, text[at:]])
    return texts


def _is_worse(before: CheckReport, after: CheckReport) -> bool:
    """Whether there are more errors of a sort, and no fewer of a sort that hides it."""
    return _errors(after) > _errors(before)


def _errors(report: CheckReport) -> tuple[int, int, int]:
    """Return how many errors texts have, how many more their forms, and all in all."""
    errors = [f.rule.name for f in report.findings if f.severity is Severity.ERROR]
    texts = sum(name in _OF_TEXTS for name in errors)
    forms = sum(name in _OF_FORMS for name in errors)
    return texts, texts + forms, len(errors)


_OF_TEXTS = frozenset(rule.name for rule in TEXT_RULES)
"""The rules about parentheses and the like."""

_OF_FORMS = frozenset(rule.name for rule in (*FORM_RULES, *SLIP_RULES))
"""The rules about what stands in parentheses."""
