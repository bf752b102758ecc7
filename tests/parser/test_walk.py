"""Walks over the IR come upon everything, in the order of the text."""

from __future__ import annotations

from rapc.ir import nodes, walk
from rapc.ir.printer import format_formula, format_term
from tests.parser.reading import parsed

RAP = """\
(define-rap (a ?x)
  (constraints (c ?x))
  (succeed (and (p ?x ?y) (or (q (+ ?y 1)) (not (believe (r ?z) ?n)))))
  (repeat-while (< ?x 3))
  (method m
    (context (member ?set ?x))
    (task-net (t1 (b) ((d ?x) for t2) (for t2)) (t2 (b))))
  (method (context (know-sensor-name ?x)) (primitive (go))))
"""


def _rap() -> nodes.DefineRap:
    (form,) = parsed(RAP).forms
    assert isinstance(form, nodes.DefineRap)
    return form


def test_formulas_with_their_places() -> None:
    places = [
        (at.clause, at.method and at.method.position, at.step and at.step.tag)
        for at in walk.formulas(_rap())
    ]
    assert places == [
        ("repeat-while", None, None),
        ("succeed", None, None),
        ("constraints", None, None),
        ("context", 1, None),
        ("for", 1, "t1"),
        ("context", 2, None),
    ]


def test_formulas_within_a_formula() -> None:
    succeed = _rap().succeed
    assert succeed is not None
    inner = [format_formula(part) for part in walk.subformulas(succeed)]
    assert inner[1:] == [
        "(p ?x ?y)",
        "(or (q (+ ?y 1)) (not (believe (r ?z) ?n)))",
        "(q (+ ?y 1))",
        "(not (believe (r ?z) ?n))",
        "(believe (r ?z) ?n)",
        "(r ?z)",
    ]


def test_terms_with_their_roles() -> None:
    found = [
        (format_term(at.term), at.role)
        for place in walk.formulas(_rap())
        for at in walk.terms(place.formula)
    ]
    assert found == [
        ("?x", "use"),
        ("3", "use"),
        ("?x", "match"),
        ("?y", "match"),
        ("(+ ?y 1)", "use"),
        ("?n", "match"),
        ("?z", "match"),
        ("?x", "match"),
        ("?set", "use"),
        ("?x", "use"),
        ("?x", "match"),
        ("?x", "match"),
        ("true", "match"),
    ]


def test_variables_in_computed_terms_are_used() -> None:
    succeed = _rap().succeed
    assert succeed is not None
    roles = [(var.name, role) for var, role in walk.variables(succeed)]
    assert roles == [
        ("?x", "match"),
        ("?y", "match"),
        ("?y", "use"),
        ("?n", "match"),
        ("?z", "match"),
    ]
