"""No change that could wake or block a task is missed, whatever its formula.

Random formulas wait for random changes of memory, time and resources; after each, a
task stands on the agenda exactly if its formula holds when it is asked anew.
"""

from __future__ import annotations

import random

import msgspec
from hypothesis import given
from hypothesis import strategies as st

from rapc.base.resources import Counter, SetResource
from rapc.base.source import SourceFile
from rapc.compiler.compiler import Compiler
from rapc.compiler.rap_plan import RapPlan
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.library.library import link
from rapc.parser.parse import parse
from rapc.runtime.monitors.monitors import Monitors
from rapc.runtime.state.agenda import Agenda
from rapc.runtime.state.task import Task
from rapc.runtime.state.things import Things
from tests.compiler.dice import ATOMS, Dice, dice, sizes
from tests.compiler.memories import SIGNATURES, Memories, apply, memories, query
from tests.effort import examples

TASKS, CHANGES = 3, 10


def _watch(formula: nodes.Formula, names: tuple[str, ...]) -> RapPlan:
    """A RAP that waits for a formula, with variables of it for inputs."""
    source = SourceFile("t.rap", "(define-rap (watch) (succeed nil))")
    parsed = parse(source)
    [node] = parsed.forms
    assert isinstance(node, nodes.DefineRap)
    compiler = Compiler(link([parsed])[0])
    compiler.signatures = SIGNATURES
    inputs = tuple([nodes.Var(name) for name in names])
    changed = msgspec.structs.replace(node, monitor_state=formula, inputs=inputs)
    return RapPlan(compiler, changed)


class Sleepers:
    """Some monitored tasks, as a run would have them, without the run."""

    def __init__(self, thrown: Dice, both: Memories, leaves: int) -> None:
        self.both = both
        self.agenda = Agenda(random.Random(0))
        self.monitors = Monitors(both.context, both.recorder, self.agenda, Things())
        both.memory.observe(self.monitors.listeners)
        self.tasks: list[Task] = []
        for number in range(1, TASKS + 1):
            formula, env = thrown.formula(leaves), thrown.env()
            task = Task(_watch(formula, tuple(env)), None, None)
            task.number, task.env = number, env
            task.goal_args = tuple(env.values())
            self.tasks.append(task)
            self.monitors.first_test(task)

    def test_marked(self) -> None:
        """What a turn does before its choice."""
        monitors, look = self.monitors, self.monitors.next_look
        due = look is not None and self.both.recorder.time >= look
        if monitors.to_test or due:
            if due:
                assert monitors.due() == []
            monitors.test_marked()

    def compare(self, after: object) -> None:
        """Each task stands where its formula, asked anew, says it has to."""
        for task in self.tasks:
            clause = task.plan.monitor_state
            assert clause is not None
            expected = query(clause.formula).holds(self.both.context, task.env)
            told = f"{format_formula(clause.formula)} after {after}"
            assert (task in self.agenda) is expected, told

    def change_resource(self, thrown: Dice) -> None:
        """A set or counter of a task changes, as an effect would change it."""
        found = [v for task in self.tasks for v in task.env.values()]
        for value in found:
            if isinstance(value, SetResource) and thrown.odds(0.5):
                (value.add if thrown.odds(0.5) else value.remove)(thrown.one(ATOMS))
                self.monitors.listeners.resource_changed(value)
            elif isinstance(value, Counter):
                value.add(thrown.one((1, -1)))
                self.monitors.listeners.resource_changed(value)


@examples(400)
@given(dice(), sizes, st.integers(1, 6))
def test_waiting_task_is_registered_by_its_formula(
    thrown: Dice, size: int, leaves: int
) -> None:
    both = memories(thrown.changes(size))
    sleepers = Sleepers(thrown, both, leaves)
    sleepers.test_marked()
    sleepers.compare("the beginning")
    for _ in range(CHANGES):
        if thrown.odds(0.2):
            sleepers.change_resource(thrown)
            change: object = "a resource"
        else:
            change = thrown.change()
            apply(both, change)
        sleepers.test_marked()
        sleepers.compare(change)
