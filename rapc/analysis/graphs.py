"""What a library looks like from above: calls, task-nets, monitors, things.

Each function makes a `Graph` of a library, plain data in the order of the text; how it
is drawn is for `rapc.console.graphs`.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from rapc.base.graph import Edge, Graph, Vertex
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.ir.walk import steps, subformulas
from rapc.library.library import Library

Kind = Literal[
    "rap", "primitive", "skill", "agenda", "step", "fact", "thing", "datum", "event"
]
"""What is drawn."""


class GraphDrawing:
    """A graph that is being made; what is added twice is there once."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._vertices: dict[str, Vertex] = {}
        self._edges: dict[Edge, None] = {}

    def vertex(self, kind: Kind, name: str, label: str = "", group: str = "") -> str:
        """Add a vertex, and return what edges call it."""
        id = f"{kind} {name}"
        self._vertices.setdefault(id, Vertex(id, kind, label or name, group))
        return id

    def edge(self, source: str, target: str, label: str = "") -> None:
        """Add an edge between two vertices that were added."""
        self._edges.setdefault(Edge(source, target, label))

    def done(self) -> Graph:
        """Return the graph."""
        return Graph(self._title, tuple(self._vertices.values()), tuple(self._edges))


# --- calls --------------------------------------------------------------------------


def calls(library: Library) -> Graph:
    """Return which RAP asks for which RAPs, primitives and skills, by which methods."""
    drawing = GraphDrawing("calls")
    for agenda in library.agendas.values():
        source = drawing.vertex("agenda", agenda.name)
        for task in agenda.tasks:
            label = f"priority {task.priority}" if task.priority else ""
            drawing.edge(source, drawing.vertex("rap", task.goal.name), label)
    for rap in library.raps.values():
        source = drawing.vertex("rap", rap.name)
        for method in rap.methods:
            for kind, name in _asked(method):
                drawing.edge(source, drawing.vertex(kind, name), _called(rap, method))
    return drawing.done()


def _asked(method: nodes.Method) -> Iterator[tuple[Kind, str]]:
    """Yield what a method asks for: kinds and names."""
    body = method.body
    if isinstance(body, nodes.Primitive):
        yield "primitive", body.request.name
    elif isinstance(body, nodes.Skills):
        yield from (("skill", skill.name) for skill in body.enable)
    yield from (("rap", step.goal.name) for step in steps(method))
    yield from (("skill", skill.name) for skill in method.skills)


def _called(rap: nodes.DefineRap, method: nodes.Method) -> str:
    """Return what a method is called, or nothing for an only one without a name."""
    if method.name is None and len(rap.methods) == 1:
        return ""
    return str(method.name) if method.name is not None else f"#{method.position}"


# --- task-nets ----------------------------------------------------------------------


def task_nets(rap: nodes.DefineRap) -> Graph:
    """Return the steps of each method of a RAP, and what orders and ends them.

    A solid arrow without a label is an order; labels name what else an annotation says:
    the formula that a step protects, who ends whom, windows, signals.
    """
    drawing = GraphDrawing(rap.name)
    for method in rap.methods:
        group = _called(rap, method) or "method"
        if not steps(method):
            for kind, name in _asked(method):
                drawing.vertex(kind, f"{group}/{name}", name, group)
        for step in steps(method):
            label = f"{step.tag}: {format_node(step.goal)}"
            drawing.vertex("step", f"{group}/{step.tag}", label, group)
        tags = {step.tag for step in steps(method)}
        for step in steps(method):
            for note in step.annotations:
                for source, target, label in _drawn(step.tag, note):
                    if not tags.issuperset((source, target)):
                        continue  # a tag that names no step
                    drawing.edge(
                        f"step {group}/{source}", f"step {group}/{target}", label
                    )
    return drawing.done()


def _drawn(tag: str, note: nodes.Annotation) -> Iterator[tuple[str, str, str]]:
    """Yield the arrows of an annotation: from tag to tag, with a label."""
    if isinstance(note, nodes.For):
        yield tag, note.tag, "" if note.formula is None else format_node(note.formula)
    elif isinstance(note, nodes.UntilStart):
        yield note.tag, tag, "start ends"
    elif isinstance(note, nodes.UntilEnd):
        yield note.tag, tag, "end ends"
    elif isinstance(note, nodes.Window):
        span = f"window {format_node(note.start)} to {format_node(note.stop)}"
        source = tag if note.reference in ("now", "absolute") else note.reference
        yield source, tag, span
    elif isinstance(note, nodes.WaitFor):
        yield tag, tag, f"wait for {note.signal}"


# --- monitors -----------------------------------------------------------------------


def monitors(library: Library) -> Graph:
    """Return which facts wake which RAPs, and what is declared to bring them about."""
    drawing = GraphDrawing("monitors")
    heard: dict[str, str] = {}
    for rap in library.raps.values():
        if rap.monitor_state is None:
            continue
        target = drawing.vertex("rap", rap.name)
        for name in facts_of(library, rap.monitor_state):
            heard[name] = drawing.vertex("fact", name)
            drawing.edge(heard[name], target, "wakes")
    for rap in library.raps.values():
        for note in (note for method in rap.methods for note in method.notations):
            if note.name in heard:
                drawing.edge(drawing.vertex("rap", rap.name), heard[note.name], "notes")
    for primitive in library.primitives.values():
        effects = [e for on in primitive.on for e in on.effects]
        _bring_about(drawing, "primitive", primitive.name, effects, heard)
    for datum in library.data.values():
        _bring_about(drawing, "datum", datum.name, list(datum.on or ()), heard)
    return drawing.done()


def facts_of(library: Library, formula: nodes.Formula) -> Iterator[str]:
    """Yield the facts that a formula asks for, by way of named queries too."""
    asked, stack = set(), [formula]
    while stack:
        for part in subformulas(stack.pop()):
            if not isinstance(part, nodes.Proposition) or part.name in asked:
                continue
            asked.add(part.name)
            query = library.queries.get(part.name)
            if query is not None:
                stack.append(query.formula)
            elif part.name in library.propositions or part.name in library.properties:
                yield part.name


def _bring_about(
    drawing: GraphDrawing,
    kind: Kind,
    name: str,
    effects: list[nodes.DeclaredEffect],
    heard: dict[str, str],
) -> None:
    for effect in effects:
        fact = heard.get(effect.pattern.name)
        if fact is not None:
            label = "erases" if effect.negated else "asserts"
            label = "may change" if effect.possible else label
            drawing.edge(drawing.vertex(kind, name), fact, label)


# --- things -------------------------------------------------------------------------


def things(library: Library) -> Graph:
    """Return which things methods claim, and primitives and skills use."""
    drawing = GraphDrawing("claims and uses")
    for rap in library.raps.values():
        for method in rap.methods:
            for thing in method.claims:
                label = " ".join(filter(None, ("claims", _called(rap, method))))
                source = drawing.vertex("rap", rap.name)
                drawing.edge(source, drawing.vertex("thing", thing.name), label)
    for primitive in library.primitives.values():
        for thing in primitive.uses:
            source = drawing.vertex("primitive", primitive.name)
            drawing.edge(source, drawing.vertex("thing", thing.name), "uses")
    for skill in library.skills.values():
        for thing in skill.uses:
            source = drawing.vertex("skill", skill.name)
            drawing.edge(source, drawing.vertex("thing", thing.name), "uses")
    return drawing.done()
