"""Explanations of cycles: the selection of a task, its outcome and failures.

An explanation repeats the cycle from the preceding moment, then undoes the repeat. The
explanation reports the candidates that each rule of choice left [T 3.2.4; L 4], and the
method with the facts that support its context.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import msgspec

from rapc import events
from rapc.base.resources import Value
from rapc.base.values import readable
from rapc.compiler.query.query import Query
from rapc.compiler.rap_plan import MethodPlan
from rapc.debug.answer import Answer, bound_to, numbers, question, say
from rapc.debug.arguments import Arguments
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.debug.questions.ends import why_end
from rapc.debug.questions.why_not import (
    MethodAnswer,
    last_cycle,
    method_in_words,
    methods,
)
from rapc.debug.sources import Origin, origins
from rapc.errors import ArgumentError
from rapc.events import Cause, Event
from rapc.runtime.events.report import cause_lines
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.memory.access import Evidence
from rapc.runtime.state.task import Task
from rapc.world import Time


class Choice(msgspec.Struct, frozen=True):
    """The reasons for the selection of a task."""

    task: int
    cycle: int
    time: Time
    #: The eligible tasks.
    candidates: tuple[int, ...]
    #: The applied rules of choice, each with the tasks that remain.
    rules: tuple[tuple[str, tuple[int, ...]], ...]
    #: The step of a plan that the task is, with its purpose; may be empty.
    step: str = ""


class Doing(msgspec.Struct, frozen=True):
    """The outcome of a cycle of a task, with the supporting facts."""

    #: `method`, `succeeded`, `failed`, `blocked`, or `nothing` without an event.
    outcome: str = "nothing"
    #: The chosen method, or the reason to wait.
    said: str = ""
    bindings: Mapping[str, Value] = {}
    #: The facts that support the deciding clause.
    rests_on: tuple[Origin, ...] = ()
    #: All methods at the time of a choice; empty without a choice.
    methods: tuple[MethodAnswer, ...] = ()
    because: Cause | None = None


_SETTLES: Mapping[type[Event], str] = {
    events.MethodChosen: "method",
    events.TaskSucceeded: "succeeded",
    events.TaskFailed: "failed",
    events.TaskBlocked: "blocked",
}
"""The events that report the outcome of a cycle."""


@question(
    "[TASK] [in CYCLE] | failed [TASK] | end",
    ":why",
    ":why 12",
    ":why 12 in 30",
    ":why failed",
    ":why failed 92",
    ":why failed fill-order",
    ":why end",
)
def why(history: History, args: Arguments) -> Answer:
    """Explain why a task was selected, and what it did; or why it failed.

    The answer lists each rule of selection with the tasks left by the rule, then the
    chosen method with the facts that made its context true. For a step of a plan, it
    lists the facts that the step makes true, each for a step or the goal of the plan.
    `end` explains the end of the run: its symptoms, each after its file and line, and,
    if the world has ended the run, the last request with the decisions and wakes behind
    it. Symptoms are failed top-level tasks, wrong beliefs of rules, signals and facts
    that never came, sets and counters that a loop did not change, and missing claims.
    """
    if args.takes("end"):
        return why_end(history)
    if args.takes("failed"):
        return why_failed(history, _failed_task(history, args) if args else None)
    number = args.task(history, ended=True)
    cycle = args.count("cycle") if args.takes("in") else None
    choice, doing = reasons(history, number, cycle)
    return say(*of_choice(choice), *of_doing(doing))


def of_choice(choice: Choice) -> Iterator[str]:
    """Yield the reasons of a selection as text, after a line with its task."""
    at = f"in cycle {choice.cycle}, at time {readable(choice.time)}"
    yield f"[{choice.task}] was selected {at}:"
    if len(choice.candidates) == 1:
        yield "  the only eligible task"
    else:
        yield f"  {len(choice.candidates)} eligible tasks: {numbers(choice.candidates)}"
    for rule, left in choice.rules:
        yield f"  {rule}: {numbers(left)}"
    if choice.step:
        yield f"It is {choice.step}"


def of_doing(doing: Doing) -> Iterator[str]:
    """Yield the outcome of a cycle and its reasons as text."""
    if doing.outcome == "method":
        yield f"It chose method {doing.said}{bound_to(doing.bindings)}:"
        if len(doing.methods) == 1 and not doing.methods[0].solved:
            yield "  its only method"
        else:
            for method in doing.methods:
                mark = "*" if method.name == doing.said else " "
                yield f" {mark} {method.name}: {method_in_words(method)}"
    elif doing.outcome == "succeeded":
        yield f"It succeeded{bound_to(doing.bindings)}:"
    elif doing.outcome == "failed":
        yield f"It failed ({doing.said}):"
        yield from (f"  {line}" for line in cause_lines(doing.because))
    elif doing.outcome == "blocked":
        yield f"It was blocked until {doing.said}"
    yield from (f"  {origin}" for origin in doing.rests_on)


def reasons(
    history: History, task: int, cycle: int | None = None
) -> tuple[Choice, Doing]:
    """Return the choice and the outcome of a task, in its last or a given cycle.

    Raises:
        ArgumentError: if the task was not selected.
        StateError: if the run cannot go back.
    """
    last = last_cycle(history, task) if cycle is None else cycle
    of_cycle = history.scan(
        events.TaskSelected,
        *_SETTLES,
        first=last,
        want=lambda one: one.cycle == last and one.keys["task"] == task,
    )
    own = list(of_cycle)
    if events.TaskSelected not in [one.kind for one in own]:
        raise ArgumentError(f"task [{task}] was not selected in cycle {last}")
    settled = next((one for one in own if one.kind in _SETTLES), None)
    with history.at_choice(last) as run:
        choice, subject = _choice(history, task), run.task(task)
        doing, rests_on = _doing(run, subject, settled)
    known = origins(history, rests_on, (last, own[0].serial))
    step = _planned_step(history, subject)
    return (
        msgspec.structs.replace(choice, step=step),
        msgspec.structs.replace(doing, rests_on=known),
    )


def _planned_step(history: History, task: Task) -> str:
    """Return the step of a plan that a task is, with its purpose; else nothing."""
    within, step = task.within, task.step
    if within is None or step is None or within.task.plan.node.plan is None:
        return ""
    rap, method = within.task.plan.name, within.plan.name
    made = history.last(
        events.PlanMade,
        want=lambda o: o.keys["goal"].name == rap and o.keys["method"] == method,
    )
    steps = () if made is None else made.keys["steps"]
    found = next((one for one in steps if one.tag == step.node.tag), None)
    return "" if found is None else f"step {found.tag} of {method}, {found.purpose}"


_RULES = (
    "highest priority",
    "earliest latest start",
    "no failed method",
    "current family",
)
"""The rules of choice, in order; each keeps the tasks with the least key part."""


def _choice(history: History, task: int) -> Choice:
    """Return the reasons for the next selection; the run is before the choice."""
    keys = {
        number: (-one.priority, one.latest, one.failed, not one.preferred)
        for number, one in history.run.candidates().items()
    }
    left = candidates = tuple(sorted(keys))
    rules: list[tuple[str, tuple[int, ...]]] = []
    for at, rule in enumerate(_RULES):
        least = min(keys[n][at] for n in left)
        kept = tuple(n for n in left if keys[n][at] == least)
        if kept != left:
            rules.append((rule, kept))
            left = kept
    if len(left) > 1:
        rules.append(("random", (task,)))
    return Choice(task, history.cycle + 1, history.now, candidates, tuple(rules))


def _doing(
    run: Interpreter, task: Task, settled: ToldEvent | None
) -> tuple[Doing, Evidence]:
    """Return the outcome of a cycle and its supports; the run is before the cycle."""
    run.read_inputs(task)
    if settled is None:
        return Doing(), {}
    outcome, keys = _SETTLES[settled.kind], settled.keys
    if outcome == "method":
        name, found = keys["method"], tuple(methods(run, task))
        plan = next((m for m in run.methods(task.plan) if m.name == name), None)
        if plan is None:
            found += (MethodAnswer(name, None, False, 0, 0, solved=True),)
        rests_on = method_supports(run, task, plan)
        return Doing(outcome, name, keys["bindings"], (), found), rests_on
    if outcome == "succeeded":
        rests_on = _supports_of(run, task, task.plan.succeed)
        return Doing(outcome, "", keys["outputs"]), rests_on
    if outcome == "failed":
        return Doing(outcome, keys["reason"], because=keys["because"]), {}
    return Doing(outcome, keys["on"]), {}


def method_supports(
    run: Interpreter, task: Task, method: MethodPlan | None
) -> Evidence:
    """Return the facts that make a method's context true."""
    return _supports_of(run, task, None if method is None else method.choice)


def _supports_of(run: Interpreter, task: Task, query: Query | None) -> Evidence:
    if query is None:
        return {}
    found = run.solution(query, task, task.env)
    return run.supporting(query.formula, {**task.env, **found})


# --- failures -----------------------------------------------------------------------

_FAILURES: Mapping[type[Event], str] = {
    events.TaskFailed: "failed",
    events.MethodEnded: "had a failed method",
    events.TaskRemoved: "was removed",
}


def _failed_task(history: History, args: Arguments) -> int:
    """Take a task: a number, or a RAP for its last task that failed."""
    name = args.peek().lower()
    told = history.last(
        events.TaskFailed, want=lambda told: told.keys["goal"].name == name
    )
    if told is None:
        return args.task(history, ended=True)
    args.word("task")
    return int(told.keys["task"])


def why_failed(history: History, number: int | None = None) -> Answer:
    """Return the causes of a failure, to the root; default: the last failed task.

    Raises:
        ArgumentError: if the task, or every task, has not failed.
    """
    numbers = history.run.created

    def wanted(told: ToldEvent) -> bool:
        if told.kind is events.TaskFailed:
            return number is None or told.keys["task"] == number
        if told.keys["task"] != number:
            return False
        return told.kind is events.TaskRemoved or told.keys["result"] != "okay"

    told = history.last(*_FAILURES, want=wanted)
    if told is None:
        if number is None:
            raise ArgumentError("no failed task")
        if not 0 < number <= numbers:
            raise ArgumentError(f"unknown task [{number}]")
        raise ArgumentError(f"task [{number}] has not failed and has no failed method")
    keys, failed = told.keys, told.keys["task"]
    goal = keys.get("goal") or _goal(history, failed)
    at = f"in cycle {told.cycle}, at time {readable(told.time)}"
    result = keys.get("result") or keys.get("cause", "")
    return say(
        f"[{failed}] {goal} {_FAILURES[told.kind]} {at}: {result}",
        *(f"  {line}" for line in cause_lines(keys.get("because"))),
    )


def _goal(history: History, number: int) -> str:
    """Return the goal of a task at its creation; empty if unknown."""
    made = history.last(events.TaskCreated, want=lambda o: o.keys["task"] == number)
    return "" if made is None else str(made.keys["goal"])
