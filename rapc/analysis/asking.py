"""What a RAP asks the world and other RAPs for, and how long it waits meanwhile."""

from __future__ import annotations

import msgspec

from rapc.analysis.endless import is_never
from rapc.analysis.literals import literals, number_of
from rapc.base.values import Number
from rapc.ir import nodes
from rapc.ir.walk import steps


class Pause(msgspec.Struct, frozen=True, gc=False):
    """How long a standing RAP surely waits between two rounds, and what says so."""

    every: Number
    start: int
    end: int


class Asking(msgspec.Struct, frozen=True, gc=False):
    """What a RAP asks for by itself, each once."""

    rap: str
    #: The RAPs that its steps ask for.
    calls: tuple[str, ...]
    #: The primitives that its methods request.
    requests: tuple[str, ...]
    #: The names of the facts that its methods note.
    notes: tuple[str, ...]
    pause: Pause | None


def asking(rap: nodes.DefineRap) -> Asking:
    """Return what a RAP asks for by itself."""
    calls: dict[str, None] = {}
    requests: dict[str, None] = {}
    notes: dict[str, None] = {}
    for method in rap.methods:
        if isinstance(method.body, nodes.Primitive):
            requests[method.body.request.name] = None
        for step in steps(method):
            calls[step.goal.name] = None
        for note in method.notations:
            notes[note.name] = None
    return Asking(rap.name, tuple(calls), tuple(requests), tuple(notes), _pause(rap))


def _pause(rap: nodes.DefineRap) -> Pause | None:
    if rap.succeed is None or not is_never(rap.succeed):
        return None
    timed = rap.monitor_time
    if timed is not None and timed.reference == "now":
        start = number_of(timed.start)
        if start is not None and start > 0:
            return Pause(start, timed.span.start, timed.span.end)
    for one in literals(rap.monitor_state):
        if isinstance(one.formula, nodes.Believe) and not one.holds:
            age = number_of(one.formula.age)
            if age is not None and age > 0:
                return Pause(age, one.span.start, one.span.end)
    return None
