"""Printed programs are put right: each slip is told, and mended where it can be."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from rapc.analysis.driver import CheckReport, check_library
from rapc.analysis.fixes import Mended, mend
from rapc.library.loader import load_text
from rapc.parser.rules.table import RULES

PROGRAM = Path(__file__).with_name("printed.rap").read_text(encoding="utf-8")
OF_TEXT = {rule.name for rule in RULES}


def _mended(*, unsafe: bool) -> Mended:
    def check(texts: Mapping[str, str]) -> CheckReport:
        return check_library(load_text(texts.get("<text>", PROGRAM)))

    return mend(check, lambda _: True, unsafe=unsafe)


def test_every_slip_has_a_fix() -> None:
    report = check_library(load_text(PROGRAM))
    assert len(report.findings) == PROGRAM.count("; expect: ")
    assert [f.rule.name for f in report.findings if f.diagnostic.fix is None] == []


def test_nothing_is_left_once_all_is_mended() -> None:
    mended = _mended(unsafe=True)
    assert mended.report.findings == ()
    assert mended.texts["<text>"].count("; expect: ") == PROGRAM.count("; expect: ")


def test_what_is_certain_is_mended_without_the_rest() -> None:
    mended = _mended(unsafe=False)
    left = [f.rule.name for f in mended.report.findings if f.rule.name in OF_TEXT]
    assert left == [
        "not-of-many",
        "believe-without-time",
        "duplicate-method",
        "surplus-parenthesis",
        "missing-parenthesis",
    ]
