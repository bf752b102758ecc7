"""What RAPs do with the sets and counters that they are given (T 4.8.2).

A step hands on a resource as an input. What its RAP does with that, and what the RAPs
below do, is summed up by input: which words change it, and whether it is asked about.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import msgspec

from rapc.analysis.index import Index
from rapc.ir import nodes
from rapc.library.library import Library


class Flow(msgspec.Struct):
    """What becomes of a resource, or of an input that may be one."""

    changes: list[nodes.ResourceChange]
    #: Where it is asked about.
    asked: list[nodes.Var]
    #: The inputs that it is handed on to, by RAP and position.
    given: list[tuple[str, int]]
    #: Whether something else is made of it, so that nobody knows what becomes of it.
    escapes: bool = False


Flows = Mapping[tuple[int, str], Flow]
"""By the `id` of a RAP and the name of a variable in it."""


def flows(index: Index) -> Flows:
    """Return what each RAP itself does with its resources and inputs."""
    found: dict[tuple[int, str], Flow] = {}
    declared: set[int] = set()
    for rap in index.of(nodes.DefineRap):
        for variable in (*rap.node.inputs, *(r.variable for r in rap.node.resources)):
            found[id(rap.node), variable.name] = Flow([], [], [])
            declared.add(id(variable))
    for use in index.of(nodes.Var):
        flow = found.get((id(use.owner), use.node.name))
        if flow is None or id(use.node) in declared:
            continue
        parent = use.parent
        if isinstance(parent, nodes.ResourceChange) and parent.resource is use.node:
            flow.changes.append(parent)
        elif isinstance(parent, nodes.SetTest | nodes.Call):
            flow.asked.append(use.node)
        elif isinstance(parent, nodes.Goal) and any(a is use.node for a in parent.args):
            at = next(i for i, arg in enumerate(parent.args) if arg is use.node)
            flow.given.append((parent.name, at))
        else:
            flow.escapes = True
    return found


def overall_use(flow: Flow, every: Flows, library: Library) -> Flow:
    """Return what becomes of a resource here and in all that it is handed on to."""
    total = Flow(list(flow.changes), list(flow.asked), list(flow.given), flow.escapes)
    waiting, seen = list(flow.given), set(flow.given)
    while waiting and not total.escapes:
        if len(seen) > _MOST:
            total.escapes = True
            break
        name, at = waiting.pop()
        rap = library.raps.get(name)
        if rap is None or not rap.methods or at >= len(rap.inputs):
            total.escapes = True
            break
        below = every[id(rap), rap.inputs[at].name]
        total.changes += below.changes
        total.asked += below.asked
        total.escapes = total.escapes or below.escapes
        for one in _new(below.given, seen):
            seen.add(one)
            waiting.append(one)
    return total


_MOST = 200
"""To so many inputs a resource is followed."""


def _new(
    given: Iterable[tuple[str, int]], seen: set[tuple[str, int]]
) -> list[tuple[str, int]]:
    return [one for one in given if one not in seen]
