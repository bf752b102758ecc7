"""The interface between a run and the planner of its host [L 10].

The interpreter asks the planner when no method of a RAP with `(plan)` holds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import msgspec

from rapc.base.resources import Value
from rapc.base.values import Fact, Number
from rapc.compiler.program import Program
from rapc.compiler.query.term_value import TermValue
from rapc.events import PlanLink, PlanStep
from rapc.ir import nodes, walk
from rapc.ir.printer import format_node
from rapc.runtime.memory.access import MemoryView
from rapc.runtime.query_context import QueryContext

BUILT_IN = "builtin"
"""The name of the planner that is a part of rapc."""

PLAN = "(plan)"
"""The beginning of the goals by which the answers of planners are kept."""


class PlanRequest(NamedTuple):
    """A task that needs a plan, and what its planner may know."""

    library: Program
    rap: nodes.DefineRap
    #: The values of the inputs.
    values: Mapping[str, Value]
    memory: MemoryView
    #: Computes a term with some variables bound; None for a value that is no number.
    compute: Callable[[nodes.Term, Mapping[str, Value]], Number | None]
    #: The name of the new method.
    name: str
    #: The last plan of the task, whose steps may still be useful.
    last: nodes.Method | None
    #: The goals of steps that have failed, used only if there is no other plan, and as
    #: late as possible.
    avoided: Sequence[Fact]
    #: The goals of steps that have failed too often.
    failed: Sequence[Fact]
    #: The greatest number of states to look at, and of those for a cheaper plan.
    limit: int
    tries: int


class Planned(msgspec.Struct, frozen=True):
    """The answer of a planner."""

    #: `solved`, `unsolvable` or `limit`.
    outcome: str
    method: nodes.Method | None
    #: The number of states that the planner looked at.
    expanded: int
    #: The number of parts of RAPs that the planner did not see.
    left_out: int
    #: The parts of the goal that nothing brings about, as text.
    unreachable: tuple[str, ...] = ()
    #: For each step the parts of the goal that the step makes true, as text.
    achieved: tuple[tuple[str, ...], ...] = ()
    #: The planner that was asked last: `builtin`, or the name of an engine.
    engine: str = BUILT_IN
    #: The reason why the answer of an engine was not used; empty if there is none.
    refused: str = ""

    @property
    def steps(self) -> tuple[PlanStep, ...]:
        """Return the steps with their purposes, in an order that the plan allows."""
        return steps_of(self.method, self.achieved)


def steps_of(
    method: nodes.Method | None, achieved: Sequence[Sequence[str]]
) -> tuple[PlanStep, ...]:
    """Return the steps of the method of a plan, with their purposes.

    Args:
        method: the method, or None.
        achieved: the parts of the goal that the steps make true, by position.
    """
    found = []
    for at, step in enumerate(() if method is None else walk.steps(method)):
        links, before = list[PlanLink](), list[str]()
        for one in step.annotations:
            if isinstance(one, nodes.For) and one.formula is not None:
                links.append(PlanLink(one.tag, format_node(one.formula)))
            elif isinstance(one, nodes.For):
                before.append(one.tag)
        parts = achieved[at] if at < len(achieved) else ()
        links += [PlanLink(None, part) for part in parts]
        goal = format_node(step.goal)
        found.append(PlanStep(step.tag, goal, tuple(links), tuple(before)))
    return tuple(found)


def computed(
    context: QueryContext, term: nodes.Term, values: Mapping[str, Value]
) -> Number | None:
    """Return the number that a term has in memory; None for any other value."""
    found = TermValue(term, "duration").value(context, values)
    return found if isinstance(found, int | float) else None


Planner = Callable[[PlanRequest], Planned]
