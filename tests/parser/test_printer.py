"""What the printer writes reads back as what was printed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rapc.base.source import SourceFile
from rapc.base.values import Text, number
from rapc.ir import nodes
from rapc.ir.layout import laid_out, lines
from rapc.ir.printer import format_formula, format_goal, format_node, format_term
from rapc.parser.context import Context
from rapc.parser.reader import read
from rapc.parser.special.formulas import formula
from rapc.parser.special.table import readers
from rapc.parser.syntax import Datum
from rapc.parser.terms import goal, term
from tests.effort import examples
from tests.parser.reading import parsed

NAMES = st.sampled_from(["p", "arm-at", "#1", "x2", "..."])
NUMBERS = st.one_of(
    st.integers(-(10**12), 10**12),
    st.floats(-1e12, 1e12, allow_subnormal=False).map(lambda x: number(round(x, 6))),
)
ATOMS = st.one_of(NAMES, NUMBERS, st.text(max_size=8).map(Text), st.just(":kw"))
VARIABLES = st.sampled_from(["?", "?x", "?y"]).map(nodes.Var)
TERMS: st.SearchStrategy[nodes.Term] = st.recursive(
    st.one_of(ATOMS.map(nodes.Const), VARIABLES),
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
    st.builds(nodes.Is, VARIABLES, TERMS),
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


# --- whole definitions ---------------------------------------------------------------


def test_methods_are_written_as_rap_text() -> None:
    """A method that a problem solver has made, say."""
    step = nodes.Step("t1", 0, nodes.Goal("go", (nodes.Const("hall"),), ()), ())
    context = nodes.Proposition("at", (nodes.Var("?here"),))
    made = nodes.Method("walk", 1, context, (), nodes.TaskNet((step,)))
    text = "(method walk (context (at ?here)) (task-net (t1 (go hall))))"
    assert format_node(made) == text
    (rap,) = parsed(f"(define-rap (move) {text})").forms
    assert isinstance(rap, nodes.DefineRap)
    assert rap.methods == (made,)


LAID_OUT = """\
(define-rap (stow-fuel-reserve (?kind symbol) => ?drum)
  (succeed (and (location ?drum bay1)
                (class ?drum ?kind true)))
  (repeat-while (and (location ?other external)
                     (not (quantity-held ?other 0))
                     (n= ?other ?drum)))
  (method look
    (context otherwise)
    (claims wheels)
    (task-net
      (t1 2 (eye-examine ?drum) ((location ?drum bay1) for t2) (for t2))
      (t2 (move-thing-to ?drum bay1)))))
"""

TEST_LAID_OUT = """\
(define-test a-door-is-opened
  "It is pushed
   twice."
  (facts (door-state hall shut))
  (script
    ((push ?door) okay :takes 2 :asserts ((door-state ?door open)))
    ((look-at ?door) okay
     :asserts ((door-state ?door shut) (seen ?door at-this-very-moment))
     :erases ((seen ?door))))
  (task (open-door hall) :priority 2)
  (expect
    (succeeds (open-door hall))
    (primitives (push hall) (push hall) (look-at hall) (push hall) (look-at hall) (g))))
"""


@pytest.mark.parametrize("text", [LAID_OUT, TEST_LAID_OUT])
def test_definitions_are_laid_out(text: str) -> None:
    unit = parsed(text)
    assert unit.diagnostics == ()
    form = [*unit.forms, *unit.tests][0]
    assert f"{laid_out(form)}\n" == text


def test_strings_that_a_task_hands_out_read_back() -> None:
    text = '(define-test said (expect (succeeds (say) "a word" b)))'
    (test,) = parsed(text).tests
    (found,) = test.expectations
    assert isinstance(found, nodes.Succeeds)
    assert found.outputs == (nodes.Const(Text("a word")), nodes.Const("b"))
    assert format_node(test) == text


def test_narrow_lines_break_what_they_can() -> None:
    made = formula(*_datum("(and (p ?x) (not (q ?x)) (> (+ ?x 1) 3))"))
    assert made is not None
    assert (
        laid_out(made, 12)
        == "(and (p ?x)\n     (not (q ?x))\n     (> (+ ?x\n           1)\n        3))"
    )


def test_parentheses_behind_a_list_count_for_its_line() -> None:
    made = formula(*_datum("(not (p ?long ?row))"))
    assert made is not None
    assert laid_out(made, 20) == "(not (p ?long ?row))"
    assert laid_out(made, 19) == "(not (p ?long\n        ?row))"


def test_a_tree_of_nothing_is_an_empty_list() -> None:
    assert lines(()) == "()"
