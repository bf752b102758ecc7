"""Graphs: as data to be drawn, their components, and what can be reached in them.

`library.graph()` is a graph of networkx; importing that takes longer than a check does.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping

import msgspec


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


def reachable_bits(
    own: Mapping[str, int], successors: Mapping[str, Iterable[str]]
) -> dict[str, int]:
    """Return for each vertex the bits of all that can be reached from it."""
    sums = dict(own)
    for members in components(successors, lambda name: successors.get(name, ())):
        bits = 0
        for name in members:
            bits |= own.get(name, 0)
            for following in successors.get(name, ()):
                bits |= sums.get(following, 0)
        sums.update(dict.fromkeys(members, bits))
    return sums
