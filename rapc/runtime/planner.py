"""The interface between a run and the planner of its host [L 10].

The interpreter asks the planner when no method of a RAP with `(plan)` holds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import msgspec

from rapc.base.resources import Value
from rapc.base.values import Fact
from rapc.compiler.program import Program
from rapc.ir import nodes
from rapc.runtime.memory.access import MemoryView

PLAN = "(plan)"
"""The beginning of the goals by which the answers of planners are kept."""


class PlanRequest(NamedTuple):
    """A task that needs a plan, and what its planner may know."""

    library: Program
    rap: nodes.DefineRap
    #: The values of the inputs.
    values: Mapping[str, Value]
    memory: MemoryView
    #: The name of the new method.
    name: str
    #: The last plan of the task, whose steps may still be useful.
    last: nodes.Method | None
    #: The goals of steps that have failed, used only if there is no other plan.
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


Planner = Callable[[PlanRequest], Planned]
