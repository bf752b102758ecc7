"""Graphs as text: for Graphviz, Mermaid, other drawing programs, and people."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import NamedTuple

import msgspec

from rapc.base.graph import Graph, Vertex


class Shape(NamedTuple):
    """The look of the vertices of a kind."""

    #: Attributes for Graphviz.
    dot: str
    #: The brackets of Mermaid, one on each side.
    left: str
    right: str


class Style(NamedTuple):
    """The look of a sort of graphs."""

    #: The shapes, by the kind of a vertex.
    shapes: Mapping[str, Shape]
    #: Statements for Graphviz, about all vertices and edges.
    defaults: tuple[str, ...] = ()
    #: The text for a graph without vertices.
    nothing: str = ""


LIBRARY = Style(
    {
        "rap": Shape("shape=box", "[", "]"),
        "step": Shape("shape=box", "[", "]"),
        "primitive": Shape("shape=ellipse", "([", "])"),
        "skill": Shape("shape=ellipse", "([", "])"),
        "agenda": Shape("shape=folder", "[[", "]]"),
        "fact": Shape("shape=hexagon", "{{", "}}"),
        "thing": Shape("shape=cylinder", "[(", ")]"),
        "datum": Shape("shape=parallelogram", "[/", "/]"),
        "query": Shape("shape=octagon", "{{", "}}"),
        "event": Shape("shape=cds", ">", "]"),
    }
)
"""Graphs of a library, see `rapc.analysis.graphs`."""

NETWORK = Style(
    {
        "sensor": Shape("shape=plaintext", "([", "])"),
        "skill": Shape("shape=box, style=rounded", "(", ")"),
        "event": Shape("shape=box, peripheries=2", "[[", "]]"),
        "arbiter": Shape("shape=diamond", "{", "}"),
        "actuator": Shape("shape=plaintext", "([", "])"),
    },
    (
        'node [fontname="Helvetica,Arial,sans-serif", margin="0.2,0.06"]',
        'edge [fontname="Helvetica,Arial,sans-serif", fontsize=11]',
    ),
    "no active skills",
)
"""Networks of skills, see `rapc.worlds.skills.network`."""


def dot(graph: Graph, style: Style) -> str:
    """Return a graph in the language of Graphviz."""
    rows = [f"digraph {_quoted(graph.title)} {{", "  rankdir=LR;"]
    rows += [f"  {statement};" for statement in style.defaults]
    if style.nothing and not graph.vertices:
        rows.append(f"  label={_quoted(style.nothing)};")
    for group, members in _grouped(graph.vertices).items():
        indent = "  "
        if group:
            rows.append(f"  subgraph {_quoted(f'cluster {group}')} {{")
            rows.append(f"    label={_quoted(group)};")
            indent = "    "
        for one in members:
            said = f"label={_quoted(one.label)}, {style.shapes[one.kind].dot}"
            rows.append(f"{indent}{_quoted(one.id)} [{said}];")
        if group:
            rows.append("  }")
    for edge in graph.edges:
        looks = [f"label={_quoted(edge.label)}"] if edge.label else []
        looks += ["style=dashed"] if edge.delayed else []
        look = f" [{', '.join(looks)}]" if looks else ""
        rows.append(f"  {_quoted(edge.source)} -> {_quoted(edge.target)}{look};")
    return _lines([*rows, "}"])


def mermaid(graph: Graph, style: Style) -> str:
    """Return a graph as a Mermaid flowchart."""
    names = {one.id: f"n{at}" for at, one in enumerate(graph.vertices)}
    rows = ["flowchart LR"]
    if style.nothing and not graph.vertices:
        rows.append(f'  n0["{style.nothing}"]')
    for at, (group, members) in enumerate(_grouped(graph.vertices).items()):
        indent = "  "
        if group:
            rows.append(f'  subgraph g{at}["{_escaped(group)}"]')
            indent = "    "
        for one in members:
            shape = style.shapes[one.kind]
            label = f'{shape.left}"{_escaped(one.label)}"{shape.right}'
            rows.append(f"{indent}{names[one.id]}{label}")
        if group:
            rows.append("  end")
    for edge in graph.edges:
        arrow = "-.->" if edge.delayed else "-->"
        label = f'|"{_escaped(edge.label)}"|' if edge.label else ""
        rows.append(f"  {names[edge.source]} {arrow}{label} {names[edge.target]}")
    return _lines(rows)


def graph_text(graph: Graph, style: Style) -> str:
    """Return a graph for people to read: each vertex with the ends of its arrows."""
    if style.nothing and not graph.vertices:
        return _lines([style.nothing])
    labels = {one.id: one.label for one in graph.vertices}
    led: dict[str, dict[str, list[str]]] = {one.id: {} for one in graph.vertices}
    ends = set()
    for edge in graph.edges:
        led[edge.source].setdefault(edge.label, []).append(labels[edge.target])
        ends.add(edge.target)
    rows = []
    for one in graph.vertices:
        if led[one.id] or one.id not in ends:
            rows.append(f"{one.group}: {one.label}" if one.group else one.label)
        for label, targets in led[one.id].items():
            rows += _told(f"  {label or '->'} ", targets)
    return _lines(rows)


def _told(head: str, targets: Iterable[str]) -> Iterator[str]:
    """Yield lines of words after a head, short if possible."""
    line, filled = head, False
    for target in targets:
        if filled and len(line) + len(target) + 2 > _WIDTH:
            yield f"{line},"
            line, filled = " " * len(head), False
        line += f", {target}" if filled else target
        filled = True
    yield line


_WIDTH = 80
"""The length of the lines of a text."""


def graph_json(graph: Graph, _style: Style) -> str:
    """Return a graph as JSON: its title, vertices and edges."""
    return json.dumps(msgspec.to_builtins(graph), indent=2, ensure_ascii=False) + "\n"


def graphml(graph: Graph, _style: Style) -> str:
    """Return a graph in GraphML, for programs that analyse graphs."""
    import networkx  # noqa: PLC0415  # few commands use networkx

    made: networkx.MultiDiGraph[str] = networkx.MultiDiGraph(name=graph.title)
    for one in graph.vertices:
        made.add_node(one.id, kind=one.kind, label=one.label, group=one.group)
    for edge in graph.edges:
        made.add_edge(edge.source, edge.target, label=edge.label)
    return "".join(f"{line}\n" for line in networkx.generate_graphml(made))


WRITERS: Mapping[str, Callable[[Graph, Style], str]] = {
    "dot": dot,
    "mermaid": mermaid,
    "json": graph_json,
    "text": graph_text,
    "graphml": graphml,
}
"""The writers of graphs in each format."""


def _grouped(vertices: Iterable[Vertex]) -> Mapping[str, list[Vertex]]:
    groups: dict[str, list[Vertex]] = {}
    for one in vertices:
        groups.setdefault(one.group, []).append(one)
    return groups


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'


def _escaped(text: str) -> str:
    codes = {"#": "#35;", '"': "#quot;", "<": "#lt;", ">": "#gt;", "\n": " "}
    return "".join(codes.get(letter, letter) for letter in text)


def _lines(rows: Iterable[str]) -> str:
    return "".join(f"{row}\n" for row in rows)
