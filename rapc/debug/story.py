"""The tasks, choices and requests of a run, with the places behind them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from rapc import events
from rapc.base.values import Fact
from rapc.compiler.program import Program
from rapc.debug.log import ToldEvent
from rapc.debug.names import predicates
from rapc.errors import TextError
from rapc.events import Cause, Goal
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import through_queries
from rapc.parser.parse import parse_formula


class Request(NamedTuple):
    """A request, or an activation of skills."""

    task: int
    what: Fact
    begun: ToldEvent
    #: The event of its end; None while it is under way.
    ended: ToldEvent | None = None


class Story:
    """The tasks, choices and requests of a run, from its events."""

    def __init__(self, told: Iterable[ToldEvent], program: Program | None) -> None:
        self.program = program
        self.created: dict[int, ToldEvent] = {}
        #: The choices of each task, in order.
        self.chosen: dict[int, list[ToldEvent]] = {}
        #: The last wake of each task that no thing has caused.
        self.woken: dict[int, ToldEvent] = {}
        #: The waits of each task for things, with the events of their ends.
        self.held: dict[int, list[tuple[ToldEvent, ToldEvent]]] = {}
        #: The waits that have not ended by a wake, by task.
        self.blocked: dict[int, ToldEvent] = {}
        self.failed: dict[int, ToldEvent] = {}
        #: The ends of the methods of each task, in order.
        self.methods: dict[int, list[ToldEvent]] = {}
        #: The changes of sets and counters.
        self.resources: list[ToldEvent] = []
        self.requests: list[Request] = []
        self.asserted: list[ToldEvent] = []
        self.end: ToldEvent | None = None
        #: The requests under way, by task: their indexes in `requests`.
        self._open: dict[tuple[int, Fact], int] = {}
        for one in told:
            if one.kind in (events.TaskBlocked, events.TaskWoken):
                self._take_wait(one)
            else:
                self._take(one)

    def _take(self, one: ToldEvent) -> None:
        kind, keys = one.kind, one.keys
        if kind is events.TaskCreated:
            self.created[keys["task"]] = one
        elif kind is events.MethodChosen:
            self.chosen.setdefault(keys["task"], []).append(one)
        elif kind is events.MethodEnded:
            self.methods.setdefault(keys["task"], []).append(one)
        elif kind is events.FactAsserted:
            self.asserted.append(one)
        elif kind in (events.PrimitiveRequested, events.SkillEnabled):
            what = keys.get("request") or keys["what"]
            self._open[keys["task"], what] = len(self.requests)
            self.requests.append(Request(keys["task"], what, one))
        elif kind in (events.PrimitiveEnded, events.PrimitiveCancelled):
            at = self._open.pop((keys["task"], keys["request"]), None)
            if at is not None:
                self.requests[at] = self.requests[at]._replace(ended=one)
        elif kind is events.ResourceChanged:
            self.resources.append(one)
        elif kind is events.TaskFailed:
            self.failed[keys["task"]] = one
        elif kind is events.RunEnded:
            self.end = one

    def _take_wait(self, one: ToldEvent) -> None:
        task = one.keys["task"]
        if one.kind is events.TaskBlocked:
            self.blocked[task] = one
            return
        blocked = self.blocked.pop(task, None)
        if one.keys.get("holder") is None:
            self.woken[task] = one
        elif blocked is not None:
            self.held.setdefault(task, []).append((blocked, one))

    def goal(self, task: int) -> Goal | None:
        """Return the goal of a task; None if its creation is no longer known."""
        made = self.created.get(task)
        return None if made is None else made.keys["goal"]

    def named(self, task: int) -> str:
        """Return the number and the goal of a task as text."""
        return f"[{task}] {self.goal(task) or ''}".rstrip()

    def parents(self, task: int) -> Iterator[int]:
        """Yield a task and its ancestors."""
        above: int | None = task
        while above is not None:
            yield above
            made = self.created.get(above)
            above = None if made is None else made.keys["parent"]

    def family(self, task: int) -> int:
        """Return the top-level task of a task."""
        made = self.created.get(task)
        return task if made is None else made.keys["family"]

    def choice(self, task: int, before: int) -> ToldEvent | None:
        """Return the last choice of a task before a serial number."""
        found = [one for one in self.chosen.get(task, ()) if one.serial < before]
        return found[-1] if found else None

    def method(self, choice: ToldEvent) -> nodes.Method | None:
        """Return the method of a choice; None without its text."""
        plan = None if self.program is None else self.program.rap(choice.keys["rap"])
        methods = () if plan is None else plan.methods
        wanted = choice.keys["method"]
        return next((one.node for one in methods if one.name == wanted), None)

    def row(self, node: nodes.Node | None) -> str:
        """Return the file and line of a node."""
        if self.program is None or node is None:
            return ""
        return self.program.compiler.row(node.span)

    def step(self, made: ToldEvent) -> tuple[ToldEvent | None, nodes.Step | None]:
        """Return the choice that created a task, and the text of the task's step."""
        parent = made.keys["parent"]
        chosen = None if parent is None else self.choice(parent, made.serial)
        method = None if chosen is None else self.method(chosen)
        if method is None or not isinstance(method.body, nodes.TaskNet):
            return chosen, None
        steps = (one for one in method.body.steps if one.tag == made.keys["step"])
        return chosen, next(steps, None)

    def wait(self, on: str, task: int) -> tuple[str, str]:
        """Return the awaited state of a task, with the line; no texts if unknown.

        This is the annotation of a step that waits for a signal, or the first test of
        a monitor (see `thresholds`), or else the first named query.
        """
        if on.startswith("(:"):
            made = self.created.get(task)
            _, step = (None, None) if made is None else self.step(made)
            waits = () if step is None else step.annotations
            found = [
                (f"step {step.tag}", self.row(one))
                for one in waits
                if step is not None and isinstance(one, nodes.WaitFor)
            ]
            return next(iter(found), ("", ""))
        formula = self.awaited(on, task)
        if formula is None:
            return "", ""
        test = self.test(formula)
        return test if test[1] else (format_formula(formula), self.row(formula))

    def awaited(self, on: str, task: int) -> nodes.Formula | None:
        """Return the formula that a task waits for, from the library if it is there.

        None for a time or a thing.
        """
        goal = self.goal(task)
        plan = None
        if self.program is not None and goal is not None:
            plan = self.program.rap(goal.name)
        monitored = None if plan is None else plan.node.monitor_state
        if monitored is not None and format_formula(monitored) == on:
            return monitored
        return formula_of(on)

    def test(self, formula: nodes.Formula) -> tuple[str, str]:
        """Return the first test of a formula, or else its first query; with its line.

        See `thresholds`; without a library or a test, there are no texts.
        """
        if self.program is None:
            return "", ""
        tests = thresholds(self.program, formula)
        found = [(format_formula(one), self.row(one)) for one in tests]
        queries = self.program.library.queries
        names = predicates(self.program.library, formula)
        named = [one for one in names if one in queries]
        found += [(f"query `{one}`", self.row(queries[one])) for one in named]
        return next((one for one in found if one[1]), ("", ""))


def first_causes(cause: Cause | None) -> Iterator[Cause]:
    """Yield the first causes below a cause, or those of the excluded methods."""
    while cause is not None and cause.because is not None:
        cause = cause.because
    if cause is None:
        return
    for one in cause.methods or (cause,):
        inner = one
        while inner.inside:
            inner = inner.inside[0]
        yield inner


def formula_of(text: str) -> nodes.Formula | None:
    """Return the formula of a wait; None for a time or a thing."""
    try:
        return parse_formula(text) if text.startswith("(") else None
    except TextError:
        return None


def thresholds(program: Program, formula: nodes.Formula) -> list[nodes.Formula]:
    """Return the comparisons and the limits of age in a formula and its queries."""
    return [
        part
        for part in through_queries(formula, program.library.queries)
        if isinstance(part, nodes.Compare)
        or (isinstance(part, nodes.Believe) and type(part.age) is nodes.Const)
    ]
