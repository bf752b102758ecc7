"""Nodes: how they are compared, which rules they are written by, what limits them."""

from __future__ import annotations

import operator
import re
from pathlib import Path
from typing import get_args, get_type_hints

import pytest

import rapc
from rapc.base.source import Span
from rapc.ir.nodes import And, Const, Node, Not, Truth, Var
from rapc.ir.schema import NAMED_BY, kind_of_rule
from rapc.language.grammar import RULES


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


@pytest.mark.parametrize("kind", NAMED_BY)
def test_words_that_name_nodes_are_rules(kind: type[Node]) -> None:
    words = get_args(get_type_hints(kind)[NAMED_BY[kind]])
    rules = [word.replace("-", "_") for word in words]
    assert {*rules} <= RULES.keys()
    assert {kind_of_rule(rule) for rule in rules} == {kind}


def test_limits_of_texts_stand_in_one_module() -> None:
    own = re.compile(r"^_?(?:MAX|MOST|LARGEST|LONGEST)\w* = ", re.M)
    found = [
        file
        for package in ("base", "language", "ir", "parser", "library")
        for file in (Path(rapc.__file__).parent / package).rglob("*.py")
        if own.search(file.read_text(encoding="utf-8"))
    ]
    assert [file.name for file in found] == ["limits.py"]
