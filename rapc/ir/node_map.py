"""A mapping whose keys are nodes told apart by identity, not by what they say.

Equal nodes stand at many places of a text; what is known of one is not known of the
other. The map keeps its keys alive, so that no other node takes over their identity.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, MutableMapping
from typing import TypeVar

from rapc.ir.nodes import Node

K = TypeVar("K", bound=Node)
V = TypeVar("V")


class NodeMap(MutableMapping[K, V]):
    """Values by node, in the order in which they were put in."""

    def __init__(self, rows: Iterable[tuple[K, V]] = ()) -> None:
        self._rows: dict[int, tuple[K, V]] = {}
        for node, value in rows:
            self[node] = value

    def __getitem__(self, node: K) -> V:
        """Return the value of `node`; raises KeyError if it has none."""
        return self._rows[id(node)][1]

    def __setitem__(self, node: K, value: V) -> None:
        """Set the value of `node`."""
        self._rows[id(node)] = (node, value)

    def __delitem__(self, node: K) -> None:
        """Forget `node`; raises KeyError if it has no value."""
        del self._rows[id(node)]

    def __iter__(self) -> Iterator[K]:
        """Return the nodes that have values."""
        return iter([node for node, _ in self._rows.values()])

    def __len__(self) -> int:
        """Return how many nodes have values."""
        return len(self._rows)

    def __contains__(self, node: object) -> bool:
        """Whether `node` itself, not only one like it, has a value."""
        return id(node) in self._rows
