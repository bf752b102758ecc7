"""What a library declares that facts and tests may be made of, under one roof.

Propositions, properties and functions share their names (`rapc.library`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal

import msgspec

from rapc.analysis.occurrences import Occurrences
from rapc.ir import nodes
from rapc.library import Library, name_span
from rapc.source import Span

Kind = Literal["proposition", "property", "function"]

Declaration = nodes.DeclareProposition | nodes.DeclareProperty | nodes.DeclareFunction

Role = Literal["query", "believe", "assert", "erase"]
"""What becomes of a fact where it stands."""


class Predicate(msgspec.Struct, frozen=True):
    """One declaration; `args` is None where it gives no list of arguments."""

    name: str
    kind: Kind
    args: tuple[nodes.Argument, ...] | None
    span: Span


def predicates(library: Library) -> dict[str, Predicate]:
    """All declared predicates by name."""
    tables: tuple[tuple[Kind, Mapping[str, Declaration]], ...] = (
        ("proposition", library.propositions),
        ("property", library.properties),
        ("function", library.functions),
    )
    return {
        name: Predicate(name, kind, form.args, name_span(library.files, form))
        for kind, table in tables
        for name, form in table.items()
    }


def facts(occurrences: Occurrences) -> Iterator[tuple[nodes.Pattern, Role]]:
    """Every pattern that stands for a fact or a test, with its role."""
    for use in occurrences.of(nodes.Pattern):
        role = _role(use.node, use.parent)
        if role is not None:
            yield use.node, role


def _role(pattern: nodes.Pattern, parent: nodes.Node) -> Role | None:
    match parent:
        case nodes.Primitive() | nodes.Skills() | nodes.ResultCase():
            return None
        case nodes.Believe():
            return "believe"
        case nodes.RuleAction():
            return "assert" if parent.op == "mem-add" else "erase"
        case nodes.Method():
            return "query" if pattern is parent.context else "assert"
        case nodes.Effect() | nodes.Exclusion():
            return "assert"
    return "query"
