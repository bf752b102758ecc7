"""Printing of IR as RAP text: terms, formulas, goals and definitions.

The text is one line, and parsing it gives an equal node. A node is written by the
grammar rule that also reads the node. Each operand of the rule takes the next field of
the node, each clause or option the field of its name. Default values are left out.
`OPERANDS_OF` has the nodes whose operands are not their fields, `_BY_HAND` the nodes
with their own functions. Not here: line breaks (`rapc.ir.layout`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache
from operator import attrgetter
from typing import Any

from rapc.base.values import Text, format_atom
from rapc.ir import nodes
from rapc.ir.schema import (
    HELD_BY,
    OPERANDS_OF,
    Part,
    fields,
    parts,
    rule_of,
    rule_of_kind,
    unsaid,
)
from rapc.language.grammar import RULES, TERMINALS
from rapc.language.heads import heads
from rapc.language.shapes import Shape, is_rule, is_word

Bindings = Mapping[str, object]
"""Values by variable name (with its question mark): atoms, or objects with `str`."""

Tree = str | tuple["Tree", ...]
"""A nested text: an atom in its written form, or the trees in a list."""

Row = Sequence[Tree]
"""A sequence of trees: one for most nodes, a word and its value for options."""

Write = Callable[[Any, Bindings | None], Row]
"""A function that returns the trees of a value."""


def format_term(term: nodes.Term, bindings: Bindings | None = None) -> str:
    """Return a term as text; a bound variable is written as its value."""
    return format_node(term, bindings)


def format_goal(goal: nodes.Goal, bindings: Bindings | None = None) -> str:
    """Return a goal as text: `(find box => ?place)`."""
    return format_node(goal, bindings)


def format_formula(
    formula: nodes.Formula | nodes.Pattern, bindings: Bindings | None = None
) -> str:
    """Return a formula, or any name with its arguments, as text on one line."""
    return format_node(formula, bindings)


def format_node(node: nodes.Node, bindings: Bindings | None = None) -> str:
    """Return a node as text on one line: a formula, a method, a whole definition."""
    return " ".join(map(one_line, trees(node, bindings)))


def one_line(tree: Tree) -> str:
    """Return a tree as text on one line."""
    if isinstance(tree, str):
        return tree
    words = [one if type(one) is str else one_line(one) for one in tree]
    return f"({' '.join(words)})"


def trees(node: nodes.Node, bindings: Bindings | None = None) -> Row:
    """Return the trees of a node; more than one only for options."""
    return _writer(type(node))(node, bindings)


@cache
def _writer(kind: type[nodes.Node]) -> Write:
    """Return the writer for nodes of a kind."""
    by_hand = _BY_HAND.get(kind)
    if by_hand is not None:
        return by_hand
    rule = rule_of_kind(kind)
    if isinstance(rule, str):
        return _by_rule(rule, kind)
    return lambda node, bindings: _by_rule(rule(node), kind)(node, bindings)


@cache
def _by_rule(rule: str, kind: type[nodes.Node]) -> Write:
    """Return the writer for nodes of a kind by a rule."""
    known = parts(rule, kind)
    names = fields(kind, known)
    operands = OPERANDS_OF.get(kind, lambda node: [getattr(node, n) for n in names])
    writes = [_part(part, kind, known) for part in known]
    return _row(rule, writes, operands)


_WritePart = Callable[[Any, Iterator[Any], Bindings | None], Row]
"""A function that writes a part of a node: a clause, or the next operand."""


def _row(
    rule: str,
    writes: Sequence[_WritePart],
    operands: Callable[[Any], Iterable[Any]],
) -> Write:
    """Return the writer for the parts of a rule, with parentheses for a list."""
    nested = RULES[rule][0] == "list"

    def write(node: Any, bindings: Bindings | None) -> Row:
        values = iter(operands(node))
        row = [tree for one in writes for tree in one(node, values, bindings)]
        return (tuple(row),) if nested else row

    return write


def _part(part: Part, kind: type[nodes.Node], known: Sequence[Part]) -> _WritePart:
    if part.field:
        return _clause(str(part.shape), part.field, kind, known)
    if is_word(part.shape):
        word = (_word(part.shape),)
        return lambda node, values, bindings: word
    write = _of_shape(part.shape)
    return lambda node, values, bindings: write(next(values, None), bindings)


def _clause(
    rule: str, field: str, kind: type[nodes.Node], known: Sequence[Part]
) -> _WritePart:
    """Return the writer for a clause or an option, which leaves out default values.

    Of clauses that share a field, only the clause of the node's rule is written.
    """
    left_out, words, whole = unsaid(rule, kind, field), heads(rule), _whole(rule)
    take = HELD_BY.get(rule) or attrgetter(field)
    shared = sum(part.field == field for part in known) > 1

    def itself(value: Any) -> bool:
        own = rule_of(value) if isinstance(value, nodes.Node) else ""
        return own in RULES and heads(own) == words

    def write(node: Any, values: Iterator[Any], bindings: Bindings | None) -> Row:
        value = take(node)
        if value == left_out or (shared and not itself(value)):
            return ()
        many = value if type(value) is tuple else (value,)
        if many and all(map(itself, many)):
            return [tree for one in many for tree in trees(one, bindings)]
        return whole(value, bindings)

    return write


@cache
def _whole(rule: str) -> Write:
    """Return the writer for a rule with a single operand and no node."""
    shape = RULES[rule]
    if is_word(shape):
        return lambda value, bindings: (_word(shape),)
    writes = [_part(Part(one), nodes.Node, ()) for one in shape[1:]]
    return _row(rule, writes, lambda value: (value,))


# --- operands ----------------------------------------------------------------------


@cache
def _of_shape(shape: Shape) -> Write:
    """Return the writer for an operand: nodes by their rules, values by the shape."""
    plain = _plain(shape)

    def write(value: Any, bindings: Bindings | None) -> Row:
        if isinstance(value, nodes.Node):
            return trees(value, bindings)
        return plain(value, bindings)

    return write


def _plain(shape: Shape) -> Write:
    """Return the writer for values other than nodes: names, numbers, words, rows."""
    if isinstance(shape, str) and is_rule(shape):
        return _whole(shape) if RULES[shape][0] == "seq" else _listed(shape)
    if isinstance(shape, str):
        return _text if shape in ("STRING", "FILE") else _any
    kind, *inner = shape
    if kind in ("*", "+"):
        write = _of_shape(inner[0])
        return lambda value, bindings: [t for v in value for t in write(v, bindings)]
    if kind == "or":
        return _plain_choice(inner)
    made = {"?": _if_any, "seq": _in_row}.get(str(kind))
    return made(shape) if made is not None else _any


def _plain_choice(choices: Sequence[Shape]) -> Write:
    """Return the writer for a choice of words, or for a choice of kinds of atoms."""
    if all(map(is_word, choices)):
        colon = ":" * (_word(choices[0])[0] == ":")
        return lambda value, bindings: (
            f"{colon}{str(value).lower() if isinstance(value, bool) else value}",
        )
    return _name_or_text if "STRING" in choices and "SYMBOL" not in choices else _any


def _if_any(shape: Shape) -> Write:
    """Return the writer for an optional operand."""
    inner = shape[1]
    write = _of_shape(inner)
    row = inner[0] == "seq" and inner[-1][0] == "*"

    def maybe(value: Any, bindings: Bindings | None) -> Row:
        left_out = value is None or value == "" or (row and not value)
        return () if left_out else write(value, bindings)

    return maybe


def _in_row(shape: Shape) -> Write:
    """Return the writer for a value and the words before the value."""
    *words, last = [part for part in shape[1:] if part[0] != "?"]
    said, write = [_word(word) for word in words], _of_shape(last)
    return lambda value, bindings: [*said, *write(value, bindings)]


@cache
def _listed(rule: str) -> Write:
    """Return the writer for a list of values, with the first word of its rule."""
    shape = RULES[rule]
    word = [_word(shape[1])] if shape[0] == "list" and is_word(shape[1]) else []

    def write(value: Any, bindings: Bindings | None) -> Row:
        if type(value) is not tuple:
            return (format_atom(value),)
        return ((*word, *_all(value, bindings)),)

    return write


def _all(values: Iterable[Any], bindings: Bindings | None) -> list[Tree]:
    """Return the trees of values: nodes and atoms."""
    return [tree for value in values for tree in _any(value, bindings)]


def _any(value: Any, bindings: Bindings | None) -> Row:
    """Return the trees of a node, an atom, or a list of nodes and atoms."""
    if isinstance(value, nodes.Node):
        return trees(value, bindings)
    if type(value) is tuple:
        return (tuple(_all(value, bindings)),)
    return (format_atom(value),)


def _word(shape: Shape) -> str:
    return str(shape)[1:-1]


def _text(value: Any, bindings: Bindings | None) -> Row:
    return (format_atom(Text(value)),)


def _name_or_text(value: Any, bindings: Bindings | None) -> Row:
    """Return a value as a name if it is a valid name, otherwise as a text."""
    named = re.fullmatch(TERMINALS["SYMBOL"], value) and value == value.lower()
    return (format_atom(value if named else Text(value)),)


# --- nodes with their own writers --------------------------------------------------


def _term(term: nodes.Term, bindings: Bindings | None) -> Tree:
    if isinstance(term, nodes.Var):
        bound = bindings is not None and term.name in bindings
        return format_atom(bindings[term.name]) if bindings and bound else term.name
    if isinstance(term, nodes.Const):
        return format_atom(term.value)
    return (term.function, *[_term(arg, bindings) for arg in term.args])


def _pattern(node: nodes.Pattern, bindings: Bindings | None) -> Row:
    return ((node.name, *[_term(arg, bindings) for arg in node.args]),)


def _define_method(node: nodes.DefineMethod, bindings: Bindings | None) -> Row:
    (method,) = trees(node.method, bindings)
    return (("define-method", node.rap, *method[1:]),)


def _effect(node: nodes.DeclaredEffect, bindings: Bindings | None) -> Row:
    fact = _pattern(node.pattern, bindings)
    word = "not" if node.negated else "may"
    return ((word, *fact),) if node.negated or node.possible else fact


def _argument(node: nodes.Argument, bindings: Bindings | None) -> Row:
    name = node.variable.name
    return (name,) if node.kind is None else ((name, node.kind),)


def _comparator(node: nodes.DeclareComparator, bindings: Bindings | None) -> Row:
    names = [one for one in (node.class_name, node.place, node.function) if one]
    return (("declare-class-comparator", *names, *_all(node.rows, bindings)),)


def _comparator_row(node: nodes.ComparatorRow, bindings: Bindings | None) -> Row:
    weight = [format_atom(node.weight)] if node.treatment == "score" else []
    return ((node.treatment, node.property, *weight),)


def _skills(node: nodes.Skills, bindings: Bindings | None) -> Row:
    enable, disable = (
        [(word, *_all(named, bindings))] if named else []
        for word, named in (("enable", node.enable), ("disable", node.disable))
    )
    said = [*enable, *_all(node.waits, bindings), *disable]
    return (("primitive", *(said or [("enable",)])),)


def _until(node: nodes.Until, bindings: Bindings | None) -> Row:
    told = (("until", node.time), ("cycles", node.cycles))
    return [(word, format_atom(value)) for word, value in told if value is not None]


def _event(node: nodes.EventPattern, bindings: Bindings | None) -> Row:
    keys = [(f":{key}", *trees(value, bindings)) for key, value in node.keys]
    return ((node.event, *[tree for key in keys for tree in key]),)


_BY_HAND: Mapping[type, Callable[[Any, Bindings | None], Row]] = {
    **dict.fromkeys(
        (nodes.Const, nodes.Var, nodes.Call),
        lambda node, bindings: (_term(node, bindings),),
    ),
    **dict.fromkeys(
        (nodes.Proposition, nodes.Request, nodes.Signal, nodes.Skill, nodes.Datum),
        _pattern,
    ),
    nodes.Thing: lambda node, bindings: (
        _pattern(node, bindings) if node.args else (node.name,)
    ),
    nodes.Truth: lambda node, _: ("true" if node.value else "false",),
    nodes.DefineMethod: _define_method,
    nodes.DeclaredEffect: _effect,
    nodes.Argument: _argument,
    nodes.VariableKind: lambda node, _: ((node.variable, node.kind),),
    nodes.DeclareComparator: _comparator,
    nodes.ComparatorRow: _comparator_row,
    nodes.Skills: _skills,
    nodes.Until: _until,
    nodes.EventPattern: _event,
    nodes.ListPattern: lambda node, bindings: (tuple(_all(node.items, bindings)),),
}
"""The writers for nodes that the grammar's shapes do not describe."""
