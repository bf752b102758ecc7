"""What formulas say taken apart: conjunctions as rows of literals.

A literal is a formula that is to hold, or that is to have no solution. Which literals
cannot hold together is told by `rapc.analysis.conjunction`, which follow from others by
`rapc.analysis.following`; both say yes only where that is certain.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping

import msgspec

from rapc.base.source import Span
from rapc.base.values import Number
from rapc.ir import nodes
from rapc.ir.fields import CHILDREN


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


def names(formula: nodes.Formula) -> set[str]:
    """Return the names of the variables of a formula, the bare `?` left out."""
    found: set[str] = set()
    stack: list[nodes.Node] = [formula]
    while stack:
        here = stack.pop()
        for field in CHILDREN[type(here)]:
            value = getattr(here, field)
            for part in value if type(value) is tuple else (value,):
                if type(part) is nodes.Var:
                    found.add(part.name)
                elif part is not None and type(part) is not nodes.Const:
                    stack.append(part)
    found.discard("?")
    return found


def apart(formula: nodes.Formula, kept: Container[str], mark: str) -> nodes.Formula:
    """Return a formula whose variables that are not kept have names of their own."""
    found = names(formula)
    new = {name: nodes.Var(f"{name}{mark}") for name in found if name not in kept}
    return put(formula, new)


def put(formula: nodes.Formula, terms: Mapping[str, nodes.Term]) -> nodes.Formula:
    """Return a formula with terms for some of its variables."""
    if not terms:
        return formula
    changed: dict[str, object] = {}
    for field in formula.__struct_fields__:
        value = getattr(formula, field)
        if isinstance(value, nodes.Node):
            changed[field] = _term_or_formula(value, terms)
        elif type(value) is tuple and not field.endswith("span"):
            changed[field] = tuple(
                [
                    _term_or_formula(v, terms) if isinstance(v, nodes.Node) else v
                    for v in value
                ]
            )
    return msgspec.structs.replace(formula, **changed) if changed else formula


def _term_or_formula(node: nodes.Node, terms: Mapping[str, nodes.Term]) -> nodes.Node:
    if isinstance(node, nodes.Var):
        new = terms.get(node.name)
        return node if new is None else msgspec.structs.replace(new, span=node.span)
    if isinstance(node, nodes.Const):
        return node
    return put(node, terms)  # type: ignore[arg-type]  # no term: a formula


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
