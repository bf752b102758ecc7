"""Why a task does not go on, why a method is not chosen, why a query does not hold.

What is asked is what a cycle would ask, in its order [L 3]: inputs, `succeed`,
monitors, conditions, then the methods. A task that has ended is asked about as it stood
before its last cycle.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import msgspec

from rapc.base.names import did_you_mean
from rapc.compiler.rap_plan import MethodPlan
from rapc.debug.acts import live_task
from rapc.debug.clause import ClauseAsked, ask
from rapc.debug.history import History
from rapc.errors import ArgumentError
from rapc.events import Goal, TaskSelected
from rapc.ir import clauses
from rapc.parser.parse import parse_formula
from rapc.runtime.machine import Machine
from rapc.runtime.snapshot import AgendaEntry
from rapc.runtime.state.task import Task
from rapc.runtime.tasks.causes import Condition, conditions
from rapc.runtime.tasks.hold_things import asks_of
from rapc.runtime.tasks.start import read_inputs


class MethodAnswer(msgspec.Struct, frozen=True):
    """Whether a method could be chosen, and what speaks against it."""

    name: str
    #: Its context, asked; None for a method without one.
    context: ClauseAsked | None
    #: Whether an `otherwise` keeps it from holding: a method before it holds.
    otherwise: bool
    #: How often it has ended badly, and how often it was chosen.
    failures: int
    tries: int
    #: Who holds a thing that it would have to wait for; empty if nobody.
    held_by: str = ""
    #: Whether a problem solver has just brought it.
    solved: bool = False

    @property
    def holds(self) -> bool:
        """Whether its context holds."""
        return not self.otherwise and (self.context is None or self.context.holds)


class TaskAnswer(msgspec.Struct, frozen=True):
    """What keeps a task from going on, or from doing what was expected."""

    task: int
    goal: Goal
    #: The cycle at whose end it was asked, and whether that is in the past.
    cycle: int
    past: bool
    state: str
    waits_for: str
    #: The tasks that would come up before it, if it could go on.
    before_it: tuple[int, ...]
    #: The clauses of the task, in the order of a cycle.
    clauses: tuple[ClauseAsked, ...]
    methods: tuple[MethodAnswer, ...]
    #: The method under way, if there is one.
    under_way: str | None


CLAUSES = tuple(clause.word for clause in clauses.RAP if not clause.hands_on)
"""The clauses of a RAP that can be asked about by their names."""


def why_not_query(history: History, text: str) -> ClauseAsked:
    """Ask memory a formula conjunct by conjunct.

    Raises:
        TextError: if `text` is no formula.
        ValueError: for names that the library does not declare.
    """
    history.run.question(text)  # looks at the names
    formula = parse_formula(text)
    machine = history.run.machine
    query = machine.library.compiler.query(formula, "question", formula.span)
    return ask(machine, "the question", query, None, {})


def why_not(history: History, number: int) -> TaskAnswer:
    """Return what keeps a task from going on.

    Raises:
        ArgumentError: if there is no such task.
        StateError: for one that has ended, if the run cannot be taken back in time.
    """
    live = {task.number: task for task in history.run.machine.state.live_tasks()}
    if number in live:
        if history.no_way_back and live[number].bound:
            return _answer(history, number, past=False)  # nothing is left behind
        with history.at():
            return _answer(history, number, past=False)
    with history.at(last_cycle(history, number) - 1) as run:
        run.come_to_choice()
        return _answer(history, number, past=True)


def last_cycle(history: History, number: int) -> int:
    """Return the last cycle in which a task was selected.

    Raises:
        ArgumentError: if it never was.
    """
    if not 0 < number <= history.run.machine.state.numbers:
        raise ArgumentError(f"there is no task [{number}]")
    found = history.last(TaskSelected, want=lambda told: told.keys["task"] == number)
    if found is None:
        raise ArgumentError(f"task [{number}] never came up")
    return found.cycle


def _answer(history: History, number: int, *, past: bool) -> TaskAnswer:
    run = history.run
    machine = run.machine
    task = live_task(run, number)
    entries = {entry.task: entry for entry in run.agenda()}
    entry = entries[number]
    if not task.bound:
        read_inputs(machine, task)
    return TaskAnswer(
        task=number,
        goal=task.goal(),
        cycle=history.cycle,
        past=past,
        state=entry.state,
        waits_for=entry.waits_for,
        before_it=_before(entry, entries.values()) if entry.state == "eligible" else (),
        clauses=tuple(_clauses(machine, task)),
        methods=tuple(methods(machine, task)) if task.bound else (),
        under_way=None if task.run is None else task.run.plan.name,
    )


def _before(entry: AgendaEntry, entries: Iterable[AgendaEntry]) -> tuple[int, ...]:
    """Return the eligible tasks of higher priority, or that have less time."""
    found = []
    for other in entries:
        if other.state != "eligible" or other.task == entry.task:
            continue
        if other.priority > entry.priority:
            found.append(other.task)
    return tuple(found)


def _clauses(machine: Machine, task: Task) -> Iterator[ClauseAsked]:
    """Ask the clauses of a task that a cycle asks before methods."""
    plan, env = task.plan, task.env
    for clause in clauses.RAP if task.bound else ():
        if clause.word in plan.clauses and not clause.is_condition:
            words = f"{clause.word} of `{plan.name}`"
            yield ask(machine, words, plan.clauses[clause.word], task, env)
    for words, query, asker, bound in (*conditions(task), *_of_methods(task)):
        yield ask(machine, words, query, asker, bound)


def _of_methods(task: Task) -> Iterator[Condition]:
    """Iterate over the constraints of the methods that a task works for."""
    run = task.within
    while run is not None:
        if run.plan.constraints is not None:
            clause = f"constraints of method `{run.plan.name}`"
            yield clause, run.plan.constraints, run.task, run.env
        run = run.task.within


def methods(machine: Machine, task: Task) -> Iterator[MethodAnswer]:
    """Ask each method of a task whether it could be chosen now."""
    held = False
    for method in machine.state.methods(task.plan):
        context = None
        if method.choice is not None:
            clause = f"context of method `{method.name}`"
            context = ask(machine, clause, method.choice, task, task.env)
        answer = MethodAnswer(
            name=method.name,
            context=context,
            otherwise=method.otherwise and held,
            failures=task.failures_of(method),
            tries=task.times_tried(method),
            held_by=_held_by(machine, task, method, context),
        )
        held = held or answer.holds
        yield answer


def _held_by(
    machine: Machine, task: Task, method: MethodPlan, context: ClauseAsked | None
) -> str:
    """Return what a method would have to wait for, and whose it is."""
    if not method.things or (context is not None and not context.holds):
        return ""
    env = task.env if context is None else {**task.env, **context.bindings}
    asks = asks_of(machine, task, method, env)
    obstacle = None if asks is None else machine.things.obstacle(task, asks)
    if obstacle is None:
        return ""
    holder = obstacle.run.task
    thing = obstacle.ask.thing
    return f"{' '.join(map(str, thing))}, held by {holder.goal()} [{holder.number}]"


def named_method(answer: TaskAnswer, name: str) -> MethodAnswer:
    """Return what was found of a method by its name.

    Raises:
        ArgumentError: if the task has no such method.
    """
    for method in answer.methods:
        if method.name == name:
            return method
    names = [method.name for method in answer.methods]
    said = did_you_mean(name, names, f"it has {', '.join(names) or 'none'}")
    raise ArgumentError(f"[{answer.task}] has no method `{name}`; {said}")
