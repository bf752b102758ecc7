"""Graphs as data, to be drawn: of a library, or of a network of skills."""

from __future__ import annotations

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
