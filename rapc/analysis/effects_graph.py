"""The effects of a RAP and its descendants, as a graph around the RAP.

`rapc.analysis.facts.effects` computes the facts that a RAP may assert or erase. This
module collects, along the steps of methods, the facts, requests, events and things that
the RAP may sense, wait for, request, use and claim.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rapc.analysis.facts.effects import Effect, Effects
from rapc.analysis.graphs import GraphDrawing, Kind, facts_of
from rapc.base.graph import Graph, reachable
from rapc.base.values import Atom, format_atom, format_list
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.ir.walk import steps
from rapc.library.library import Library, calls_of


class _Said(NamedTuple):
    """A thing, and the relation of the RAP to the thing."""

    verb: str
    kind: Kind
    #: The label that distinguishes the vertex from others of its kind.
    name: str
    label: str


_VERBS = (
    *("senses", "asserts", "erases", "waits for", "requests", "enables"),
    *("uses", "claims", "unknown effects of"),
)
"""The relations, in the order of the graph."""


def effects_of(library: Library, name: str) -> Graph:
    """Return the facts, events, requests and things that a RAP may affect or need.

    The relations are: sense, assert, erase, wait for, request, use and claim. An
    argument is written `?` unless the argument is a constant in every effect. A request
    has all its possible results. The last names are those with incomplete
    declarations.

    Args:
        library: the library.
        name: a RAP of the library.
    """
    drawing = GraphDrawing(f"effects of {name}")
    source = drawing.vertex("rap", name)
    summed = Effects(library)
    found = [*_facts(summed, name)]
    raps = library.raps
    every = reachable(
        [name], lambda name: calls_of(raps[name], raps) if name in raps else ()
    )
    for below in every:
        rap = raps.get(below)
        if rap is None or summed.is_open(below):
            found.append(_Said("unknown effects of", "rap", below, below))
        if rap is not None:
            found += _of_rap(library, rap)
    if library.event_rules:
        said = _Said("unknown effects of", "rap", "event rules", "event rules")
        found.append(said)
    for one in sorted(found, key=lambda one: _VERBS.index(one.verb)):
        target = drawing.vertex(one.kind, f"{one.verb} {one.name}", one.label)
        drawing.edge(source, target, one.verb)
    return drawing.done()


def _facts(summed: Effects, name: str) -> Iterator[_Said]:
    for effect in summed.known(name):
        said = _written(effect)
        yield _Said("erases" if effect.gone else "asserts", "fact", said, said)


def _written(effect: Effect) -> str:
    return format_list([effect.name, *map(_value, effect.values)])


def _value(value: object) -> str:
    return format_atom(value) if isinstance(value, Atom) else "?"


def _of_rap(library: Library, rap: nodes.DefineRap) -> Iterator[_Said]:
    if rap.monitor_state is not None:
        for name in facts_of(library, rap.monitor_state):
            yield _Said("waits for", "fact", name, name)
    for method in rap.methods:
        for thing in method.claims:
            yield _thing("claims", thing)
        for step in steps(method):
            for note in step.annotations:
                if isinstance(note, nodes.WaitFor):
                    yield _event(note)
        body = method.body
        if isinstance(body, nodes.Primitive):
            yield from _of_request(library, body.request)
        enabled = [*method.skills]
        if isinstance(body, nodes.Skills):
            yield from map(_event, body.waits)
            enabled += body.enable
        for skill in enabled:
            yield _Said("enables", "skill", skill.name, skill.name)
            declared = library.skills.get(skill.name)
            for thing in declared.uses if declared is not None else ():
                yield _thing("uses", thing)


def _of_request(library: Library, request: nodes.Request) -> Iterator[_Said]:
    form = library.primitives.get(request.name)
    results = ", ".join(form.results) if form is not None else ""
    label = f"{request.name}: {results}" if results else request.name
    yield _Said("requests", "primitive", request.name, label)
    if form is not None:
        for thing in form.uses:
            yield _thing("uses", thing)
        for name in form.tells:
            yield _Said("senses", "datum", name, name)


def _thing(verb: str, thing: nodes.Thing) -> _Said:
    """Return the relation to a thing; a variable may stand for any thing."""
    said = format_node(thing)
    return _Said(verb, "thing", said, said)


def _event(wait: nodes.WaitFor) -> _Said:
    return _Said("waits for", "event", wait.signal, wait.signal)
