"""Graphs as data for drawing, strongly connected components and reachability.

The checker does not use networkx (`library.graph()` does), because its import takes
longer than a check.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from typing import Generic, TypeVar

import msgspec

T = TypeVar("T")


class Vertex(msgspec.Struct, frozen=True):
    """A vertex of a drawn graph."""

    #: The name of the vertex in edges.
    id: str
    #: The kind of the vertex, in a word: `rap`, `skill`, `sensor` ...
    kind: str
    label: str
    #: The group around the vertex, if any: a method.
    group: str = ""


class Edge(msgspec.Struct, frozen=True, omit_defaults=True):
    """An arrow from one vertex to another."""

    source: str
    target: str
    label: str
    #: Whether the edge carries values of the preceding step.
    delayed: bool = False


class Graph(msgspec.Struct, frozen=True):
    """A graph of vertices and edges, each once."""

    title: str
    vertices: tuple[Vertex, ...]
    edges: tuple[Edge, ...]


def components(
    roots: Iterable[str],
    successors: Callable[[str], Iterable[str]],
    known: Container[str] = (),
) -> Iterator[list[str]]:
    """Yield the strongly connected components reachable from some roots.

    A component follows the components to which it leads. Its members are in the order
    of the search. This is the algorithm of Tarjan (SIAM J. Comput. 1, 1972), without
    recursion.

    Args:
        roots: the first vertices of the search, in this order.
        successors: returns the successors of a vertex; called once for each.
        known: the vertices to leave out.
    """
    order: dict[str, int] = {}
    low: dict[str, int] = {}
    unfinished: list[str] = []
    path: list[tuple[str, Iterator[str]]] = []

    def enter(name: str) -> None:
        order[name] = low[name] = len(order)
        unfinished.append(name)
        path.append((name, iter(successors(name))))

    for root in roots:
        if root not in order and root not in known:
            enter(root)
        while path:
            name, left = path[-1]
            following = next((one for one in left if one not in known), None)
            if following is None:
                path.pop()
                if path:
                    before = path[-1][0]
                    low[before] = min(low[before], low[name])
                if low[name] == order[name]:
                    members = [unfinished.pop()]
                    while members[-1] != name:
                        members.append(unfinished.pop())
                    for member in members:
                        del low[member]
                    yield members[::-1]
            elif following not in order:
                enter(following)
            elif following in low:
                low[name] = min(low[name], low[following])


def circles(successors: Mapping[str, Sequence[str]]) -> Iterator[list[str]]:
    """Yield the components that have a cycle, each as a list of vertices."""
    for members in components(successors, lambda name: successors.get(name, ())):
        if len(members) > 1 or members[0] in successors.get(members[0], ()):
            yield members


def reachable(
    roots: Iterable[str], successors: Callable[[str], Iterable[str]]
) -> Iterator[str]:
    """Yield the roots and all vertices reachable from them, each once.

    A vertex precedes its successors, which are in their own order.
    """
    waiting = list(dict.fromkeys(roots))[::-1]
    seen = set(waiting)
    while waiting:
        here = waiting.pop()
        yield here
        new = [one for one in dict.fromkeys(successors(here)) if one not in seen]
        seen.update(new)
        waiting += reversed(new)


class Reachable(Generic[T]):
    """The items of all vertices reachable from a vertex.

    Each set of items is the bits of a number: Python sets would take memory in the
    square of the length of a chain of vertices.

    Args:
        own: the items of each vertex itself.
        successors: the successors of each vertex.
    """

    def __init__(
        self, own: Mapping[str, Iterable[T]], successors: Mapping[str, Iterable[str]]
    ) -> None:
        self._numbers: dict[T, int] = {}
        self._sums = {name: self._bits(items) for name, items in own.items()}
        for members in components(successors, lambda name: successors.get(name, ())):
            bits = 0
            for name in members:
                bits |= self._sums.get(name, 0)
                for following in successors.get(name, ()):
                    bits |= self._sums.get(following, 0)
            self._sums.update(dict.fromkeys(members, bits))
        self._items = tuple(self._numbers)

    def items(self, names: Iterable[str]) -> list[T]:
        """Return the items reachable from some vertices, each once."""
        bits = 0
        for name in names:
            bits |= self._sums.get(name, 0)
        found = []
        while bits:
            low = bits & -bits
            found.append(self._items[low.bit_length() - 1])
            bits ^= low
        return found

    def has(self, name: str, item: T) -> bool:
        """Return whether an item is reachable from a vertex."""
        at = self._numbers.get(item)
        return at is not None and bool(self._sums.get(name, 0) >> at & 1)

    def _bits(self, items: Iterable[T]) -> int:
        bits = 0
        for item in items:
            bits |= 1 << self._numbers.setdefault(item, len(self._numbers))
        return bits
