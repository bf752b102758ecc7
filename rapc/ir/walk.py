"""Walks over the IR: formulas of a RAP, parts of a formula, terms with their roles.

Everything comes in the order of the text. Which variable is bound where is not known
here: that depends on declarations and on the order of evaluation (`rapc.analysis`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from types import UnionType
from typing import Literal

import msgspec

from rapc.ir import nodes

Role = Literal["match", "use"]
"""How a term stands: `match` may give an unbound variable its value, `use` needs it.

The arguments of a proposition match; a declared function used as a test looks like
one, so whoever knows the declarations takes its arguments as `use`.
"""

Clause = Literal[
    "monitor-state",
    "repeat-while",
    "succeed",
    "preconditions",
    "constraints",
    "context",
    "for",
]
"""Where a formula of a RAP stands."""


def _children(kind: type[nodes.Node]) -> tuple[str, ...]:
    """The fields of a type of node whose declared types name nodes."""
    return tuple(
        field
        for field in kind.__struct_fields__
        if _NODES & set(_WORD.findall(_declared(kind, field))) and field not in _PAIRS
    )


def _declared(kind: type, field: str) -> str:
    """The type of a field as it is written in its class or one above."""
    found = (vars(above).get("__annotations__", {}) for above in kind.__mro__)
    return next(str(types[field]) for types in found if field in types)


_WORD = re.compile(r"\w+")
_PAIRS = ("keys",)
"""Fields of pairs of a word and a node, which are no nodes themselves."""

_NODES = {
    name
    for name, value in vars(nodes).items()
    if (isinstance(value, UnionType) and name not in {"Atom", "Number"})
    or (isinstance(value, type) and issubclass(value, nodes.Node))
}

CHILDREN: Mapping[type, tuple[str, ...]] = {
    kind: _children(kind)
    for kind in vars(nodes).values()
    if isinstance(kind, type) and issubclass(kind, nodes.Node)
    if kind not in (nodes.Node, nodes.Pattern)
}
"""For each type of node, the fields that hold nodes, in the order of the text."""


class TermAt(msgspec.Struct, frozen=True):
    """A term directly in a formula, with the formula and the term's role."""

    term: nodes.Term
    role: Role
    formula: nodes.Formula


class FormulaAt(msgspec.Struct, frozen=True):
    """A whole formula of a RAP: its clause, and the method or step that holds it."""

    formula: nodes.Formula
    clause: Clause
    method: nodes.Method | None = None
    step: nodes.Step | None = None


def formulas(rap: nodes.DefineRap) -> Iterator[FormulaAt]:
    """All formulas of a RAP: its own clauses, then contexts and annotations."""
    own: tuple[tuple[nodes.Formula | None, Clause], ...] = (
        (rap.monitor_state, "monitor-state"),
        (rap.repeat_while, "repeat-while"),
        (rap.succeed, "succeed"),
        (rap.preconditions, "preconditions"),
        (rap.constraints, "constraints"),
    )
    for formula, clause in own:
        if formula is not None:
            yield FormulaAt(formula, clause)
    for method in rap.methods:
        if method.context is not None:
            yield FormulaAt(method.context, "context", method)
        if method.constraints is not None:
            yield FormulaAt(method.constraints, "constraints", method)
        for step in steps(method):
            for note in step.annotations:
                if isinstance(note, nodes.For) and note.formula is not None:
                    yield FormulaAt(note.formula, "for", method, step)


def steps(method: nodes.Method) -> tuple[nodes.Step, ...]:
    """The steps of a method; none if it is a primitive."""
    body = method.body
    return body.steps if isinstance(body, nodes.TaskNet) else ()


def subformulas(formula: nodes.Formula) -> Iterator[nodes.Formula]:
    """A formula and all formulas in it, each before its parts.

    The proposition in a `believe` is one of them.
    """
    stack: list[nodes.Formula] = [formula]
    while stack:
        here = stack.pop()
        yield here
        if type(here) is nodes.And or type(here) is nodes.Or:
            stack.extend(reversed(here.parts))
        elif type(here) is nodes.Not:
            stack.append(here.part)
        elif type(here) is nodes.Believe:
            stack.append(here.pattern)


def terms(formula: nodes.Formula) -> Iterator[TermAt]:
    """The terms of a formula and all formulas in it, outermost terms only."""
    for here in subformulas(formula):
        for term, role in _own_terms(here):
            yield TermAt(term, role, here)


def _own_terms(formula: nodes.Formula) -> Iterator[tuple[nodes.Term, Role]]:
    pairs: Iterable[tuple[nodes.Term, Role]] = ()
    match formula:
        case nodes.Proposition(_, args) | nodes.HistoryTest(_, args):
            pairs = ((arg, "match") for arg in args)
        case nodes.Compare(_, left, right):
            pairs = ((left, "use"), (right, "use"))
        case nodes.Believe(_, age):
            pairs = ((age, "match"),)
        case nodes.SetTest(_, args):
            pairs = ((arg, "use") for arg in args)
        case nodes.SensorName(item, value):
            pairs = ((item, "match"), (value, "match"))
        case nodes.Count(kind, place, number):
            pairs = ((kind, "match"), (place, "match"), (number, "match"))
        case _:
            pass
    for term, role in pairs:
        yield term, "use" if isinstance(term, nodes.Call) else role


def subterms(term: nodes.Term) -> Iterator[nodes.Term]:
    """A term and all terms in it, each before its arguments."""
    stack: list[nodes.Term] = [term]
    while stack:
        here = stack.pop()
        yield here
        if type(here) is nodes.Call:
            stack.extend(reversed(here.args))


def variables(formula: nodes.Formula) -> Iterator[tuple[nodes.Var, Role]]:
    """The variables of a formula with their roles; inside a computed term, `use`."""
    for at in terms(formula):
        for part in subterms(at.term):
            if isinstance(part, nodes.Var):
                yield part, at.role
