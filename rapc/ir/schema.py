"""Fields, operands and parts of nodes, from the classes of nodes and the grammar.

- The declared type of a field determines whether the field has nodes, and the use of
  variables in a formula (`operands`).
- The rule of a node has the name of the node, except for the nodes in `_RULES`
  (`rule_of`).
- The operands of a rule are the fields of the node, in order. Clauses and options,
  which come in any order, are the fields of their names (`parts`).
- `OPERANDS_OF` has the nodes whose operands are not their fields.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import cache
from types import UnionType
from typing import Any

import msgspec

from rapc.base.values import Number
from rapc.ir import nodes
from rapc.language.grammar import RULES
from rapc.language.heads import ARROW, heads, rule_named
from rapc.language.shapes import Shape, is_rule, is_word, leaves


def declared(kind: type, field: str) -> str:
    """Return the type of a field as text, from its class or a base class."""
    found = (vars(above).get("__annotations__", {}) for above in kind.__mro__)
    return next(str(types[field]) for types in found if field in types)


@cache
def names_in_type(text: str) -> frozenset[str]:
    """Return the names in the text of a type."""
    return frozenset(_WORD.findall(text))


def _children(kind: type[nodes.Node]) -> tuple[str, ...]:
    """Return the fields of a type of node whose declared types name nodes."""
    return tuple(
        field
        for field in kind.__struct_fields__
        if _NODES & names_in_type(declared(kind, field)) and field not in _PAIRS
    )


_WORD = re.compile(r"\w+")

_PAIRS = ("keys",)
"""Fields of pairs of a word and a node; the pairs are not nodes."""

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
"""For each type of node, the fields with nodes, in the order of the text."""


class Operands(msgspec.Struct, frozen=True):
    """The operands of a formula, grouped by the use of their variables."""

    #: Terms that need their values.
    used: tuple[nodes.Term, ...] = ()
    #: Terms that are matched with values, all at once; this binds free variables.
    matched: tuple[nodes.Term, ...] = ()
    #: Formulas that must all hold, from left to right; each passes on its bindings.
    parts: tuple[nodes.Formula, ...] = ()
    #: Formulas whose bindings are local.
    closed: tuple[nodes.Formula, ...] = ()


def operands(formula: nodes.Formula) -> Operands:
    """Return the operands of a formula; the parts of an `or` are among `parts`."""
    kind = type(formula)
    by_value = _BY_VALUE.get(kind)
    if by_value is not None:
        return by_value(formula)
    return Operands(*[_values(formula, fields) for fields in _FIELDS[kind]])


_ROLES: Mapping[str, str] = {
    "Used": "used",
    "Matched": "matched",
    "Term": "matched",
    "Formula": "parts",
    "Proposition": "parts",
    "Closed": "closed",
}
"""The group of operands for each type of field."""


def _fields(kind: type[nodes.Node]) -> tuple[tuple[str, ...], ...]:
    """Return the fields of a kind of formula for each field of `Operands`."""
    said = {
        field: {
            _ROLES[word]
            for word in names_in_type(declared(kind, field)) & _ROLES.keys()
        }
        for field in kind.__struct_fields__
    }
    return tuple(
        tuple([field for field, roles in said.items() if role in roles])
        for role in Operands.__struct_fields__
    )


_FIELDS = {kind: _fields(kind) for kind in nodes.Formula.__args__}


def _values(formula: nodes.Formula, fields: tuple[str, ...]) -> tuple[Any, ...]:
    """Return the values of some fields of a formula, in order."""
    found: list[Any] = []
    for field in fields:
        value = getattr(formula, field)
        found += value if type(value) is tuple else (value,)
    return tuple(found)


PARTS: Mapping[type, tuple[str, ...]] = {
    kind: (*fields[2], *fields[3]) for kind, fields in _FIELDS.items()
}
"""For each kind of formula, the fields with formulas."""

CONNECTIVES = frozenset(
    kind for kind, (used, matched, *_) in _FIELDS.items() if not (used or matched)
)
"""The kinds of formulas without terms of their own."""


def _history_test(formula: nodes.HistoryTest) -> Operands:
    """Return the operands of a history test: the method is used, the result matched."""
    if formula.query == "method-tried":
        return Operands(used=formula.args)
    return Operands(used=formula.args[:-1], matched=formula.args[-1:])


def _sensor_name(formula: nodes.SensorName) -> Operands:
    """Return the operands of a sensor name test; `false` requires a bound item.

    Without a binding, the items out of sight could not be enumerated.
    """
    value = formula.value
    if type(value) is nodes.Const and value.value == "false":
        return Operands(used=(formula.item,))
    return Operands(matched=(formula.item, value))


_BY_VALUE: Mapping[type, Callable[[Any], Operands]] = {
    nodes.HistoryTest: _history_test,
    nodes.SensorName: _sensor_name,
}


class Part(msgspec.Struct, frozen=True):
    """A part of a rule: a word, an operand, or a clause or option."""

    shape: Shape
    #: The field of a clause or option; empty for words and for operands.
    field: str = ""


NAMED_BY: Mapping[type, str] = {
    nodes.SetTest: "test",
    nodes.HistoryTest: "query",
    nodes.ResourceChange: "op",
}
"""The field whose words name the rules of a kind: `set-add` has the rule `set_add`."""


def rule_of(node: nodes.Node) -> str:
    """Return the grammar rule of a node."""
    rule = rule_of_kind(type(node))
    return rule if isinstance(rule, str) else rule(node)


def rule_of_kind(kind: type[nodes.Node]) -> str | Callable[[Any], str]:
    """Return the grammar rule of a kind of node, or a function from nodes to rules."""
    if kind in NAMED_BY:
        return lambda node: getattr(node, NAMED_BY[kind]).replace("-", "_")
    return _RULES.get(kind) or rule_named(kind.__name__)


@cache
def kind_of_rule(rule: str) -> type[nodes.Node] | None:
    """Return the kind of node that a rule describes; None if there is none."""
    if rule in _ALSO:
        return _ALSO[rule]
    for kind, field in NAMED_BY.items():
        if rule in names_in_type(declared(kind, field).replace("-", "_")):
            return kind
    found = next((kind for kind, one in _RULES.items() if one == rule), None)
    like = "".join(map(str.capitalize, rule.split("_")))
    return found or getattr(nodes, like, None)


_RULES: Mapping[type, str | Callable[[Any], str]] = {
    nodes.For: lambda node: "order" if node.formula is None else "protect",
    nodes.Skills: "primitive",
    nodes.DeclareProposition: "declare_memory_proposition",
    nodes.DeclareProperty: "declare_memory_property",
    nodes.DeclareFunction: "declare_memory_function",
    nodes.DeclareComparator: "declare_class_comparator",
    nodes.DeclareDatum: "declare_sensor_datum",
    nodes.Exclusion: "excludes",
    nodes.MemoryRule: "define_memory_rule",
    nodes.EventRule: "define_event_rule",
    nodes.RuleAction: "action",
    nodes.ResultCase: "case",
    nodes.GivenTask: "agenda_task",
    nodes.MemoryHolds: "memory",
    nodes.TraceHas: "trace",
}
"""The rules with a name different from their node, or selected by a field."""


_ALSO: Mapping[str, type[nodes.Node]] = {
    "task": nodes.GivenTask,
    "placed": nodes.Moved,
}
"""Rules that are used to read nodes, but not to write nodes."""


def declarations() -> Iterator[tuple[str, type[nodes.Node]]]:
    """Yield the rules of declarations with a name and unordered parts, with kinds."""
    for rule in filter(is_rule, leaves(RULES["_form"])):
        kind = kind_of_rule(rule)
        if kind and rule.startswith("declare_") and rule != "declare_class_comparator":
            yield rule, kind


def parts(rule: str, kind: type[nodes.Node]) -> tuple[Part, ...]:
    """Return the parts of a rule for nodes of a kind, in order."""
    shape = RULES[rule]
    if is_word(shape):
        return (Part(shape),)
    items = [item for one in shape[1:] for item in _one_of(one)]
    found: list[Part] = []
    for part in (part for item in items for part in _parts(item, kind)):
        if not part.field or part not in found:
            found.append(part)
    return tuple(found)


def fields(kind: type[nodes.Node], known: Iterable[Part]) -> tuple[str, ...]:
    """Return the fields of a kind of node that are operands, in order."""
    named = {NAMED_BY.get(kind), *(part.field for part in known)}
    return tuple(
        field
        for field in kind.__struct_fields__
        if field not in named and not field.endswith("span")
    )


def _one_of(item: Shape) -> tuple[Shape, ...]:
    """Return the first of several sequences in a choice; any other item alone."""
    if item[0] == "or" and any(one[0] == "seq" for one in item[1:]):
        first = item[1]
        return tuple(first[1:])
    return (item,)


def _parts(item: Shape, kind: type[nodes.Node]) -> Iterable[Part]:
    rules, once = _clauses(item)
    once = once or str(item[-1]).endswith("_clause")
    if once or (len(rules) == 1 and all(map(_is_option, rules))):
        return [Part(rule, _field(rule, kind)) for rule in rules]
    return [Part(item)]


def _is_option(rule: str) -> bool:
    """Return whether a rule is an option: a word with a colon and its values."""
    return RULES[rule][0] == "seq" and heads(rule)[0].startswith(":")


def _clauses(item: Shape) -> tuple[dict[str, None], bool]:
    """Return the rules in a group and its subgroups, and whether they are clauses."""
    found: dict[str, None] = {}
    once = False
    for leaf in filter(is_rule, leaves(item)):
        if leaf[0] == "_":
            inner, held = _clauses(RULES[leaf])
            once = once or held or leaf.startswith("_once")
            found |= inner
        else:
            found[leaf] = None
    return found, once


def _field(rule: str, kind: type[nodes.Node]) -> str:
    """Return the field of a clause or an option, by its word or the plural of it."""
    word = heads(rule)[0].strip(":").replace("-", "_")
    names = (_FIELD_OF.get(rule, word), f"{word}s")
    return next(name for name in names if name in kind.__struct_fields__)


_FIELD_OF = {
    "primitive": "body",
    "task_net": "body",
    "cycles": "until",
    "above": "above",
    "expect": "expectations",
}
"""The fields of clauses with a different name."""


def unsaid(rule: str, kind: type[nodes.Node], field: str) -> Any:
    """Return the value of a field if its clause or option is left out."""
    if rule == "primitive_atomic":
        return True
    words = declared(kind, field)
    if words.endswith("| None"):
        return None
    return next((value for begin, value in _EMPTY if words.startswith(begin)), None)


_EMPTY = (("tuple[", ()), ("bool", False), ("int", 0), ("Number", 0))
"""The default values of fields, by the start of their type."""


def _index(node: nodes.DefineRap) -> Iterable[Any]:
    kinds = {one.variable: one for one in node.kinds}
    inputs, outputs = (
        [kinds.get(one.name, one) for one in row] for row in (node.inputs, node.outputs)
    )
    arrow = [ARROW] if outputs else []
    return ((node.name, *inputs, *arrow, *outputs),)


def _row_request(node: nodes.ScriptRow) -> Iterable[Any]:
    asked = node.request if node.kind == "request" else (node.kind, node.request)
    return (asked, node.result)


def _asked(one: nodes.Request | nodes.Skill) -> Any:
    """Return a request unchanged, and a skill inside `enable`."""
    return ("enable", one) if isinstance(one, nodes.Skill) else one


OPERANDS_OF: Mapping[type, Callable[[Any], Iterable[Any]]] = {
    **dict.fromkeys((nodes.SetTest, nodes.HistoryTest), lambda node: node.args),
    nodes.For: lambda node: [one for one in (node.formula, node.tag) if one],
    nodes.WaitFor: lambda node: (nodes.Signal(node.signal, node.args), node.mode),
    nodes.Step: lambda node: (
        *(node.tag, node.priority or None, node.goal),
        node.annotations,
    ),
    nodes.DefineRap: _index,
    nodes.DefineQuery: lambda node: ((node.name, *node.args), node.formula, node.doc),
    nodes.ResultEffects: lambda node: ((node.result, *node.effects),),
    nodes.EventRule: lambda node: (nodes.Signal(node.signal, node.args), node.rules),
    nodes.ScriptRow: _row_request,
    **dict.fromkeys(
        (nodes.Primitives, nodes.PrimitivesInclude),
        lambda node: ([_asked(one) for one in node.requests],),
    ),
    nodes.Never: lambda node: (_asked(node.request),),
}
"""The operands of nodes whose operands are not their fields."""


def _row_signals(row: nodes.ScriptRow) -> tuple[nodes.Signal | Number, ...]:
    """Return the signals of a row, each after its pause if there is one."""
    waits = row.pauses or [0] * len(row.signals)
    told = zip(waits, row.signals, strict=True)
    return tuple([part for wait, one in told for part in (wait, one) if part])


HELD_BY: Mapping[str, Callable[[Any], Any]] = {"row_signals": _row_signals}
"""The values of options that are made from several fields."""
