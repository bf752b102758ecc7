"""Every node of a library by its type.

Nodes come in the order of the text, each with its parent, which tells what part it
plays, and with the top-level form that it stands in. The pass `occurrences` gathers
them once for all others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Generic, TypeVar, cast

import msgspec

from rapc.ir import nodes

N = TypeVar("N", bound=nodes.Node)


class Use(msgspec.Struct, Generic[N], frozen=True, gc=False):
    """A node where it stands."""

    node: N
    parent: nodes.Node
    owner: nodes.TopForm


CHILDREN: Mapping[type, tuple[str, ...]] = {
    nodes.Var: (),
    nodes.Call: ("args",),
    nodes.Truth: (),
    nodes.Pattern: ("args",),
    nodes.And: ("parts",),
    nodes.Or: ("parts",),
    nodes.Not: ("part",),
    nodes.Compare: ("left", "right"),
    nodes.Believe: ("pattern", "age"),
    nodes.SetTest: ("args",),
    nodes.History: ("args",),
    nodes.SensorName: ("item", "value"),
    nodes.Count: ("kind", "place", "number"),
    nodes.MonitorTime: ("start", "stop"),
    nodes.Resource: ("variable", "initial"),
    nodes.Effect: ("pattern",),
    nodes.Goal: ("args", "outputs"),
    nodes.For: ("formula",),
    nodes.UntilStart: (),
    nodes.UntilEnd: (),
    nodes.Window: ("start", "stop"),
    nodes.WaitFor: ("args",),
    nodes.ResourceEffect: ("resource", "amount"),
    nodes.Step: ("goal", "annotations"),
    nodes.TaskNet: ("steps",),
    nodes.Primitive: ("request",),
    nodes.Skills: ("enable", "waits", "disable"),
    nodes.Method: ("context", "notations", "body"),
    nodes.DefineRap: (
        "inputs",
        "outputs",
        "duration",
        "monitor_state",
        "monitor_time",
        "repeat_while",
        "succeed",
        "preconditions",
        "constraints",
        "resources",
        "effects",
        "methods",
    ),
    nodes.Argument: ("variable",),
    nodes.Exclusion: ("pattern",),
    nodes.DeclareProposition: ("args",),
    nodes.DeclareProperty: ("args", "excludes"),
    nodes.DeclareFunction: ("args",),
    nodes.DeclareIndistinctClass: (),
    nodes.ComparatorRow: (),
    nodes.DeclareComparator: ("rows",),
    nodes.DeclarePrimitive: ("args",),
    nodes.DeclareDatum: ("args",),
    nodes.DeclareSkill: ("args",),
    nodes.DeclareEvent: ("args",),
    nodes.RuleAction: ("pattern",),
    nodes.Alternative: ("query", "actions"),
    nodes.Rule: ("alternatives",),
    nodes.ResultCase: ("result", "rules"),
    nodes.MemoryRule: ("index", "cases"),
    nodes.EventRule: ("args", "rules"),
    nodes.Require: (),
}
"""For each type of node, the fields that hold nodes, in the order of the text.

What is not listed (tests of a library) has a checker of its own, or none.
"""


class Occurrences:
    """The nodes of a library by type; constants are left out."""

    def __init__(self) -> None:
        self._by_type: dict[type, list[Use[nodes.Node]]] = {k: [] for k in CHILDREN}

    def of(self, kind: type[N]) -> Sequence[Use[N]]:
        """All uses of one type of node, in the order of the text."""
        return cast(Sequence[Use[N]], self._by_type.get(kind, ()))

    def add(self, owner: nodes.TopForm) -> None:
        """Gather the nodes of one form."""
        self._add(owner, owner, owner)

    def _add(self, node: nodes.Node, parent: nodes.Node, owner: nodes.TopForm) -> None:
        kind = type(node)
        self._by_type[kind].append(Use(node, parent, owner))
        for field in CHILDREN[kind]:
            value = getattr(node, field)
            if type(value) is tuple:
                for child in value:
                    if type(child) is not nodes.Const:
                        self._add(child, node, owner)
            elif value is not None and type(value) is not nodes.Const:
                self._add(value, node, owner)
