"""Every node of a library by its type.

Nodes come in the order of the text, each with its parent, which tells what part it
plays, and with the top-level form that it stands in. The pass `occurrences` gathers
them once for all others.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Generic, TypeVar, cast

import msgspec

from rapc.ir import nodes
from rapc.ir.walk import CHILDREN

N = TypeVar("N", bound=nodes.Node)


class Use(msgspec.Struct, Generic[N], frozen=True, gc=False):
    """A node where it stands."""

    node: N
    parent: nodes.Node
    owner: nodes.TopForm


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
