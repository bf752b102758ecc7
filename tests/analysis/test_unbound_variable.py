"""Labels and help of `unbound-variable`: why a place does not bind, and what to do."""

from __future__ import annotations

import pytest

from rapc.analysis.driver import check_library
from rapc.base.diagnostics import Applicability
from rapc.library.loader import load_text

WORDS = """
(declare-event :seen (?what))
(declare-event :bell ())
(declare-memory-property size (?what ?size) unknown)
(declare-primitive walk () (okay) :atomic false)
(declare-primitive say (?what) (okay))
(define-rap (stroll) (method (primitive (walk))))
(define-rap (find => ?what) (succeed (size ?what big)) (method (primitive (walk))))
(define-rap (stand-guard)
  (succeed nil)
  (monitor-time now 5 9)
  (method (primitive (walk))))
(define-rap (tell ?what) (method (primitive (say ?what))))
"""


def net(first: str) -> str:
    """A method with a step before, or beside, one that needs `?what`."""
    return f"(task-net (t1 {first}) (t2 (tell ?what)))"


@pytest.mark.parametrize(
    ("body", "label", "advice"),
    [
        (
            net("(stroll) (wait-for (:seen ?what) :succeed) (for t2)"),
            "bound by a signal that ends step `t1`, but the step may end without it",
            "end `stroll` only by a signal, as with `(succeed nil)`, or "
            "return `?what` as an output",
        ),
        (
            net("(stroll) (wait-for (:seen ?what) :succeed)"),
            "bound by a signal that ends step `t1`, which is not ordered "
            "before this step",
            "add `(for t2)` to step `t1`, and end `stroll` only by a "
            "signal, as with `(succeed nil)`, or return `?what` as an "
            "output",
        ),
        (
            net("(stand-guard) (wait-for (:seen ?what) :succeed)"),
            "bound by a signal that ends step `t1`, which is not ordered "
            "before this step",
            "add `(for t2)` to step `t1`",
        ),
        (
            net(
                "(stand-guard) (wait-for (:seen ?what) :succeed) "
                "(wait-for (:bell) :succeed) (for t2)"
            ),
            "bound by a signal that ends step `t1`, but the step may end without it",
            "bind `?what` in each signal that ends step `t1`",
        ),
        (
            net("(stroll) (wait-for (:seen ?what) :fail) (for t2)"),
            "bound by a signal that fails step `t1`",
            "bind the variable in `context`, or in a step ordered before this step",
        ),
        (
            net("(find => ?what) (wait-for (:bell) :succeed) (for t2)"),
            "bound by step `t1`, which a signal may end before",
            "bind the variable in `context`, or in a step ordered before this step",
        ),
        (
            "(task-net (t1 (tell ?what) (wait-for (:seen ?what) :succeed)))",
            "bound by a signal that ends step `t1`",
            "with `:proceed`, the signal comes before the step begins",
        ),
        (
            "(context (and (< ?size 3) (size box ?size))) (task-net (t1 (tell ?size)))",
            "bound here, but evaluated after the use: parts are evaluated "
            "from left to right",
            "move the part that binds the variable to the left",
        ),
        (
            net("(find => ?what) ((and (< ?size 3) (size ?what ?size)) for t2)"),
            "bound here, but evaluated after the use: parts are evaluated "
            "from left to right",
            "move the part that binds the variable to the left",
        ),
    ],
)
def test_unbound_variable_states_cause_and_remedy(
    body: str, label: str, advice: str
) -> None:
    text = f"{WORDS}(define-rap (all) (method {body}))"
    [found] = [one.diagnostic for one in check_library(load_text(text)).findings]
    assert found.rule == "unbound-variable"
    assert [one.message for one in found.labels] == [label]
    assert found.help == advice


@pytest.mark.parametrize(
    ("written", "mended"),
    [
        ("(= ?next (+ ?size 1))", "(is ?next (+ ?size 1))"),
        ("(= (+ ?size 1) ?next)", "(is ?next (+ ?size 1))"),
    ],
)
def test_equal_sign_with_unbound_side_becomes_is(written: str, mended: str) -> None:
    body = f"(context (and (size box ?size) {written})) (task-net (t1 (tell ?next)))"
    text = f"{WORDS}(define-rap (all) (method {body}))"
    [found] = [one.diagnostic for one in check_library(load_text(text)).findings]
    assert (
        found.help
        == "`=` binds nothing; `(is ?next ...)` binds the variable to the value"
    )
    assert found.fix is not None
    assert found.fix.applicability is Applicability.UNSAFE
    for edit in sorted(found.fix.edits, key=lambda e: -e.span.start):
        text = text[: edit.span.start] + edit.content + text[edit.span.end :]
    assert mended in text
    assert not check_library(load_text(text)).findings
