"""Walks over the IR come upon everything, in the order of the text."""

from __future__ import annotations

from rapc.ir import nodes, walk
from rapc.ir.printer import format_formula, format_term
from rapc.ir.schema import Operands, operands
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
        (at.clause.word, at.method and at.method.position, at.step and at.step.tag)
        for at in walk.formulas(_rap())
    ]
    assert places == [
        ("succeed", None, None),
        ("constraints", None, None),
        ("repeat-while", None, None),
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


def test_terms_in_formulas() -> None:
    found = [
        format_term(term)
        for place in walk.formulas(_rap())
        for term in walk.terms(place.formula)
    ]
    assert found == [
        *("?x", "?y", "(+ ?y 1)", "?n", "?z", "?x", "?x", "3"),
        *("?set", "?x", "?x", "?x", "true"),
    ]


def test_what_becomes_of_variables_is_said_by_the_fields() -> None:
    """Those of a known class and place are asked; their number is handed out."""
    kind, place, number = (nodes.Var(name) for name in ("?c", "?p", "?n"))
    count = nodes.Count(kind, place, number)
    assert operands(count) == Operands(used=(kind, place), matched=(number,))
    assert operands(nodes.Not(count)) == Operands(closed=(count,))
    assert operands(nodes.And((count, count))) == Operands(parts=(count, count))


def test_a_result_may_be_asked_for_and_a_method_is_named() -> None:
    method, result = nodes.Const("lift"), nodes.Var("?r")
    asked = nodes.HistoryTest("result-with-method", (method, result))
    assert operands(asked) == Operands(used=(method,), matched=(result,))
    tried = nodes.HistoryTest("method-tried", (method,))
    assert operands(tried) == Operands(used=(method,))


def test_an_item_out_of_sight_has_to_be_named() -> None:
    item = nodes.Var("?x")
    seen, unseen = nodes.Const("true"), nodes.Const("false")
    assert operands(nodes.SensorName(item, seen)).matched == (item, seen)
    assert operands(nodes.SensorName(item, unseen)) == Operands(used=(item,))
