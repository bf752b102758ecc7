"""Both spellings of a definition, and clauses in any order, give the same IR."""

from __future__ import annotations

import pytest

from tests.parser.reading import parsed

PAIRS = [
    ("(define-rap (index (a)))", "(define-rap (a))"),
    (
        "(define-rap (index (a ?x => ?y)) (succeed (p ?x)))",
        "(DEFINE-RAP (A ?X => ?Y) (SUCCEED (P ?X)))",
    ),
    (
        "(define-rap (succeed (p)) (index (a)))",
        "(define-rap (index (a))\n  ; a comment\n  (succeed (p)))",
    ),
    (
        "(define-rap (a) (succeed (p)) (duration 3) (method m (task-net)))",
        "(define-rap (a) (method m (task-net)) (duration 3.0) (succeed (p)))",
    ),
    (
        "(define-rap (a) (method m (context (p)) (task-net)))",
        "(define-rap (a) (method m (task-net) (context (p))))",
    ),
    (
        "(define-rap (a) (succeed (know-sensor-name ?x)))",
        "(define-rap (a) (succeed (know-sensor-name ?x true)))",
    ),
    (
        "(define-rap (a) (method (task-net (t (b) (wait-for (:s))))))",
        "(define-rap (a) (method (task-net (t 0 (b) (wait-for (:s) :proceed)))))",
    ),
]


@pytest.mark.parametrize(("one", "other"), PAIRS)
def test_two_spellings_are_equal(one: str, other: str) -> None:
    first, second = parsed(one), parsed(other)
    assert first.diagnostics == second.diagnostics == ()
    assert first.forms == second.forms
    assert [hash(form) for form in first.forms] == [hash(f) for f in second.forms]


def test_what_differs_is_not_equal() -> None:
    assert parsed("(define-rap (a))").forms != parsed("(define-rap (b))").forms


def test_methods_are_counted_as_they_stand() -> None:
    (rap,) = parsed("(define-rap (a) (method (task-net)) (method b (task-net)))").forms
    methods = getattr(rap, "methods", ())
    assert [(m.name, m.position) for m in methods] == [(None, 1), ("b", 2)]
