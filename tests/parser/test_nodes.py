"""Nodes are compared by what they say, not by where they stand."""

from __future__ import annotations

import operator

from rapc.base.source import Span
from rapc.ir.nodes import And, Const, Not, Truth, Var


def test_the_place_takes_no_part_in_comparison() -> None:
    here, there = Span("a.rap", 1, 2), Span("b.rap", 3, 4)
    one = And((Not(Truth(True, span=here), span=here),), span=here)
    two = And((Not(Truth(True, span=there), span=there),), span=there)
    assert one == two
    assert operator.ne(one, two) is False  # a method of its own
    assert hash(one) == hash(two)


def test_what_differs_is_not_equal() -> None:
    assert Const("x") != Const("y")
    assert Const("?x") != Var("?x")
    assert And(()) != And((Truth(True),))
    assert Const("x") != "x"
