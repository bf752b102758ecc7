"""Queries of one shape share their code, and no text of a program gets into it."""

from __future__ import annotations

import re

from hypothesis import given
from hypothesis import strategies as st

from rapc.compiler.query.code import ResultMode, compile_source
from rapc.ir import nodes
from tests.effort import examples

from .dice import Dice, dice
from .memories import memories, query
from .test_queries import formula

WORDS = frozenset(
    re.findall(
        r"\S+",
        """def make ctx constants aliases aliased return query env if in not is None for
        and or else True False yield from continue try except as fault found append
        extend min key len type NUMBERS UNBOUND QueryFault str set_members as_value
        holds k v t f m b n facts table stamps values get index facts_at is_here young
        age functions view method_tried last_result accessible_items is_accessible
        count extended Exception error add_note raise no either rest v_ true false _
        TooManySteps most_steps steps_left give_up""",
    )
)
"""All that generated code consists of, besides numbers, signs and its own layout."""


def sources(formula: nodes.Formula, bound: tuple[str, ...] = ()) -> list[str]:
    """What is generated for a formula, for each way to end."""
    asked = query(formula)
    bound = tuple(name for name in asked.variables if name in bound)
    return [asked.variant(bound, ending).source for ending in ResultMode]


def test_constants_names_and_variables_do_not_tell_shapes_apart() -> None:
    one = formula("(and (q ?x 7) (color ?x red) (not (s ?x ?y 1)) (> ?z 3))")
    two = formula("(and (q ?b a) (heavy ?b true) (not (s ?b ?a 1)) (> ?c 0.5))")
    three = formula("(and (q ?x 7) (color red ?x) (not (s ?x ?y 1)) (> ?z 3))")
    assert sources(one, ("?z",)) == sources(two, ("?c",))
    assert sources(one, ("?z",)) != sources(three, ("?z",))
    assert sources(one, ("?z",)) != sources(one)
    for mine, other in zip(sources(one), sources(two), strict=True):
        assert compile_source(mine) is compile_source(other)


def test_the_order_of_variables_is_that_of_the_text() -> None:
    text = "(or (and (q {0} {1}) (s {2} {3} {4})) (q {5} {6}))"
    one, two = (
        [f"?{letter}" for letter in letters] for letters in ("abcdefg", "zvkxqwj")
    )
    first = sources(formula(text.format(*one)), tuple(one))
    assert first == sources(formula(text.format(*two)), tuple(two))


def test_a_shape_that_is_shared_keeps_the_constants_apart() -> None:
    both = memories([("assert", ("q", "a", 1)), ("assert", ("q", "b", 2))])
    first, second = (query(formula(f"(q ?x {n})")) for n in (1, 2))
    assert first.first(both.context, {}) == {"?x": "a"}
    assert second.first(both.context, {}) == {"?x": "b"}
    other = memories([("assert", ("q", "c", 2))])
    assert second.first(other.context, {}) == {"?x": "c"}
    assert first.first(other.context, {}) is None


@examples(300)
@given(dice(), st.integers(1, 9))
def test_no_text_of_a_program_gets_into_the_code(thrown: Dice, leaves: int) -> None:
    asked = thrown.formula(leaves)
    for source in sources(asked, tuple(thrown.env())):
        assert set(re.findall(r"[A-Za-z_]+", source)) <= WORDS
        assert set(re.findall(r"\d+", source)) <= {str(n) for n in range(200)}
        assert "?" not in source
