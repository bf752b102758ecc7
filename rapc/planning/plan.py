"""Plans for programs and for the command line: `rapc.plan` and `rapc plan`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from msgspec.structs import replace

from rapc.base.names import plural
from rapc.base.source import place
from rapc.base.values import Number
from rapc.compiler.program import Program
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.planning.model import Model
from rapc.planning.pddl import written
from rapc.planning.sketch import link_texts, method
from rapc.planning.solver import Solution, situation, solve
from rapc.runtime.memory.access import MemoryView
from rapc.worlds.scripted import ScriptedWorld


def still_world(program: Program) -> ScriptedWorld:
    """Return a world in which no primitive has a result, for a memory without a run."""
    return ScriptedWorld([], declared=program.library)


class Plan:
    """A plan for a goal, or the reason why there is none; false without a plan."""

    def __init__(
        self, program: Program, rap: nodes.DefineRap, model: Model, found: Solution
    ) -> None:
        #: `solved`, `unsolvable` or `limit`.
        self.reason = found.outcome
        #: The sum of the costs of the steps.
        self.cost: Number = found.cost
        #: The number of states that the search looked at.
        self.expanded = found.expanded
        #: The parts of the goal that nothing brings about.
        self.unreachable = found.unreachable
        #: The number of RAPs that may be used.
        self.operators = len({one.rap.name for one in model.operators})
        #: The parts of RAPs that the planner did not see, with their positions.
        self.left_out = tuple(
            [
                f"{place(one.span, program.library.files)}: {one}"
                for one in found.left_out
            ]
        )
        self._sketch, self._rap, self._problem = found.sketch, rap, found.problem

    def __bool__(self) -> bool:
        return self.reason == "solved"

    def __repr__(self) -> str:
        return f"<rapc.Plan: {self.reason}, {plural(len(self.steps), 'step')}>"

    @cached_property
    def method(self) -> nodes.Method | None:
        """Return the method of the plan, or None."""
        return None if self._sketch is None else method(self._sketch, "plan-1", {})

    @property
    def text(self) -> str:
        """Return the RAP of the goal with the method of the plan, as one line."""
        methods = () if self.method is None else (self.method,)
        return format_node(replace(self._rap, methods=methods))

    @property
    def steps(self) -> tuple[str, ...]:
        """Return the goals of the steps, as text, in an order that the plan allows."""
        body = None if self.method is None else self.method.body
        if not isinstance(body, nodes.TaskNet):
            return ()
        return tuple([format_node(step.goal) for step in body.steps])

    @property
    def links(self) -> tuple[tuple[str, ...], ...]:
        """Return for each step what it serves: `2: (on-tray meals ward-4)`."""
        return () if self._sketch is None else link_texts(self._sketch)

    @property
    def order(self) -> tuple[tuple[int, int], ...]:
        """Return pairs of numbers of steps: the first ends before the second starts."""
        order = () if self._sketch is None else self._sketch.order
        return tuple([(first + 1, second + 1) for first, second in order])

    def pddl(self, *, costs: bool = True) -> tuple[str, str] | None:
        """Return the domain and the problem as PDDL; None if they are too large.

        Args:
            costs: whether actions have their costs, if these are different whole
                numbers.
        """
        return (
            None if self._problem is None else written(self._problem, costs=costs)[:2]
        )


def plan(  # each goes by name
    program: Program,
    rap: nodes.DefineRap,
    memory: MemoryView,
    *,
    use: Sequence[str],
    limit: int,
    tries: int,
) -> Plan:
    """Return a plan for the goal of a RAP in the situation of a memory."""
    model = Model(program.library, program.signatures, use or None)
    goal = model.goal(rap, {})
    found = solve(model, situation(memory), goal, limit=limit, tries=tries)
    return Plan(program, rap, model, found)
