"""What formulas say taken apart: conjunctions as rows of literals.

A literal is a formula that is to hold, or that is to have no solution. Which literals
cannot hold together is told by `rapc.analysis.conjunction`, which follow from others by
`rapc.analysis.following`; both say yes only where that is certain.
"""

from __future__ import annotations

from collections.abc import Container, Iterator

import msgspec

from rapc.base.source import Span
from rapc.base.values import Number
from rapc.ir import nodes
from rapc.ir.walk import substitute, variable_names


class Literal(msgspec.Struct, frozen=True):
    """A formula that is to hold, or to have no solution."""

    formula: nodes.Formula
    holds: bool

    @property
    def span(self) -> Span:
        """Return where the formula stands."""
        return self.formula.span


def literals(formula: nodes.Formula | None) -> Iterator[Literal]:
    """Yield the literals of a conjunction, from left to right."""
    stack = [] if formula is None else [formula]
    while stack:
        here = stack.pop()
        if type(here) is nodes.And:
            stack.extend(reversed(here.parts))
        elif type(here) is nodes.Not:
            yield Literal(here.part, False)
        else:
            yield Literal(here, True)


def apart(formula: nodes.Formula, kept: Container[str], mark: str) -> nodes.Formula:
    """Return a formula whose variables that are not kept have names of their own."""
    new = {n: nodes.Var(f"{n}{mark}") for n in variable_names(formula) if n not in kept}
    return substitute(formula, new) if new else formula


def number_of(term: nodes.Term | None) -> Number | None:
    """Return the number that a term is; None for other terms."""
    value = term.value if isinstance(term, nodes.Const) else None
    return value if isinstance(value, int | float) else None


def holds_between(op: str, left: Number, right: Number) -> bool:
    """Whether a test of two numbers holds."""
    match op:
        case "<":
            return left < right
        case ">":
            return left > right
        case "<=":
            return left <= right
        case ">=":
            return left >= right
        case "=":
            return left == right
    return left != right
