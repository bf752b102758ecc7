"""Which rule of the grammar a node is written by, and which field each of its parts is.

A node is of the rule it is named after, but for those in `_RULES`. The parts of a list
are the fields of the node, one after the other; clauses and options, which come in any
order, are the fields of their names.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

import msgspec

from rapc.ir import nodes
from rapc.ir.fields import declared
from rapc.language.grammar import RULES
from rapc.language.heads import heads, rule_named
from rapc.language.shapes import Shape, is_rule, is_word, leaves


class Part(msgspec.Struct, frozen=True):
    """A part of a rule: a word, an operand, or a clause or option."""

    shape: Shape
    #: The field of a clause or option; empty for words and for operands.
    field: str = ""


def rule_of(node: nodes.Node) -> str:
    """Return the rule that a node is written by."""
    rule = rule_of_kind(type(node))
    return rule if isinstance(rule, str) else rule(node)


def rule_of_kind(kind: type[nodes.Node]) -> str | Callable[[Any], str]:
    """Return the rule that nodes of a kind are written by, or what tells it of each."""
    return _RULES.get(kind) or rule_named(kind.__name__)


_RULES: Mapping[type, str | Callable[[Any], str]] = {
    nodes.SetTest: lambda node: str(node.test),
    nodes.HistoryTest: lambda node: str(node.query).replace("-", "_"),
    nodes.For: lambda node: "order" if node.formula is None else "protect",
    nodes.ResourceChange: lambda node: str(node.op).replace("-", "_"),
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
"""The rules of nodes that are called otherwise, or for which their fields decide."""


def declarations() -> Iterator[tuple[str, type[nodes.Node]]]:
    """The rules of declarations that are a name and parts in any order, with kinds."""
    named = {rule: kind for kind, rule in _RULES.items() if isinstance(rule, str)}
    for rule in filter(is_rule, leaves(RULES["_form"])):
        if rule.startswith("declare_") and rule != "declare_class_comparator":
            like = "".join(map(str.capitalize, rule.split("_")))
            yield rule, named.get(rule) or getattr(nodes, like)


def parts(rule: str, kind: type[nodes.Node]) -> tuple[Part, ...]:
    """Return the parts of a rule, in order, as nodes of a kind have them."""
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
    """Return the fields of a kind that are operands, in order."""
    named = {part.field for part in known}
    return tuple(
        field
        for field in kind.__struct_fields__
        if field not in named and not field.endswith("span")
    )


def _one_of(item: Shape) -> tuple[Shape, ...]:
    """The first of several rows that a list may hold; of anything else that alone."""
    if item[0] == "or" and any(one[0] == "seq" for one in item[1:]):
        first = item[1]
        return tuple(first[1:])
    return (item,)


def _parts(item: Shape, kind: type[nodes.Node]) -> Iterable[Part]:
    rules, once = _clauses(item)
    if once or (len(rules) == 1 and all(map(_is_option, rules))):
        return [Part(rule, _field(rule, kind)) for rule in rules]
    return [Part(item)]


def _is_option(rule: str) -> bool:
    """Whether a rule is that of an option: a word with a colon and its values."""
    return RULES[rule][0] == "seq" and heads(rule)[0].startswith(":")


def _clauses(item: Shape) -> tuple[dict[str, None], bool]:
    """The rules in a group, groups in it entered, and whether it is of clauses."""
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
    """The field that holds a clause or an option: that of its word, or of several."""
    word = heads(rule)[0].strip(":").replace("-", "_")
    names = (_FIELDS.get(rule, word), f"{word}s")
    return next(name for name in names if name in kind.__struct_fields__)


_FIELDS = {
    "primitive": "body",
    "task_net": "body",
    "cycles": "until",
    "above": "above",
    "expect": "expectations",
}
"""The fields of clauses that are called otherwise."""


def unsaid(rule: str, kind: type[nodes.Node], field: str) -> Any:
    """Return what a field holds where its clause or option is left out."""
    if rule == "primitive_atomic":
        return True
    words = declared(kind, field)
    if words.endswith("| None"):
        return None
    return next((value for begin, value in _EMPTY if words.startswith(begin)), None)


_EMPTY = (("tuple[", ()), ("bool", False), ("int", 0), ("Number", 0))
"""What fields of a type hold where nothing is said."""
