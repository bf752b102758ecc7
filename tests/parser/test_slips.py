"""Slips that have been printed: each says what was meant and, if certain, mends it."""

from __future__ import annotations

import pytest

from rapc.base.diagnostics import Applicability
from rapc.parser.rules.table import RULES
from tests.parser.reading import fixed, only, parsed, rules

SAFE, UNSAFE = Applicability.SAFE, Applicability.UNSAFE

SLIPS = [
    (
        "(declare-memory-proposition at (robot ?place))",
        "expected a variable, not `robot`",
        SAFE,
        "(declare-memory-proposition at (?robot ?place))",
    ),
    (
        "(define-rap (index (go place)))",
        "expected a variable, not `place`",
        SAFE,
        "(define-rap (index (go ?place)))",
    ),
    (
        "(define-rap (a) (SUCCESS (p)))",
        "unknown clause `success` of `define-rap`",
        SAFE,
        "(define-rap (a) (succeed (p)))",
    ),
    (
        "(define-rap (a) (CONSTRAINT (p)))",
        "unknown clause `constraint` of `define-rap`",
        SAFE,
        "(define-rap (a) (constraints (p)))",
    ),
    (
        "(define-rap (a ?n) (method (task-net (t1 (b) (COUNTER-DEL ?n 1)))))",
        "unknown annotation `counter-del`",
        SAFE,
        "(define-rap (a ?n) (method (task-net (t1 (b) (counter-sub ?n 1)))))",
    ),
    (
        "(define-rap (a) (monitor-time (now 10 15)))",
        "the times of `monitor-time` must not have parentheses",
        SAFE,
        "(define-rap (a) (monitor-time now 10 15))",
    ),
    (
        "(define-rap (a) (method (task-net (t1 (b) ((f) (for t2))) (t2 (c)))))",
        "`for` after a formula must not have its own parentheses",
        SAFE,
        "(define-rap (a) (method (task-net (t1 (b) ((f) for t2)) (t2 (c)))))",
    ),
    (
        "(define-rap (a) (method (task-net (t1 (b) FOR t2) (t2 (c)))))",
        "`for` and its tag require parentheses",
        SAFE,
        "(define-rap (a) (method (task-net (t1 (b) (FOR t2)) (t2 (c)))))",
    ),
    (
        "(define-rap (a) (method (task-net (t1 (b) (f) for t2) (t2 (c)))))",
        "`for` and its tag require parentheses",
        SAFE,
        "(define-rap (a) (method (task-net (t1 (b) ((f) for t2)) (t2 (c)))))",
    ),
    (
        "(define-rap (a) (succeed (not (p) (q))))",
        "`not` takes one formula, not 2",
        UNSAFE,
        "(define-rap (a) (succeed (not (and (p) (q)))))",
    ),
    (
        "(define-rap (a) (succeed (believe (p))))",
        "`believe` requires an age",
        UNSAFE,
        "(define-rap (a) (succeed (believe (p) ?age)))",
    ),
    (
        "(define-event-rule (:e) (rule (q) (mem-add (p)) (mem-del (r))))",
        "the query and the actions of a rule require parentheses",
        SAFE,
        "(define-event-rule (:e) (rule ((q) (mem-add (p)) (mem-del (r)))))",
    ),
    (
        "(define-rap (a) (succeed (p 'x)))",
        "unexpected `'`",
        SAFE,
        "(define-rap (a) (succeed (p x)))",
    ),
    (
        "(declare-class-comparator rock #'by-size)",
        "unexpected `#'`",
        SAFE,
        "(declare-class-comparator rock by-size)",
    ),
    (
        "(define-rap (a) (succeed [p x]))",
        "unexpected `[`",
        UNSAFE,
        "(define-rap (a) (succeed (p x)))",
    ),
    (
        "(define-rap\u00a0(a))",
        "unexpected character U+00A0",
        SAFE,
        "(define-rap (a))",
    ),
    (
        "(require \u201ctruck\u201d)",
        "unexpected `\u201c`",
        UNSAFE,
        '(require "truck")',
    ),
    (
        "(define-rap (index a ?x => ?y))",
        "the index requires its own parentheses",
        SAFE,
        "(define-rap (index (a ?x => ?y)))",
    ),
    (
        "(require truck)",
        "expected a string after `require`, not a symbol",
        SAFE,
        '(require "truck")',
    ),
]
NAMES = [slip[0] for slip in SLIPS]


@pytest.mark.parametrize(("text", "message", "sure", "meant"), SLIPS, ids=NAMES)
def test_slip_says_what_was_meant_and_mends_it(
    text: str, message: str, sure: Applicability, meant: str
) -> None:
    first = parsed(text).diagnostics[0]
    assert (first.message, first.fix and first.fix.applicability) == (message, sure)
    assert fixed(text) == meant
    assert rules(meant) == []


def test_two_methods_of_one_name() -> None:
    found = only("(define-rap (a) (method 2 (task-net)) (method 2 (task-net)))")
    assert found.message == "duplicate method name `2`"
    assert [label.message for label in found.labels] == ["the first is here"]


@pytest.mark.parametrize("rule", RULES, ids=[rule.name for rule in RULES])
def test_safe_fix_of_an_example_leaves_nothing_to_find(rule: object) -> None:
    (example,) = (one.page.example for one in RULES if one is rule)
    fix = only(example).fix
    if fix is not None and fix.applicability is SAFE:
        assert rules(fixed(example)) == []


def test_slip_whose_meaning_is_clear_leaves_nothing_out() -> None:
    slip = parsed("(define-rap (a) (success (p)))")
    sound = parsed("(define-rap (a) (succeed (p)))")
    assert not slip.partial
    assert slip.forms == sound.forms


def test_what_is_left_out_is_told() -> None:
    lost = parsed("(define-rap (a) (succeed p))")
    (form,) = lost.forms
    assert [one.form for one in lost.partial] == [form]


SUGGESTIONS = [
    ("(define-rapp (a))", "did you mean `define-rap`?"),
    ("(define-rap (a) (sucess (p)))", "did you mean `succeed`?"),
    ("(define-rap (a) (preconditoins (p)))", "did you mean `preconditions`?"),
    ("(define-rap (a) (method (contxt (p)) (task-net)))", "did you mean `context`?"),
    (
        "(define-rap (a) (method (task-net (t1 (b) (until-ended t1)))))",
        "did you mean `until-end`?",
    ),
    ("(define-test a (expect (succeds (b))))", "did you mean `succeeds`?"),
    ("(define-test a (expect (succeed (b))))", "did you mean `succeeds`?"),
    ("(declare-memory-function f () :read (p))", "did you mean `:reads`?"),
]


@pytest.mark.parametrize(("text", "help"), SUGGESTIONS)
def test_unknown_word_gets_a_suggestion(text: str, help: str) -> None:
    assert only(text).help == help


def test_clause_swallowed_by_another_is_told() -> None:
    found = only("(define-rap (a) (succeed (p) (method (task-net))))")
    assert found.help == "a `)` may be missing before `(method`"


@pytest.mark.parametrize("row", ["(enable)", "(disable)", "(enable look)"])
def test_a_row_of_a_script_switches_one_skill(row: str) -> None:
    found = only(f"(define-test t (script ({row} okay)) (task (go)))")
    assert (found.rule, found.message) == (
        "malformed-clause",
        "expected one skill",
    )


def test_a_rap_with_kinds_of_inputs_may_be_called_almost_as_a_clause() -> None:
    text = "(define-rap (succeeds (?thing item)) (succeed (held ?thing)))"
    assert parsed(text).diagnostics == ()
