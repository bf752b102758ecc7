"""Graphs of a library: names, and the calls, queries, effects and claims between them.

`library_graph` returns one networkx graph. `calls`, `monitors` and `things` are parts
of the graph; `dependents`, `recursive` and `dominators` use graph algorithms.
`rapc.console.graphs` draws a graph.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Literal, NamedTuple

from rapc.base.graph import Edge, Graph, Vertex
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.ir.walk import formulas, steps, subformulas, through_queries
from rapc.library.library import Library, usable_in_plans

if TYPE_CHECKING:
    import networkx

Kind = Literal[
    "rap",
    "primitive",
    "skill",
    "agenda",
    "step",
    "fact",
    "query",
    "thing",
    "datum",
    "event",
]
"""The kind of a vertex."""


class GraphDrawing:
    """A graph under construction; a duplicate vertex or edge is added once."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._vertices: dict[str, Vertex] = {}
        self._edges: dict[Edge, None] = {}

    def vertex(self, kind: Kind, name: str, label: str = "", group: str = "") -> str:
        """Add a vertex and return its identifier for edges."""
        id = f"{kind} {name}"
        self._vertices.setdefault(id, Vertex(id, kind, label or name, group))
        return id

    def edge(self, source: str, target: str, label: str = "") -> None:
        """Add an edge between two vertices of the graph."""
        self._edges.setdefault(Edge(source, target, label))

    def done(self) -> Graph:
        """Return the graph."""
        return Graph(self._title, tuple(self._vertices.values()), tuple(self._edges))


# --- the whole graph ----------------------------------------------------------------


class Relation(NamedTuple):
    """A relation between two parts of a library."""

    source: tuple[Kind, str]
    #: `submits`, `calls`, `requests`, `enables`, `asks`, `waits for`, `notes`,
    #: `asserts`, `erases`, `may change`, `claims`, `uses`, `tells`.
    relation: str
    target: tuple[Kind, str]
    #: The label: the method that calls or claims (`plan` for a call by plans), the
    #: clause with the query, or the priority of a task.
    label: str = ""


def library_graph(library: Library) -> networkx.MultiDiGraph[str]:
    """Return all names of a library and their relations as one directed graph.

    A node is called `KIND NAME`, for example `rap fill-order`. The attributes of a node
    are `kind`, `name` and, where a form declares the name, `file` and `row`. An edge
    leads from the part that calls, queries, changes or claims to the called or affected
    part. The attributes of an edge are `relation` and `label`, see `Relation`.
    """
    import networkx  # noqa: PLC0415  # the import takes longer than a check

    graph: networkx.MultiDiGraph[str] = networkx.MultiDiGraph(name="library")
    for kind, name, form in _declared(library):
        source = library.files.get(form.span.file)
        place = {} if source is None else {"row": source.row(form.span.start)}
        graph.add_node(
            f"{kind} {name}", kind=kind, name=name, file=form.span.file, **place
        )
    for at, one in enumerate(dict.fromkeys(_relations(library))):
        for kind, name in (one.source, one.target):
            if f"{kind} {name}" not in graph:
                graph.add_node(f"{kind} {name}", kind=kind, name=name)
        graph.add_edge(
            f"{one.source[0]} {one.source[1]}",
            f"{one.target[0]} {one.target[1]}",
            relation=one.relation,
            label=one.label,
            order=at,
        )
    return graph


Declared = (
    nodes.DefineAgenda
    | nodes.DefineRap
    | nodes.DefineQuery
    | nodes.DeclarePrimitive
    | nodes.DeclareSkill
    | nodes.DeclareProposition
    | nodes.DeclareProperty
    | nodes.DeclareDatum
    | nodes.DeclareEvent
)


def _declared(library: Library) -> Iterator[tuple[Kind, str, Declared]]:
    """Yield the declarations of a library, with kind and name."""
    tables: tuple[tuple[Kind, Iterable[Declared]], ...] = (
        ("agenda", library.agendas.values()),
        ("rap", library.raps.values()),
        ("query", library.queries.values()),
        ("primitive", library.primitives.values()),
        ("skill", library.skills.values()),
        ("fact", library.propositions.values()),
        ("fact", library.properties.values()),
        ("datum", library.data.values()),
        ("event", library.events.values()),
    )
    for kind, forms in tables:
        for form in forms:
            yield kind, form.name, form


def _relations(library: Library) -> Iterator[Relation]:
    """Yield the relations between the parts of a library."""
    for agenda in library.agendas.values():
        for task in agenda.tasks:
            label = f"priority {task.priority}" if task.priority else ""
            target: tuple[Kind, str] = ("rap", task.goal.name)
            yield Relation(("agenda", agenda.name), "submits", target, label)
    for rap in library.raps.values():
        yield from _of_rap(library, rap)
    for query in library.queries.values():
        yield from _asks(library, ("query", query.name), query.formula, "")
    for rule in library.memory_rules:
        for case in rule.cases:
            yield from _of_rules(library, ("rap", rule.index.name), case.rules)
    for heard in library.event_rules:
        yield from _of_rules(library, ("event", heard.signal), heard.rules)
    yield from _of_declarations(library)


def _of_declarations(library: Library) -> Iterator[Relation]:
    for primitive in library.primitives.values():
        own: tuple[Kind, str] = ("primitive", primitive.name)
        for on in primitive.on:
            yield from _changes(own, on.effects)
        for name in primitive.tells:
            yield Relation(own, "tells", ("datum", name))
        for thing in primitive.uses:
            yield Relation(own, "uses", ("thing", format_node(thing)))
    for datum in library.data.values():
        yield from _changes(("datum", datum.name), datum.on or ())
    for skill in library.skills.values():
        own = ("skill", skill.name)
        for thing in skill.uses:
            yield Relation(own, "uses", ("thing", format_node(thing)))
        for event in skill.events or ():
            yield Relation(own, "tells", ("event", event))


def _of_rap(library: Library, rap: nodes.DefineRap) -> Iterator[Relation]:
    own: tuple[Kind, str] = ("rap", rap.name)
    for at in formulas(rap):
        if at.clause.when != "wake":
            yield from _asks(library, own, at.formula, at.clause.word)
    if rap.monitor_state is not None:
        for name in facts_of(library, rap.monitor_state):
            yield Relation(own, "waits for", ("fact", name))
    for method in rap.methods:
        label = _called(rap, method)
        for kind, name in _asked(method):
            yield Relation(own, _CALLS[kind], (kind, name), label)
        for note in method.notations:
            yield Relation(own, "notes", ("fact", note.name), label)
        for thing in method.claims:
            yield Relation(own, "claims", ("thing", format_node(thing)), label)
    for name in usable_in_plans(library.raps, rap):
        yield Relation(own, "calls", ("rap", name), "plan")


def _asks(
    library: Library, source: tuple[Kind, str], formula: nodes.Formula, clause: str
) -> Iterator[Relation]:
    """Yield the facts and named queries that a formula itself contains."""
    for part in subformulas(formula):
        if isinstance(part, nodes.Proposition) and part.name not in library.functions:
            kind: Kind = "query" if part.name in library.queries else "fact"
            yield Relation(source, "asks", (kind, part.name), clause)


def _changes(
    source: tuple[Kind, str], effects: Iterable[nodes.DeclaredEffect]
) -> Iterator[Relation]:
    for effect in effects:
        label = "erases" if effect.negated else "asserts"
        label = "may change" if effect.possible else label
        yield Relation(source, label, ("fact", effect.pattern.name))


def _of_rules(
    library: Library, source: tuple[Kind, str], rules: Iterable[nodes.Rule]
) -> Iterator[Relation]:
    """Yield the queries and effects of the rules of a RAP or an event."""
    for alternative in (one for rule in rules for one in rule.alternatives):
        yield from _asks(library, source, alternative.query, "rule")
        for action in alternative.actions:
            relation = "asserts" if action.op == "mem-add" else "erases"
            yield Relation(source, relation, ("fact", action.pattern.name), "rule")


_CALLS: dict[Kind, str] = {
    "primitive": "requests",
    "skill": "enables",
    "rap": "calls",
}
"""The relation of a method to a RAP, primitive or skill that it calls or enables."""

_CALLING = {"submits", *_CALLS.values()}


def _edges(
    graph: networkx.MultiDiGraph[str], relations: Iterable[str]
) -> list[tuple[str, str, str, str]]:
    """Return the edges of some relations, in the order of the text.

    Each edge is a tuple of source, target, relation and label.
    """
    found = [
        (data["order"], source, target, data["relation"], data["label"])
        for source, target, data in graph.edges(data=True)
        if data["relation"] in set(relations)
    ]
    return [edge[1:] for edge in sorted(found)]


def _drawn(
    graph: networkx.MultiDiGraph[str],
    title: str,
    edges: Iterable[tuple[str, str, str]],
    more: Iterable[str] = (),
) -> Graph:
    """Return a drawing of some edges (source, target, label) and their nodes."""
    drawing = GraphDrawing(title)
    for node in more:
        drawing.vertex(graph.nodes[node]["kind"], graph.nodes[node]["name"])
    for source, target, label in edges:
        for node in (source, target):
            drawing.vertex(graph.nodes[node]["kind"], graph.nodes[node]["name"])
        drawing.edge(source, target, label)
    return drawing.done()


# --- parts of the graph ---------------------------------------------------------------


def calls(library: Library) -> Graph:
    """Return the calls of RAPs, primitives and skills, by RAP and method."""
    graph = library_graph(library)
    edges = [(s, t, label) for s, t, _, label in _edges(graph, _CALLING)]
    agendas = [f"agenda {name}" for name in library.agendas]
    raps = [f"rap {name}" for name in library.raps]
    return _drawn(graph, "calls", edges, [*agendas, *raps])


def monitors(library: Library) -> Graph:
    """Return the facts that wake each RAP, and the declared effects on facts."""
    graph = library_graph(library)
    woken = _edges(graph, ["waits for"])
    heard = {fact for _, fact, _, _ in woken}
    changes = _edges(graph, ["notes", "asserts", "erases", "may change"])
    edges = [(fact, rap, "wakes") for rap, fact, _, _ in woken]
    edges += [
        (source, fact, relation)
        for source, fact, relation, label in changes
        if fact in heard
    ]
    return _drawn(graph, "monitors", edges)


def things(library: Library) -> Graph:
    """Return the things that methods claim and that primitives and skills use."""
    graph = library_graph(library)
    edges = [
        (source, thing, " ".join(filter(None, (relation, label))))
        for source, thing, relation, label in _edges(graph, ["claims", "uses"])
    ]
    return _drawn(graph, "claims and uses", edges)


def everything(library: Library) -> Graph:
    """Return the whole graph as a drawing."""
    graph = library_graph(library)
    edges = [
        (source, target, " ".join(filter(None, (relation, label))))
        for source, target, relation, label in _edges(graph, _all_relations(graph))
    ]
    return _drawn(graph, "library", edges, graph.nodes)


def dependents(library: Library, name: str) -> Graph:
    """Return all parts that depend on a name, directly or indirectly.

    Args:
        library: the library.
        name: a name of the library, or `KIND NAME` if several kinds share the name.

    Raises:
        KeyError: if the name is not in the library.
    """
    import networkx  # noqa: PLC0415

    graph = library_graph(library)
    targets = [node for node in graph if name in (node, graph.nodes[node]["name"])]
    if not targets:
        raise KeyError(name)
    inside = set(targets)
    for target in targets:
        inside |= networkx.ancestors(graph, target)
    edges = [
        (source, target, " ".join(filter(None, (relation, label))))
        for source, target, relation, label in _edges(graph, _all_relations(graph))
        if source in inside and target in inside
    ]
    return _drawn(graph, f"what depends on {name}", edges, targets)


def recursive(library: Library) -> Graph:
    """Return the RAPs on cycles of calls, one group for each component."""
    import networkx  # noqa: PLC0415

    graph = library_graph(library)
    called = _edges(graph, ["calls"])
    calling: networkx.DiGraph[str] = networkx.DiGraph(
        [(source, target) for source, target, _, _ in called]
    )
    drawing = GraphDrawing("recursive RAPs")
    groups = [
        members
        for members in networkx.strongly_connected_components(calling)
        if len(members) > 1 or any(calling.has_edge(one, one) for one in members)
    ]
    order = {node: at for at, node in enumerate(graph)}
    rows = sorted([sorted(members, key=order.__getitem__) for members in groups])
    for at, members in enumerate(rows):
        for node in members:
            drawing.vertex("rap", graph.nodes[node]["name"], group=f"cycle {at + 1}")
        for source, target, _, label in called:
            if source in members and target in members:
                drawing.edge(source, target, label)
    return drawing.done()


def dominators(library: Library, name: str) -> Graph:
    """Return the dominator tree of the calls below a RAP.

    An edge leads from a RAP to each RAP, primitive and skill whose immediate dominator
    is that RAP.

    Raises:
        KeyError: if the library does not have the RAP.
    """
    import networkx  # noqa: PLC0415

    graph = library_graph(library)
    if name not in library.raps:
        raise KeyError(name)
    called = _edges(graph, _CALLING)
    calling: networkx.DiGraph[str] = networkx.DiGraph(
        [(source, target) for source, target, _, _ in called]
    )
    root = f"rap {name}"
    calling.add_node(root)
    found = networkx.immediate_dominators(calling, root)
    order = {node: at for at, node in enumerate(graph)}
    edges = [
        (before, node, "")
        for node, before in sorted(found.items(), key=lambda one: order[one[0]])
        if before is not None and before != node
    ]
    return _drawn(graph, f"dominators of {name}", edges, [root])


def _all_relations(graph: networkx.MultiDiGraph[str]) -> set[str]:
    return {data["relation"] for _, _, data in graph.edges(data=True)}


def facts_of(library: Library, formula: nodes.Formula) -> Iterator[str]:
    """Yield the facts that a formula queries, also through named queries."""
    parts = through_queries(formula, library.queries)
    asked = [part.name for part in parts if isinstance(part, nodes.Proposition)]
    for name in dict.fromkeys(asked):
        if name in library.propositions or name in library.properties:
            yield name


def _asked(method: nodes.Method) -> Iterator[tuple[Kind, str]]:
    """Yield the kinds and names of the RAPs, primitives and skills a method calls."""
    body = method.body
    if isinstance(body, nodes.Primitive):
        yield "primitive", body.request.name
    elif isinstance(body, nodes.Skills):
        yield from (("skill", skill.name) for skill in body.enable)
    yield from (("rap", step.goal.name) for step in steps(method))
    yield from (("skill", skill.name) for skill in method.skills)


def _called(rap: nodes.DefineRap, method: nodes.Method) -> str:
    """Return the label of a method; empty for a single method without a name."""
    if method.name is None and len(rap.methods) == 1:
        return ""
    return str(method.name) if method.name is not None else f"#{method.position}"


# --- task-nets ----------------------------------------------------------------------


def task_nets(rap: nodes.DefineRap) -> Graph:
    """Return the steps of each method of a RAP, with their order and endings.

    A solid arrow without a label is an order. Labels name the other annotations: the
    formula that a step protects, the step that ends another step, windows and signals.
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
                for source, target, label in _arrows(step.tag, note):
                    if not tags.issuperset((source, target)):
                        continue  # a tag that names no step
                    drawing.edge(
                        f"step {group}/{source}", f"step {group}/{target}", label
                    )
    return drawing.done()


def _arrows(tag: str, note: nodes.Annotation) -> Iterator[tuple[str, str, str]]:
    """Yield the arrows of an annotation: source tag, target tag and label."""
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
