"""The graph of operators: the facts that each needs and makes true."""

from __future__ import annotations

from collections.abc import Iterator

from rapc.base.graph import Edge, Graph, Vertex
from rapc.compiler.program import Program
from rapc.library.operators import Conjunction, Model


def operators(program: Program) -> Graph:
    """Return the operators of a library, the RAPs with `(plan)`, and their facts."""
    library = program.library
    model = Model(library, program.signatures)
    edges: dict[Edge, None] = {}
    for one in model.operators:
        rap = f"rap {one.rap.name}"
        for fact, word in _needs(one.conditions):
            edges[Edge(fact, rap, word)] = None
        for effect in one.effects:
            words = {"add": "asserts", "erase": "erases", "may": "may change"}
            word = words["may" if None in effect.args else effect.sort]
            edges[Edge(rap, f"fact {effect.name}", word)] = None
    for planned in library.raps.values():
        if planned.plan is not None:
            for branch in model.goal(planned):
                for fact, word in _needs(branch):
                    edges[Edge(fact, f"rap {planned.name}", word)] = None
    ends = dict.fromkeys([end for e in edges for end in (e.source, e.target)])
    parts = [(end, *end.split(" ", 1)) for end in ends]
    vertices = tuple([Vertex(end, kind, label) for end, kind, label in parts])
    return Graph("operators", vertices, tuple(edges))


def _needs(branch: Conjunction, word: str = "needed by") -> Iterator[tuple[str, str]]:
    """Yield the facts of a conjunction, each with its relation to the RAP."""
    for name, _ in branch.present:
        yield f"fact {name if isinstance(name, str) else name[0]}", word
    for part in branch.absent:
        yield from _needs(part, "prevents" if word == "needed by" else "needed by")
