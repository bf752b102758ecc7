"""What the nodes' classes say of their fields, by the types they are declared with."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from types import UnionType

from rapc.ir import nodes


def declared(kind: type, field: str) -> str:
    """Return the type of a field as it is written in its class or one above."""
    found = (vars(above).get("__annotations__", {}) for above in kind.__mro__)
    return next(str(types[field]) for types in found if field in types)


@cache
def names_in_type(text: str) -> frozenset[str]:
    """Return the names in a type as it is written."""
    return frozenset(_WORD.findall(text))


def _children(kind: type[nodes.Node]) -> tuple[str, ...]:
    """The fields of a type of node whose declared types name nodes."""
    return tuple(
        field
        for field in kind.__struct_fields__
        if _NODES & names_in_type(declared(kind, field)) and field not in _PAIRS
    )


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
