"""Sets and counters (T 4.8): their first values, and their use in all RAPs below.

A set without an initial value is empty when its task starts. A counter has its declared
number, or 0 (T 4.8.1). Only the steps and requests of the task's methods change these
values. A condition that is evaluated before the first method is therefore evaluated
with the first values.

A step passes a resource as an input (T 4.8.2). The use of the input in the called RAP
and in its descendants is summarised by input: the operations that change the resource,
and whether a formula queries the resource.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import msgspec

from rapc.analysis.facts.index import Index
from rapc.analysis.facts.logic import Literal, literals, number_of
from rapc.analysis.facts.statistics import LIMITS
from rapc.base.values import Number, holds_between
from rapc.ir import nodes
from rapc.library.library import Library


class FirstValues:
    """The values of the resources of one RAP when its task starts.

    Args:
        resources: the declared resources; a resource that starts as a copy of another
            resource has no known value.
    """

    def __init__(self, resources: Iterable[nodes.Resource]) -> None:
        self._counters: dict[str, Number] = {}
        self._sets: set[str] = set()
        for one in resources:
            first = 0 if one.initial is None else number_of(one.initial)
            if one.kind == "counter" and first is not None:
                self._counters[one.variable.name] = first
            elif one.kind == "set" and one.initial is None:
                self._sets.add(one.variable.name)

    def fails(self, formula: nodes.Formula | None) -> Literal | None:
        """Return a literal of a conjunction that does not hold at the start, if any."""
        if not self._counters and not self._sets:
            return None
        for literal in literals(formula):
            if self._holds(literal) is False:
                return literal
        return None

    def holds(self, formula: nodes.Formula) -> bool:
        """Return whether a conjunction is about resources only, and holds at first."""
        if not self._counters and not self._sets:
            return False
        found = [self._holds(literal) for literal in literals(formula)]
        return bool(found) and all(one is True for one in found)

    def _holds(self, literal: Literal) -> bool | None:
        formula, value = literal.formula, None
        if isinstance(formula, nodes.SetTest) and formula.args:
            if self._is_empty(formula.args[0]):
                value = formula.test == "empty"
        elif isinstance(formula, nodes.Compare):
            left, right = self._number(formula.left), self._number(formula.right)
            if left is not None and right is not None:
                value = holds_between(formula.op, left, right)
        return value if value is None else value is literal.holds

    def _is_empty(self, term: nodes.Term) -> bool:
        return isinstance(term, nodes.Var) and term.name in self._sets

    def _number(self, term: nodes.Term) -> Number | None:
        if not isinstance(term, nodes.Call) or len(term.args) != 1:
            return number_of(term)
        (arg,) = term.args
        if not isinstance(arg, nodes.Var):
            return None
        if term.function == "size-of":
            return 0 if self._is_empty(arg) else None
        return self._counters.get(arg.name) if term.function == "value" else None


class Flow(msgspec.Struct):
    """The use of a resource, or of an input that may be a resource."""

    changes: list[nodes.ResourceChange]
    #: The places that query the resource.
    asked: list[nodes.Var]
    #: The inputs that receive the resource, by RAP and position.
    given: list[tuple[str, int]]
    #: Whether the resource is used in a way that the check cannot follow.
    escapes: bool = False


Flows = Mapping[tuple[int, str], Flow]
"""By the `id` of a RAP and the name of a variable in the RAP."""


def flows(index: Index) -> Flows:
    """Return the use that each RAP itself makes of its resources and inputs."""
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
    """Return the use of a resource in a RAP and in all RAPs that receive it."""
    total = Flow(list(flow.changes), list(flow.asked), list(flow.given), flow.escapes)
    waiting, seen = list(flow.given), set(flow.given)
    while waiting and not total.escapes:
        if len(seen) > LIMITS.resource_inputs:
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


def _new(
    given: Iterable[tuple[str, int]], seen: set[tuple[str, int]]
) -> list[tuple[str, int]]:
    return [one for one in given if one not in seen]
