"""Walks over the IR: formulas of a RAP, parts of a formula, terms.

All results are in the order of the text. Not here: bindings of variables, which depend
on declarations and on the order of evaluation (`rapc.analysis`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from operator import is_not
from typing import TypeVar, cast

import msgspec

from rapc.base.source import NOWHERE
from rapc.ir import clauses, nodes
from rapc.ir.clauses import Clause
from rapc.ir.schema import CHILDREN, PARTS


class FormulaAt(msgspec.Struct, frozen=True):
    """A whole formula of a RAP with its clause and its method or step."""

    formula: nodes.Formula
    clause: Clause
    method: nodes.Method | None = None
    step: nodes.Step | None = None


def formulas(rap: nodes.DefineRap) -> Iterator[FormulaAt]:
    """Yield the formulas of a RAP: its own, then the formulas of methods and steps."""
    for clause, formula in clauses.held(clauses.RAP, rap):
        yield FormulaAt(formula, clause)
    for method in rap.methods:
        for clause, formula in clauses.held(clauses.METHOD, method):
            yield FormulaAt(formula, clause, method)
        for step in steps(method):
            for note in step.annotations:
                if isinstance(note, nodes.For) and note.formula is not None:
                    yield FormulaAt(note.formula, clauses.FOR, method, step)


def steps(method: nodes.Method) -> tuple[nodes.Step, ...]:
    """Return the steps of a method; none for a primitive."""
    body = method.body
    return body.steps if isinstance(body, nodes.TaskNet) else ()


def given_names(rap: nodes.DefineRap) -> set[str]:
    """Return the names of the inputs and resources of a RAP."""
    return {v.name for v in (*rap.inputs, *(r.variable for r in rap.resources))}


def input_terms(rap: nodes.DefineRap, goal: nodes.Goal) -> dict[str, nodes.Term]:
    """Return the terms of a goal by the names of the inputs of its RAP."""
    return {v.name: t for v, t in zip(rap.inputs, goal.args, strict=False)}


def ways(formula: nodes.Formula | None) -> tuple[nodes.Formula, ...]:
    """Return the parts of an `or`, or the formula itself: the ways to make it true."""
    if isinstance(formula, nodes.Or):
        return formula.parts
    return () if formula is None else (formula,)


def subformulas(formula: nodes.Formula) -> list[nodes.Formula]:
    """Return a formula and all formulas in it, each before its parts.

    The proposition in a `believe` is included.
    """
    found = [formula]
    for field in PARTS[type(formula)]:
        part = getattr(formula, field)
        for one in part if type(part) is tuple else (part,):
            if PARTS[type(one)]:
                found += subformulas(one)
            else:
                found.append(one)
    return found


def through_queries(
    formula: nodes.Formula, queries: Mapping[str, nodes.DefineQuery]
) -> Iterator[nodes.Formula]:
    """Yield the parts of a formula, and the parts of the queries that it names.

    A query that is named in another query is included; each query is walked once.
    """
    stack, seen = [formula], set[str]()
    while stack:
        for part in subformulas(stack.pop()):
            yield part
            name = part.name if isinstance(part, nodes.Proposition) else ""
            if name in queries and name not in seen:
                seen.add(name)
                stack.append(queries[name].formula)


def terms(formula: nodes.Formula) -> Iterator[nodes.Term]:
    """Yield the terms of a formula and all formulas in it, outermost terms only."""
    for here in subformulas(formula):
        for field in CHILDREN[type(here)]:
            value = getattr(here, field)
            for part in value if type(value) is tuple else (value,):
                if type(part) in _TERMS:
                    yield part


_TERMS = frozenset(nodes.Term.__args__)


def subterms(term: nodes.Term) -> Iterator[nodes.Term]:
    """Yield a term and all terms in it, each before its arguments."""
    stack: list[nodes.Term] = [term]
    while stack:
        here = stack.pop()
        yield here
        if type(here) is nodes.Call:
            stack.extend(reversed(here.args))


def variables(*roots: nodes.Node) -> list[nodes.Var]:
    """Return the variables of some formulas or terms, in the order of the text.

    The variables of computed terms and each bare `?` are included.
    """
    found: list[nodes.Var] = []
    for root in roots:
        if type(root) is nodes.Var:
            found.append(root)
        else:
            _add_variables(root, found)
    return found


def _add_variables(node: nodes.Node, found: list[nodes.Var]) -> None:
    """Add the variables below a node."""
    for field in CHILDREN[type(node)]:
        part = getattr(node, field)
        for one in part if type(part) is tuple else (part,):
            if type(one) is nodes.Var:
                found.append(one)
            elif type(one) is not nodes.Const and one is not None:
                _add_variables(one, found)


def variable_names(*roots: nodes.Node) -> tuple[str, ...]:
    """Return the names of the variables of formulas or terms, without bare `?`."""
    names = dict.fromkeys([variable.name for variable in variables(*roots)])
    names.pop("?", None)
    return tuple(names)


Substituted = TypeVar("Substituted", bound=nodes.Node)


def substitute(node: Substituted, terms: Mapping[str, nodes.Term]) -> Substituted:
    """Return a formula, pattern or term with terms in place of its variables.

    Args:
        node: the formula, pattern or term; parts without the variables stay unchanged.
        terms: the terms by the name of the replaced variable; a term without a span
            takes the span of the variable.
    """
    if isinstance(node, nodes.Const):
        return node
    if isinstance(node, nodes.Var):
        new = terms.get(node.name, node)
        if new is not node and new.span is NOWHERE:
            new = msgspec.structs.replace(new, span=node.span)
        return cast(Substituted, new)
    changed: dict[str, object] = {}
    for field in CHILDREN[type(node)]:
        part = getattr(node, field)
        if type(part) is tuple:
            made = tuple([substitute(one, terms) for one in part])
            if any(map(is_not, made, part)):
                changed[field] = made
        elif part is not None:
            new_part = substitute(part, terms)
            if new_part is not part:
                changed[field] = new_part
    return msgspec.structs.replace(node, **changed) if changed else node
