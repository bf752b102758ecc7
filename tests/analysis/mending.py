"""Damaged texts, fixed to rest: the promises of `--fix --unsafe-fixes`.

`python -m tests.analysis.mending 1000` fixes so many texts, half of them single RAPs
without their declarations. It prints the texts that break a promise, and how many
texts end without findings of the parser and without errors.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import pairwise
from random import Random
from typing import NamedTuple

from rapc.analysis.driver import CheckReport, check_library
from rapc.analysis.fixes import mend
from rapc.analysis.selection import Selection
from rapc.base.diagnostics import Severity
from rapc.library.loader import load_text
from rapc.parser.rules.table import RULES
from tests.damage import MOST_SLIPS, shipped_raps, slipped, sound_texts

_TEXT = "<text>"
_PARSER = frozenset(rule.name for rule in RULES)


class Numbers(NamedTuple):
    """How much is found in a text, in the order in which two texts are compared."""

    of_parser: int
    errors: int
    findings: int


class Fixed(NamedTuple):
    """A text that was fixed to rest."""

    text: str
    before: CheckReport
    after: CheckReport
    #: The most characters that one check found added to the text of the check before.
    growth: int


def to_rest(text: str, selection: Selection | None = None) -> Fixed:
    """Carry out all fixes of a text."""
    texts: list[str] = []
    reports: list[CheckReport] = []

    def check(changed: Mapping[str, str]) -> CheckReport:
        texts.append(changed.get(_TEXT, text))
        reports.append(check_library(load_text(texts[-1]), selection))
        return reports[-1]

    mended = mend(check, lambda _: True, unsafe=True)
    grown = [len(after) - len(before) for before, after in pairwise(texts)]
    after = mended.texts.get(_TEXT, text)
    return Fixed(after, reports[0], mended.report, max([0, *grown]))


def numbers(report: CheckReport) -> Numbers:
    """Return how much a report finds."""
    of_parser = sum(found.rule.name in _PARSER for found in report.findings)
    return Numbers(of_parser, _errors(report).total(), len(report.findings))


def _errors(report: CheckReport) -> Counter[str]:
    findings = report.findings
    return Counter(f.rule.name for f in findings if f.severity is Severity.ERROR)


def broken_by_fixes(text: str, selection: Selection | None = None) -> Iterator[str]:
    """Yield the promises that the fixes of a text break."""
    fixed = to_rest(text, selection)
    before, after = numbers(fixed.before), numbers(fixed.after)
    if after > before:
        yield f"fixes bring in findings: {before} {after}"
    if after.of_parser == before.of_parser:
        more = _errors(fixed.after) - _errors(fixed.before)
        if more:
            yield f"fixes replace errors by others: {dict(more)}"
    grown = len(fixed.text) - len(text)
    if grown > MOST_SLIPS * fixed.growth:
        yield f"fixes add {grown} characters, {fixed.growth} at most in one round"
    if fixed.text != text and to_rest(fixed.text, selection).text != fixed.text:
        yield "fixes are left"


def damaged_texts(count: int, seed: int = 0) -> Iterator[str]:
    """Yield texts with one to three slips; every second is a single RAP."""
    dice = Random(f"mending:{seed}")
    for number in range(count):
        texts = shipped_raps() if number % 2 else sound_texts()
        yield slipped(dice.choice(texts), dice)


def run(count: int, seed: int = 0) -> Iterator[str]:
    """Yield the promises that so many texts break, each with its text."""
    for text in damaged_texts(count, seed):
        for promise in broken_by_fixes(text):
            yield f"{promise}\n{text}"


if __name__ == "__main__":
    texts = list(damaged_texts(int(sys.argv[1])))
    faults = [f"{said}\n{text}" for text in texts for said in broken_by_fixes(text)]
    ends = [numbers(to_rest(text).after) for text in texts]
    sound = sum(not end.of_parser for end in ends)
    valid = sum(not end.errors for end in ends)
    print(*faults, f"{len(faults)} faults in {len(texts)} texts", sep="\n\n")
    print(f"{sound} without findings of the parser, {valid} without errors")
    sys.exit(bool(faults))
