"""What is told to those who reach for the words of other languages."""

from __future__ import annotations

import pytest

from rapc.analysis.driver import check_library
from rapc.library.loader import load_text

WORDS = """
(declare-primitive drive (?room) (okay))
(declare-memory-proposition free (?room))
(define-rap (go-to ?room) (succeed (free ?room)) (method (primitive (drive ?room))))
"""


def told(text: str) -> list[tuple[str, str]]:
    """The rules and the advice of what is found in a text behind `WORDS`."""
    return [
        (finding.rule.name, finding.diagnostic.help)
        for finding in check_library(load_text(WORDS + text)).findings
    ]


def step(text: str) -> str:
    """A RAP whose method has this step."""
    return f"(define-rap (visit ?room) (method (task-net {text})))"


def context(text: str) -> str:
    """A RAP whose method has this context."""
    return (
        f"(define-rap (visit ?room) (method (context {text}) (task-net "
        "(t1 (go-to ?room)))))"
    )


@pytest.mark.parametrize(
    ("text", "rule", "advice"),
    [
        (
            step("(t1 (drive ?room))"),
            "unknown-rap",
            "`drive` is a primitive, not a RAP; define a RAP with the "
            "method `(primitive (drive ...))`",
        ),
        (
            "(define-rap (visit ?room) (method (primitive (go-to ?room))))",
            "undeclared-primitive",
            "`go-to` is a RAP; call the RAP in a step: `(task-net (t1 (go-to ...)))`",
        ),
        (
            step("(t1 (wait-for ?room))"),
            "unknown-rap",
            "add it to a step with a task: `(t1 (TASK) (wait-for (:event)))`",
        ),
        (context("(!= ?room hall)"), "undeclared-predicate", "write `n=`"),
        (context("(<> ?room hall)"), "undeclared-predicate", "write `n=`"),
        (context("(== ?room hall)"), "undeclared-predicate", "write `=`"),
        (
            step("(go-to ?room)"),
            "malformed-step",
            "begin the step with a unique tag: `(t1 (go-to ?room))`",
        ),
        (
            step("(t1 (go-to ?room) (priority 3))"),
            "unknown-annotation",
            "write a priority as a number after the tag: `(t1 2 (rap args...))`",
        ),
        (
            step("(t1 (go-to ?room)) (t2 (go-to hall) (after t1))"),
            "unknown-annotation",
            "write the order in the earlier step: `(for t1)`",
        ),
        (
            step("(t1 (go-to ?room) (timeout 30))"),
            "unknown-annotation",
            "write the end time as a second step with `(window now 30 30)` "
            "and `until-end`",
        ),
        (
            "(define-test t (expect (method go-to 1)))",
            "unknown-method",
            "did you mean `#1`?",
        ),
        (
            "(define-test t (task (go-to hall) :at 130) (until 200))",
            "unknown-clause",
            "a task that begins later is written in an `at`: `(at 130 (task ...))`",
        ),
        (
            "(declare-primitive leave () (okay) :on (okay (may (not (free hall)))))",
            "malformed-proposition",
            "write `(may (free hall))`: the fact may be asserted or erased",
        ),
        (
            "(declare-primitive leave () (okay) :on (okay (may (and (free hall)))))",
            "malformed-proposition",
            "expected a plain proposition",
        ),
        (
            "(declare-memory-property count-of (?room ?number) ?n)",
            "malformed-form",
            "write `unknown`, another symbol, a number or the name of a declared "
            "function",
        ),
        (
            "//",
            "unknown-form",
            "a form is a list that begins with a word such as `define-rap`; a comment "
            "begins with `;`",
        ),
    ],
)
def test_advice_is_in_the_words_of_the_language(
    text: str, rule: str, advice: str
) -> None:
    assert told(text) == [(rule, advice)]


def test_what_is_no_annotation_at_all_is_told_all_there_are() -> None:
    [(rule, advice)] = told(step("(t1 (go-to ?room) (retry 3))"))
    assert rule == "unknown-annotation"
    for word in ("for", "until-start", "until-end", "window", "wait-for", "set-add"):
        assert f"`{word}`" in advice
