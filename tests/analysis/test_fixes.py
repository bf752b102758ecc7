"""How fixes are carried out: none that touch each other, only those that improve."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import msgspec

from rapc.analysis import registry
from rapc.analysis.driver import CheckReport, Finding, check_library
from rapc.analysis.fixes import Mended, mend
from rapc.base.diagnostics import Applicability, Diagnostic, Edit, Fix, Rule
from rapc.base.source import Span
from rapc.library.loader import load_text

WARNING = registry.rules()["unused-suppression"]
ERROR = registry.rules()["unknown-rap"]
OTHER_ERROR = registry.rules()["wrong-step-arity"]

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


def test_a_fix_that_leaves_as_many_findings_is_not_kept() -> None:
    text, mended = _mended("; a", lambda text: [(WARNING, 0, 0, ";")])
    assert (text, mended.fixed, len(mended.report.findings)) == ("; a", 0, 1)


def test_a_fix_that_replaces_an_error_by_another_is_not_kept() -> None:
    def say(text: str) -> Sequence[tuple[Rule, int, int, str]]:
        if "y" in text:
            return [(OTHER_ERROR, 0, 0, "")]
        return [(ERROR, 2, 3, "y"), (WARNING, 0, 0, "")]

    text, mended = _mended("; x", say)
    assert (text, mended.fixed) == ("; x", 0)
    assert {fix.edits[0].content for fix in mended.refused} == {"", "y"}


def test_a_bad_fix_does_not_stop_the_good_ones() -> None:
    def say(text: str) -> Sequence[tuple[Rule, int, int, str]]:
        bad = [(WARNING, at, at + 1, "!") for at, c in enumerate(text) if c == "y"]
        return [
            *_letters(text, "x"),
            *bad,
            *[(ERROR, 0, 0, "") for c in text if c == "!"],
        ]

    text, mended = _mended("; x x y x", say)
    assert (text, mended.fixed) == ("; ;  ;  y ; ", 3)
    assert [f.rule for f in mended.report.findings] == [WARNING]


def test_a_second_fix_at_a_place_is_tried_if_the_first_is_not_kept() -> None:
    def say(text: str) -> Sequence[tuple[Rule, int, int, str]]:
        if "!" in text:
            return [(ERROR, 0, 0, "")]
        return [(WARNING, 2, 3, "!"), (WARNING, 2, 3, "y")] if "x" in text else []

    text, mended = _mended("; x", say)
    assert (text, mended.fixed, mended.refused) == ("; y", 1, frozenset())


def test_checks_are_limited() -> None:
    calls: list[str] = []

    def say(text: str) -> Sequence[tuple[Rule, int, int, str]]:
        calls.append(text)
        return [(WARNING, 2, 3, "") for letter in text if letter == "x"]

    text, mended = _mended("; " + "x" * 300, say)
    assert (len(calls), mended.fixed) == (101, 100)
    assert text == "; " + "x" * 200


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


def test_faults_that_a_parenthesis_hid_are_fixed_after_it() -> None:
    text = "(define-rap (go)\n  (sucede nil)\n  (metod (task-net))\n"
    assert [f.rule.name for f in _texts({}, text).findings] == ["missing-parenthesis"]
    mended = mend(lambda texts: _texts(texts, text), lambda name: True, unsafe=True)
    sound = "(define-rap (go)\n  (succeed nil)\n  (method (task-net)))\n"
    assert (mended.texts["<text>"], mended.fixed) == (sound, 3)


def test_a_parenthesis_that_hides_more_faults_than_have_fixes_stays() -> None:
    text = "(define-rap (go)\n  (weather)\n  (mood)\n  (method (task-net))\n"
    assert [f.rule.name for f in _texts({}, text).findings] == ["missing-parenthesis"]
    mended = mend(lambda texts: _texts(texts, text), lambda name: True, unsafe=True)
    assert (mended.texts, mended.fixed) == ({}, 0)


def test_other_faults_are_fixed_where_a_parenthesis_stays() -> None:
    text = "(define-rap (go)\n  (weather)\n  (mood)\n  (method (task-net))\n"
    text += "(define-rap (halt)\n  (method (task-net (t1 (hlat)))))\n"
    mended = mend(lambda texts: _texts(texts, text), lambda name: True, unsafe=True)
    assert mended.texts == {"<text>": text.replace("hlat", "halt")}


def test_two_findings_of_one_slip_do_not_swap_its_names() -> None:
    """One finding offers to write `?litress`, the other to write `?litres`."""
    text = "(declare-memory-property room (?x) unknown)\n"
    text += "(declare-primitive fill (?x) (okay))\n(define-rap (fill-up ?litress)\n"
    text += "  (preconditions (and (room ?room) (<= ?litres ?room)))\n"
    text += "  (method (primitive (fill ?litres))))\n"
    mended = mend(lambda texts: _texts(texts, text), lambda name: True, unsafe=True)
    assert mended.texts == {"<text>": text.replace("litress", "litres")}
    assert mended.report.findings == ()
