"""Plans for programs and for the command line: `rapc.plan` and `rapc plan`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from msgspec.structs import replace

from rapc.base.names import plural
from rapc.base.source import place
from rapc.base.values import Number, readable
from rapc.compiler.program import Program
from rapc.events import PlanStep
from rapc.ir import nodes
from rapc.ir.printer import format_node
from rapc.library.operators import Model
from rapc.planning.ground import Computing
from rapc.planning.pddl import written
from rapc.planning.sketch import achieved, method
from rapc.planning.solver import Engine, Solution, situation, solve
from rapc.runtime.memory.access import MemoryView
from rapc.runtime.planner import steps_of
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
        #: The planner that was asked last: `builtin`, or the name of an engine.
        self.engine = found.engine
        #: The reason why the answer of an engine was not used; empty if there is none.
        self.refused = found.refused
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
        #: The parts of the goal that the planner did not see, and took to hold.
        self.unseen = tuple(
            [
                f"{format_node(one.part)}: {one.reason}"
                for one in found.left_out
                if one.rap == rap.name
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

    @cached_property
    def steps(self) -> tuple[PlanStep, ...]:
        """Return the steps with their purposes, in an order that the plan allows."""
        parts = () if self._sketch is None else achieved(self._sketch)
        return steps_of(self.method, parts)

    @property
    def summary(self) -> str:
        """Return the size of the plan, or the reason why there is none, as a line."""
        if self:
            steps, states = plural(len(self.steps), "step"), self.expanded
            size = f"{steps} of {plural(self.operators, 'operator')}"
            cost = (
                f", cost {readable(self.cost)}" if self.cost != len(self.steps) else ""
            )
            return f"{size}, {plural(states, 'state')}{cost}"
        if self.unreachable:
            said = f"no plan: nothing brings about {', '.join(self.unreachable)}"
            return said if self.operators else f"{said}: no RAP is an operator"
        if self.reason == "limit":
            return f"no plan: limit of {plural(self.expanded, 'state')} reached"
        return "no plan: the operators cannot bring about all parts of the goal"

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
    engine: Engine | None,
    compute: Computing,
) -> Plan:
    """Return a plan for the goal of a RAP in the situation of a memory."""
    model = Model(program.library, program.signatures, use or None)
    goal = model.goal(rap, {})
    found = solve(
        model,
        situation(memory),
        goal,
        limit=limit,
        tries=tries,
        engine=engine,
        compute=compute,
    )
    return Plan(program, rap, model, found)
