"""How fixes are carried out: none that touch each other, none that make it worse."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import msgspec

from rapc.analysis import suite
from rapc.analysis.driver import CheckReport, Finding, check_library
from rapc.analysis.fixes import Mended, mend
from rapc.base.diagnostics import Applicability, Diagnostic, Edit, Fix, Rule
from rapc.base.source import Span
from rapc.library.loader import load_text

WARNING = suite.rules()["unused-suppression"]
ERROR = suite.rules()["unknown-rap"]

Say = Callable[[str], Sequence[tuple[Rule, int, int, str]]]


def _mended(text: str, say: Say, allowed: bool = True) -> tuple[str, Mended]:
    """Mend a text of which `say` tells what is found: rule, start, end, new text."""

    def check(texts: Mapping[str, str]) -> CheckReport:
        now = texts.get("<text>", text)
        report = check_library(load_text(now))
        findings = [
            Finding(rule, _diagnostic(rule, Span("<text>", start, end), new))
            for rule, start, end, new in say(now)
        ]
        return msgspec.structs.replace(report, findings=tuple(findings))

    mended = mend(check, lambda name: allowed, unsafe=False)
    return mended.texts.get("<text>", text), mended


def _diagnostic(rule: Rule, span: Span, new: str) -> Diagnostic:
    fix = Fix(Applicability.SAFE, "put it right", (Edit(span, new),))
    return Diagnostic(rule.name, "it is wrong", span, fix=fix)


def _letters(text: str, letter: str) -> Sequence[tuple[Rule, int, int, str]]:
    found = [at for at, each in enumerate(text) if each == letter]
    return [(WARNING, at, at + 1, "; ") for at in found]


def test_all_fixes_that_lie_apart_are_carried_out_at_once() -> None:
    text, mended = _mended("; a x a x a", lambda text: _letters(text, "x"))
    assert (text, mended.fixed) == ("; a ;  a ;  a", 2)
    assert mended.report.findings == ()


def test_fixes_that_touch_take_turns() -> None:
    rounds: list[str] = []

    def say(text: str) -> Sequence[tuple[Rule, int, int, str]]:
        rounds.append(text)
        return _letters(text, "x")

    text, mended = _mended("; xx", say)
    assert rounds == ["; xx", "; ; x", "; ; ; "]
    assert (text, mended.fixed) == ("; ; ; ", 2)


def test_a_round_that_brings_in_errors_is_not_kept() -> None:
    def say(text: str) -> Sequence[tuple[Rule, int, int, str]]:
        return [(WARNING, 0, 1, ";!")] if "!" not in text else [(ERROR, 0, 1, ";")]

    text, mended = _mended("; a", say)
    assert (text, mended.fixed) == ("; a", 0)
    assert [f.rule for f in mended.report.findings] == [WARNING]


def test_fixes_that_bring_each_other_about_come_to_an_end() -> None:
    text, mended = _mended("; a", lambda text: [(WARNING, 0, 1, ";")])
    assert (text, len(mended.report.findings)) == ("; a", 1)


def test_files_that_may_not_be_changed_are_not() -> None:
    text, mended = _mended("; x", lambda text: _letters(text, "x"), allowed=False)
    assert (text, mended.fixed) == ("; x", 0)


def _texts(texts: Mapping[str, str], text: str) -> CheckReport:
    return check_library(load_text(texts.get("<text>", text)))


def test_errors_that_a_parenthesis_hid_do_not_keep_it_from_being_put_right() -> None:
    text = (
        "(define-rap (go)\n  (succeed (lost a b)))\n  (method (task-net (t1 (gone)))))"
    )
    before = _texts({}, text)
    assert [f.rule.name for f in before.findings] == ["surplus-parenthesis"]
    mended = mend(lambda texts: _texts(texts, text), lambda name: True, unsafe=True)
    assert mended.texts["<text>"] == text.replace("(lost a b)))", "(lost a b))")
    found = [f.rule.name for f in mended.report.findings]
    assert found == ["undeclared-predicate", "unknown-rap"]
