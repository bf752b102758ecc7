"""Compiled queries give the answers of the plain reference, in its order."""

from __future__ import annotations

from itertools import islice
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from rapc.base.resources import Value
from rapc.compiler.query.code import ResultMode
from rapc.compiler.query.query import Query
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from tests.effort import examples

from .dice import Case, Dice, dice, sizes
from .memories import Memories, apply, memories, query
from .reference import solutions

ENOUGH = 60


def agree(case: Case, formula: nodes.Formula) -> None:
    """Ask both, and compare all answers, and the first one or whether there is any."""
    both = memories(case.changes)
    asked = query(formula)
    found = list(islice(asked.solutions(both.context, case.env), ENOUGH))
    plain = islice(solutions(both.mind, case.env, formula), ENOUGH)
    wanted = [{n: v for n, v in one.items() if n not in case.env} for one in plain]
    assert found == wanted, f"{format_formula(formula)} in {both.mind}"
    first = wanted[0] if wanted else None
    if len(case.changes) % 2:  # each way to ask is code of its own: take turns
        assert asked.first(both.context, case.env) == first
        assert one_by_one(both, asked, case.env, ResultMode.ANY) is bool(wanted)
    else:
        assert asked.holds(both.context, case.env) is bool(wanted)
        assert one_by_one(both, asked, case.env, ResultMode.FIRST) == first


def one_by_one(
    both: Memories, asked: Query, env: dict[str, Value], ending: ResultMode
) -> Any:
    """What a query says that is given its values one by one, as a host's is."""
    names = tuple(name for name in reversed(asked.variables) if name in env)
    ask = asked.variant(names, ending, by_place=True).bind(both.context, {})
    return ask(*[env[name] for name in names])


@examples(300)
@given(dice(), sizes, st.integers(1, 5))
def test_answers_follow_a_memory_that_changes(
    thrown: Dice, size: int, leaves: int
) -> None:
    both, env = memories(thrown.changes(size)), thrown.env()
    formula = nodes.And((thrown.pattern(), thrown.formula(leaves)))
    asked = query(formula)
    for _ in range(8):
        plain = [*islice(solutions(both.mind, env, formula), ENOUGH + 1)]
        if len(plain) <= ENOUGH:
            wanted = [{n: v for n, v in s.items() if n not in env} for s in plain]
            assert one_by_one(both, asked, env, ResultMode.ALL) == wanted
        apply(both, thrown.change())


@examples(1500)
@given(dice(), sizes, st.integers(1, 9))
def test_any_formula(thrown: Dice, size: int, leaves: int) -> None:
    case = Case(thrown.changes(size), [thrown.formula(leaves)], thrown.env())
    agree(case, case.parts[0])


@examples(1000)
@given(dice(), sizes, st.integers(1, 3), st.integers(1, 3))
def test_variables_bound_in_one_branch_only(
    thrown: Dice, size: int, branches: int, users: int
) -> None:
    changes = thrown.changes(size)
    some = [thrown.formula(2) for _ in range(branches)]
    either = nodes.Or((*some, nodes.Truth(True)))
    then = [thrown.simple() for _ in range(users)]
    agree(Case(changes, [], thrown.env()), nodes.And((either, *then)))


@examples(200)
@given(dice(), sizes, st.integers(13, 18))
def test_more_conjuncts_than_python_has_blocks(
    thrown: Dice, size: int, parts: int
) -> None:
    changes = thrown.changes(size)
    formula = nodes.And(tuple(thrown.pattern() for _ in range(parts)))
    agree(Case(changes, [], thrown.env()), formula)
