"""Labels and help of `unbound-variable`: why a place does not bind, and what to do."""

from __future__ import annotations

import pytest

from rapc.analysis.driver import check_library
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
            "bound by a signal that ends step `t1`, which may end without it",
            "let only a signal end `stroll`, as with `(succeed nil)`, or let it hand "
            "out `?what`",
        ),
        (
            net("(stroll) (wait-for (:seen ?what) :succeed)"),
            "bound by a signal that ends step `t1`, which nothing puts before this one",
            "put `(for t2)` on step `t1`, and let only a signal end `stroll`, as with "
            "`(succeed nil)`, or let it hand out `?what`",
        ),
        (
            net("(stand-guard) (wait-for (:seen ?what) :succeed)"),
            "bound by a signal that ends step `t1`, which nothing puts before this one",
            "put `(for t2)` on step `t1`",
        ),
        (
            net(
                "(stand-guard) (wait-for (:seen ?what) :succeed) "
                "(wait-for (:bell) :succeed) (for t2)"
            ),
            "bound by a signal that ends step `t1`, which may end without it",
            "let each signal that ends step `t1` bind `?what`",
        ),
        (
            net("(stroll) (wait-for (:seen ?what) :fail) (for t2)"),
            "bound by a signal that fails step `t1`",
            "bind it in `context`, or in a step ordered before this one",
        ),
        (
            net("(find => ?what) (wait-for (:bell) :succeed) (for t2)"),
            "bound by step `t1`, which a signal may end before that",
            "bind it in `context`, or in a step ordered before this one",
        ),
        (
            "(task-net (t1 (tell ?what) (wait-for (:seen ?what) :succeed)))",
            "bound by a signal that ends step `t1`",
            "with `:proceed` the signal comes before the step begins",
        ),
        (
            "(context (and (< ?size 3) (size box ?size))) (task-net (t1 (tell ?size)))",
            "bound here, but asked only after that: parts go from left to right",
            "put the part that binds it to the left of this",
        ),
        (
            net("(find => ?what) ((and (< ?size 3) (size ?what ?size)) for t2)"),
            "bound here, but asked only after that: parts go from left to right",
            "put the part that binds it to the left of this",
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
