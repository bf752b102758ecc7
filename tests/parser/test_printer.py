"""What the printer writes reads back as what was printed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rapc.base.source import SourceFile
from rapc.base.values import Text, number
from rapc.ir import nodes
from rapc.ir.printer import format_formula, format_goal, format_term
from rapc.parser.context import Context
from rapc.parser.reader import read
from rapc.parser.special.formulas import formula
from rapc.parser.special.table import readers
from rapc.parser.syntax import Datum
from rapc.parser.terms import goal, term
from tests.effort import examples

NAMES = st.sampled_from(["p", "arm-at", "#1", "x2", "..."])
NUMBERS = st.one_of(
    st.integers(-(10**12), 10**12),
    st.floats(-1e12, 1e12, allow_subnormal=False).map(lambda x: number(round(x, 6))),
)
ATOMS = st.one_of(NAMES, NUMBERS, st.text(max_size=8).map(Text), st.just(":kw"))
TERMS: st.SearchStrategy[nodes.Term] = st.recursive(
    st.one_of(
        ATOMS.map(nodes.Const), st.sampled_from(["?", "?x", "?y"]).map(nodes.Var)
    ),
    lambda inner: st.builds(
        nodes.Call, st.just("f"), st.lists(inner, max_size=3).map(tuple)
    ),
    max_leaves=6,
)
ARGS = st.lists(TERMS, max_size=3).map(tuple)
PATTERNS = st.builds(nodes.Proposition, NAMES, ARGS)
KNOWN = st.one_of(
    st.sampled_from(["true", "false"]).map(nodes.Const), st.just(nodes.Var("?y"))
)
OPS = st.sampled_from(["=", "n=", "<", ">", "<=", ">="])
LEAVES = st.one_of(
    PATTERNS,
    st.booleans().map(nodes.Truth),
    st.just(nodes.Otherwise()),
    st.builds(nodes.Compare, OPS, TERMS, TERMS),
    st.builds(nodes.Believe, PATTERNS, TERMS),
    st.builds(nodes.SetTest, st.just("member"), st.tuples(TERMS, TERMS).map(tuple)),
    st.builds(nodes.SetTest, st.just("empty"), st.tuples(TERMS).map(tuple)),
    st.builds(nodes.HistoryTest, st.just("last-result"), st.tuples(TERMS).map(tuple)),
    st.builds(nodes.SensorName, TERMS, KNOWN),
    st.builds(nodes.Count, TERMS, TERMS, TERMS),
)
FORMULAS: st.SearchStrategy[nodes.Formula] = st.recursive(
    LEAVES,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3).map(tuple).map(nodes.And),
        st.lists(inner, max_size=3).map(tuple).map(nodes.Or),
        inner.map(nodes.Not),
    ),
    max_leaves=8,
)
GOALS = st.builds(nodes.Goal, NAMES, ARGS, st.just(()))


def _datum(text: str) -> tuple[Context, Datum]:
    source = SourceFile("printed", text)
    found = read(source)
    assert found.diagnostics == ()
    (top,) = found.forms
    return Context(source, 10, readers()), top.datum


@examples(300)
@given(TERMS)
def test_terms_read_back(made: nodes.Term) -> None:
    ctx, datum = _datum(format_term(made))
    assert term(ctx, datum) == made
    assert ctx.diagnostics == []


@examples(300)
@given(FORMULAS)
def test_formulas_read_back(made: nodes.Formula) -> None:
    ctx, datum = _datum(format_formula(made))
    assert formula(ctx, datum) == made
    assert ctx.diagnostics == []


@given(GOALS)
def test_goals_read_back(made: nodes.Goal) -> None:
    ctx, datum = _datum(format_goal(made))
    assert goal(ctx, datum) == made


def test_outputs_stand_behind_an_arrow() -> None:
    made = nodes.Goal("find", (nodes.Const("box"),), (nodes.Var("?place"),))
    assert format_goal(made) == "(find box => ?place)"


class Counter:
    """Stands for a resource: something that writes itself."""

    def __str__(self) -> str:
        return "#counter(3)"


BOUND = [
    ("(p ?x ?y)", {"?x": "box"}, "(p box ?y)"),
    ("(p ?x)", {"?x": Text("A b")}, '(p "A b")'),
    ("(and (p ?x) (not (q ?x)))", {"?x": 2}, "(and (p 2) (not (q 2)))"),
    ("(< (+ ?x 1) ?y)", {"?x": 2.5}, "(< (+ 2.5 1) ?y)"),
    ("(member ?s ?)", {"?s": Counter()}, "(member #counter(3) ?)"),
    ("(believe (p ?x) ?n)", {"?x": "a", "?n": 3}, "(believe (p a) 3)"),
]


@pytest.mark.parametrize(("text", "bindings", "shown"), BOUND)
def test_what_is_bound_is_put_in(
    text: str, bindings: dict[str, object], shown: str
) -> None:
    made = formula(*_datum(text))
    assert made is not None
    assert format_formula(made, bindings) == shown
