"""Which RAPs are never done: with `(succeed nil)`, or a step that has it."""

from __future__ import annotations

from collections.abc import Container, Iterable, Mapping
from functools import cached_property

from rapc.analysis.effects import calls_of
from rapc.base.graph import components
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.ir.walk import steps
from rapc.library.library import Library


def is_never(formula: nodes.Formula) -> bool:
    """Whether a formula says itself that it never holds: `nil`, `(not true)`."""
    if isinstance(formula, nodes.Not):
        return isinstance(formula.part, nodes.Truth) and formula.part.value
    return isinstance(formula, nodes.Truth) and not formula.value


def endless(raps: Mapping[str, nodes.DefineRap]) -> Mapping[str, Span]:
    """Return those of `raps` that stand by for good, each with the clause that says so.

    Steps for other RAPs count as done some time. A RAP without `succeed` is done when a
    method has ended well: never, if each of its methods has a step that is never done
    and that nothing ends.
    """
    found: dict[str, Span] = {}
    for rap in raps.values():
        waits = rap.monitor_state is not None or rap.monitor_time is not None
        if waits and rap.succeed is not None and is_never(rap.succeed):
            found[rap.name] = rap.succeed.span
    if not found:
        return found
    calls = {rap.name: calls_of(rap) for rap in raps.values()}
    order = [
        raps[name]
        for members in components(calls, lambda name: calls.get(name, ()))
        for name in members
        if name in raps
    ]
    grown = True
    while grown:
        grown = False
        for rap in order:
            if rap.name in found or rap.succeed is not None or not rap.methods:
                continue
            causes = [_endless_step(method, found) for method in rap.methods]
            if all(causes):
                found[rap.name] = next(cause for cause in causes if cause)
                grown = True
    return found


class NeverDone(Container[str]):
    """The RAPs that never end well by themselves; all are looked at when one is asked.

    Args:
        raps: the RAPs of a library.
    """

    def __init__(self, raps: Mapping[str, nodes.DefineRap]) -> None:
        self._raps = raps

    def __contains__(self, name: object) -> bool:
        rap = self._raps.get(name) if isinstance(name, str) else None
        if rap is None:
            return False
        goal = rap.succeed
        return (goal is not None and is_never(goal)) or name in self._endless

    @cached_property
    def _endless(self) -> Mapping[str, Span]:
        return endless(self._raps)


def reached(library: Library, names: Iterable[str]) -> dict[str, nodes.DefineRap]:
    """Return the RAPs called `names` and all that their steps lead to.

    Others are not looked at: a compiled library need not read them.
    """
    found: dict[str, nodes.DefineRap] = {}
    stack = list(names)
    while stack:
        name = stack.pop()
        if name not in found and name in library.raps:
            found[name] = library.raps[name]
            stack.extend(calls_of(found[name]))
    return found


def below_agendas(library: Library) -> dict[str, nodes.DefineRap]:
    """Return the RAPs that tasks of agendas lead to."""
    agendas = library.agendas.values()
    return reached(library, [one.goal.name for a in agendas for one in a.tasks])


def _endless_step(method: nodes.Method, found: Mapping[str, Span]) -> Span | None:
    for step in steps(method):
        if step.goal.name in found and not any(map(may_end, step.annotations)):
            return found[step.goal.name]
    return None


def may_end(note: nodes.Annotation) -> bool:
    """Whether an annotation of a step may end it before it is done."""
    if isinstance(note, nodes.WaitFor):
        return note.mode != "proceed"
    return isinstance(note, nodes.UntilStart | nodes.UntilEnd | nodes.Window)
