"""Graphs: as data to be drawn, their components, and what can be reached in them.

`library.graph()` is a graph of networkx; importing that takes longer than a check does.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from typing import Generic, TypeVar

import msgspec

T = TypeVar("T")


class Vertex(msgspec.Struct, frozen=True):
    """A thing that is drawn."""

    #: What edges call it.
    id: str
    #: What sort of thing it is, in a word: `rap`, `skill`, `sensor` ...
    kind: str
    label: str
    #: The group that it is drawn in, if any: a method.
    group: str = ""


class Edge(msgspec.Struct, frozen=True, omit_defaults=True):
    """An arrow from one vertex to another."""

    source: str
    target: str
    label: str
    #: Whether what comes by it is of the moment before.
    delayed: bool = False


class Graph(msgspec.Struct, frozen=True):
    """Vertices and edges, each once."""

    title: str
    vertices: tuple[Vertex, ...]
    edges: tuple[Edge, ...]


def components(
    roots: Iterable[str],
    successors: Callable[[str], Iterable[str]],
    known: Container[str] = (),
) -> Iterator[list[str]]:
    """Yield the strongly connected components that can be reached from some roots.

    A component comes after those that it leads to; its members are in the order in
    which they were met. This is the algorithm of Tarjan (SIAM J. Comput. 1, 1972),
    without recursion.

    Args:
        roots: where the search begins, in this order.
        successors: returns what an edge leads to from a vertex; asked once for each.
        known: vertices that are left out.
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
    """Yield the vertices that lead back to themselves, one list for each component."""
    for members in components(successors, lambda name: successors.get(name, ())):
        if len(members) > 1 or members[0] in successors.get(members[0], ()):
            yield members


def reachable(
    roots: Iterable[str], successors: Callable[[str], Iterable[str]]
) -> Iterator[str]:
    """Yield the vertices that can be reached from some, and these, each once.

    A vertex comes before those that it leads to, in the order of its successors.
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
    """The items of all vertices that can be reached from a vertex.

    They are kept as bits of numbers: as sets they would take the square of the memory
    where vertices stand in a long row.

    Args:
        own: the items of each vertex itself.
        successors: what edges lead to.
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
        """Return the items that can be reached from some vertices, each once."""
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
        """Whether an item can be reached from a vertex."""
        at = self._numbers.get(item)
        return at is not None and bool(self._sums.get(name, 0) >> at & 1)

    def _bits(self, items: Iterable[T]) -> int:
        bits = 0
        for item in items:
            bits |= 1 << self._numbers.setdefault(item, len(self._numbers))
        return bits
