"""What a library declares that facts and tests may be made of, under one roof.

Propositions, properties and functions share their names (`rapc.library.library`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal

import msgspec

from rapc.analysis.occurrences import Occurrences
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.library.library import Library, name_span

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


def facts(occurrences: Occurrences) -> Iterator[tuple[nodes.Proposition, Role]]:
    """Every proposition with its role."""
    for use in occurrences.of(nodes.Proposition):
        yield use.node, _role(use.node, use.parent)


def _role(pattern: nodes.Proposition, parent: nodes.Node) -> Role:
    if type(parent) is nodes.Method:
        return "query" if pattern is parent.context else "assert"
    if type(parent) is nodes.RuleAction:
        return "assert" if parent.op == "mem-add" else "erase"
    return _ROLES.get(type(parent), "query")


_ROLES: Mapping[type, Role] = {
    nodes.Believe: "believe",
    nodes.DeclaredEffect: "assert",
    nodes.Exclusion: "assert",
}
"""The roles of patterns that their parents alone tell; all others are asked."""
