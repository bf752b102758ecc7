"""Export of a run as a test: with a script of the world's replies, or in its simulator.

The rows of a script, one for each request, contain the changes that the handlers of
the world made to memory. A test in a simulator repeats the run from its beginning or
from a saved state. Not every run can be exported like this, so a caller must run the
exported test.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from typing import NamedTuple

import msgspec

from rapc import events
from rapc.base.source import SourceFile
from rapc.base.values import (
    Atom,
    Fact,
    Text,
    format_atom,
    format_list,
    number,
    readable,
)
from rapc.errors import StateError
from rapc.ir.layout import laid_out
from rapc.ir.nodes import DefineTest
from rapc.parser.parse import parse
from rapc.spec import RunSpec
from rapc.testing.run import LATEST
from rapc.world import Time

MOST_RUNS = 300
"""The highest number of runs of a test while it is shortened."""

_SIDE = (
    events.DataReceived,
    events.ItemIntroduced,
    events.ItemMerged,
    events.ItemMoved,
    events.ItemLost,
    events.RuleRun,
)
"""The events among changes of memory that belong together."""


_DONE = ("erases", "asserts", "moves", "loses")
"""The kinds of changes of memory, in the order in which a script makes them."""

_OF_PLACES = ("moves", "loses")
"""The kinds of changes of items that have been introduced."""

_OVER = "run-over"
"""The reason of removal for tasks that are live at the end of a run."""

_OF_ITEMS = ("class", "location")
"""The facts that a script cannot assert of an introduced item."""


class MemoryChange(NamedTuple):
    """A change of memory."""

    #: `erases`, `asserts`, `moves` or `loses`.
    does: str
    #: A fact that is erased or asserted, an item with its place, or an item alone.
    fact: Fact

    def __str__(self) -> str:
        return (
            format_atom(self.fact[0])
            if self.does == "loses"
            else format_list(self.fact)
        )


class TestPart(msgspec.Struct):
    """A part of a test, with its text before and after its changes of memory."""

    #: `facts`, `row` or `at`.
    kind: str
    #: The request of a row with its result, the time of an `at`.
    head: str = ""
    #: Options of a row, other actions of an `at`.
    more: str = ""
    #: The changes of memory.
    changes: tuple[MemoryChange, ...] = ()

    def __str__(self) -> str:
        done = {word: self._done(word) for word in _DONE}
        if self.kind == "facts":
            return f"(facts {done['asserts']})" if done["asserts"] else ""
        told = [(word, what) for word, what in done.items() if what]
        if self.kind == "row":
            options = "".join(f" :{word} ({what})" for word, what in told)
            return f"({self.head}{self.more}{options})"
        said = "".join(f" ({word} {what})" for word, what in told) + self.more
        return f"(at {self.head}{said})" if said else ""

    def _done(self, word: str) -> str:
        return " ".join(str(one) for one in self.changes if one.does == word)


class Exported(msgspec.Struct):
    """A run as a test that can be shortened."""

    name: str
    #: World, options, seed and tasks, or a saved state, as text.
    begun: str
    #: The clause for the end of the recorded run; empty if all tasks ended.
    until: str
    parts: list[TestPart]
    #: The goal of the task that the test is about.
    goal: str
    #: The result of the task and the requests, as text.
    expectations: tuple[str, ...]
    #: The end of a test that expects success, as `until`.
    limit: str

    def want(self, *more: str) -> None:
        """Expect success of the task and more, in place of the recorded result."""
        self.expectations = (f"(succeeds {self.goal})", *more)
        self.until = self.limit

    def node(self) -> DefineTest:
        """Return the present test.

        Raises:
            StateError: if a part of the run cannot be written.
        """
        rows = " ".join(str(part) for part in self.parts if part.kind == "row")
        others = " ".join(str(part) for part in self.parts if part.kind != "row")
        script = f"(script {rows})" if rows else ""
        expect = " ".join(self.expectations)
        begun = f"{self.begun} {self.until}"
        text = f"(define-test {self.name} {begun} {others} {script}"
        unit = parse(SourceFile("<test>", f"{text} (expect {expect}))"))
        if unit.diagnostics or len(unit.tests) != 1:
            said = "; ".join(found.message for found in unit.diagnostics)
            raise StateError(f"the run cannot be written as a test: {said}")
        return unit.tests[0]

    def text(self) -> str:
        """Return the test as text."""
        return laid_out(self.node()) + "\n"

    def shorten(self, holds: Callable[[DefineTest], bool]) -> None:
        """Remove changes of memory that the test passes without.

        Times lose the noise of floats, too.

        Args:
            holds: returns whether a test has the same result as the run.
        """
        self._round_times(holds)
        size = max(self._size() // 2, 1)
        left = MOST_RUNS
        while left > 0:
            at = 0
            while at < self._size() and left > 0:
                before, left = self.parts, left - 1
                self.parts = self._without(at, size)
                if not holds(self.node()):
                    self.parts, at = before, at + size
            if size == 1:
                return
            size = max(size // 2, 1)

    def _round_times(self, holds: Callable[[DefineTest], bool]) -> None:
        """Write times without the noise of sums, unless the result depends on it."""
        exact = self.parts
        self.parts = [
            msgspec.structs.replace(part, head=readable(float(part.head)))
            if part.kind == "at"
            else part
            for part in exact
        ]
        if self.parts != exact and not holds(self.node()):
            self.parts = exact

    def _size(self) -> int:
        return sum(len(part.changes) for part in self.parts)

    def _without(self, first: int, count: int) -> list[TestPart]:
        """Return the parts without some changes, numbered through all parts."""
        found, at = [], 0
        for part in self.parts:
            kept = [
                change
                for index, change in enumerate(part.changes, at)
                if not first <= index < first + count
            ]
            at += len(part.changes)
            found.append(msgspec.structs.replace(part, changes=tuple(kept)))
        return found


class _Reading:
    """A builder of the parts of a test from the events of a run.

    Args:
        not_atomic: the names of the primitives that are not atomic.
    """

    def __init__(self, not_atomic: Collection[str]) -> None:
        self._not_atomic = not_atomic
        self._under_way: list[tuple[events.PrimitiveRequested, TestPart]] = []
        self._changes: list[MemoryChange] = []
        #: The sensor names of the known items.
        self._sensors: dict[Atom, Atom] = {}
        #: The items in the data of preceding rows: the script introduces these items.
        self._introduced: set[Atom] = set()
        self.parts = [TestPart("facts")]
        #: The requests and skills, in the form of an expectation.
        self.asked: list[str] = []

    def take(self, event: events.Event) -> None:
        """Process one event."""
        match event:
            case events.FactAsserted() | events.FactErased():
                if event.by != "notation":
                    does = _FACTS[type(event)]
                    self._changes.append(MemoryChange(does, event.fact))
                return
            case events.ItemMoved():
                item = self._as_asked(event)
                self._changes.append(MemoryChange("moves", (item, event.location)))
            case events.ItemLost():
                self._changes.append(MemoryChange("loses", (self._as_asked(event),)))
            case events.PrimitiveEnded():
                self._end(event)
                return
        if isinstance(event, events.ItemEvent) and event.sensor is not None:
            self._sensors[event.with_ or event.item] = event.sensor
            self._sensors[event.item] = event.sensor
        if not isinstance(event, _SIDE):
            self._flush(event.time, event.cycle)
        match event:
            case events.PrimitiveRequested():
                part = TestPart("row", format_list(event.sent))
                self.parts.append(part)
                self.asked.append(format_list(event.request))
                self._under_way.append((event, part))
            case events.SkillEnabled():
                self.asked.append(format_list(("enable", event.what)))
            case events.RequestRefused():
                refused = f"{format_list(event.sent)} :refused :times 1"
                self.parts.append(TestPart("row", refused))
            case events.SignalReceived():
                signal = f" (signals {format_list(event.what)})"
                self.parts.append(TestPart("at", format_atom(event.time), signal))

    def _as_asked(self, event: events.ItemEvent) -> Atom:
        """Return the name that a handler used for an item that has a new name."""
        asked = [word for request, _ in self._under_way for word in request.request]
        return event.with_ if event.with_ in asked else event.item

    def _flush(self, time: Time, cycle: int) -> None:
        """Write changes that belong to no request as actions of an `at`."""
        changes = self._taken()
        if cycle == 0:
            self.parts[0].changes += changes
        elif changes:
            self.parts.append(TestPart("at", format_atom(time), "", changes))

    def _taken(self) -> tuple[MemoryChange, ...]:
        """Return the changes so far; handlers of data set the places of items."""
        changes, self._changes = self._changes, []
        return tuple(change for change in _net(changes) if self._can_be_told(change))

    def _can_be_told(self, change: MemoryChange) -> bool:
        """Return whether a script knows the item of a change, or may set the fact."""
        if change.does in _OF_PLACES:
            return change.fact[0] in self._introduced
        return change.fact[0] not in _OF_ITEMS or change.fact[1] not in self._sensors

    def _introduce(self, part: TestPart, data: Iterable[Fact]) -> None:
        """Add to a row the data that came with its result.

        The handlers of the data introduce items again, and remove names in the same way
        as in the run.
        """
        data = list(data)
        self._introduced.update(
            word for datum in data for word in datum if word in self._sensors
        )
        told = [
            tuple(self._sensors.get(word, word) for word in datum) for datum in data
        ]
        if told:
            part.more += f" :data {format_list(told)}"

    def _end(self, ended: events.PrimitiveEnded) -> None:
        """Record the end of a request."""
        for at, (request, part) in enumerate(self._under_way):
            if (request.task, request.request) == (ended.task, ended.request):
                del self._under_way[at]
                self._say(part, request, ended.result, ended.time)
                part.changes = self._taken()
                self._introduce(part, ended.data)
                return

    def _say(
        self,
        part: TestPart,
        request: events.PrimitiveRequested,
        result: str,
        ended: Time,
    ) -> None:
        """Write the result and the time of a request into a row."""
        took = round(ended - request.time, 9)
        option = ":after" if str(request.request[0]) in self._not_atomic else ":takes"
        part.head += f" {result} :times 1"
        if took or option == ":after":
            part.more = f" {option} {format_atom(took)}"

    def finish(self, now: Time, cycle: int) -> None:
        """Record the rest after the last event of the run."""
        self._flush(now, cycle)
        for request, part in self._under_way:
            self._say(part, request, "okay", request.time + LATEST)


_FACTS = {events.FactAsserted: "asserts", events.FactErased: "erases"}


def _net(changes: Iterable[MemoryChange]) -> Iterator[MemoryChange]:
    """Yield the last change of each fact and of each item's place."""
    last: dict[tuple[bool, Fact], MemoryChange] = {}
    for change in changes:
        of_item = change.does in _OF_PLACES
        key = (of_item, change.fact[:1] if of_item else change.fact)
        last.pop(key, None)
        last[key] = change
    return iter(last.values())


def exported(
    name: str,
    told: Sequence[events.Event],
    task: int,
    *,
    acts: Iterable[tuple[Time, str]] = (),
    not_atomic: Collection[str] = (),
) -> Exported:
    """Return a run as a test of the result of a task.

    Args:
        name: the name of the test.
        told: all events of the run.
        task: the number of the task.
        acts: tasks added and cancelled during the run: the time, and an action of an
            `at`.
        not_atomic: the names of the primitives that are not atomic.

    Raises:
        StateError: if the task does not exist.
    """
    begun, last = told[0], told[-1]
    if not isinstance(begun, events.RunStarted):
        raise StateError("the beginning of the run is not known")
    goal, outcome = outcome_of(told, task)
    reading = _Reading(not_atomic)
    for event in told:
        reading.take(event)
    reading.finish(last.time, last.cycle)
    done = [TestPart("at", format_atom(time), f" {action}") for time, action in acts]
    over = isinstance(last, events.RunEnded) and last.reason == "done"
    until = "" if over else f"(until (cycles {last.cycle}))"
    asked = f"(primitives {' '.join(reading.asked)})"
    clauses = " ".join([*_made(begun.spec), *map(_given, begun.spec.tasks)])
    parts = [*reading.parts, *done]
    return Exported(name, clauses, until, parts, goal, (outcome, asked), until)


def in_simulator(
    name: str,
    told: Sequence[events.Event],
    task: int,
    *,
    acts: Iterable[tuple[Time, str]],
    end: int,
    state: tuple[str, int] | None = None,
) -> Exported:
    """Return a run as a test in its simulator of the result of a task.

    Args:
        name: the name of the test.
        told: all events of the run.
        task: the number of the task.
        acts: the acts of the user as actions of an `at`, each with its time; with a
            state, only those after it.
        end: the last cycle of the test.
        state: a file with a saved state and the cycle of the state; None for a test
            from the beginning.

    Raises:
        StateError: if the task does not exist.
    """
    begun, last = told[0], told[-1]
    if not isinstance(begun, events.RunStarted):
        raise StateError("the beginning of the run is not known")
    goal, outcome = outcome_of(told, task)
    spec, first = begun.spec, 0
    if state is None:
        facts = [f"(facts {' '.join(spec.facts)})"] if spec.facts else []
        clauses = [*_made(spec), *facts, *map(_given, spec.tasks)]
    else:
        file, first = state
        clauses = [
            f"(world {_world(spec)})",
            f"(saved-state {format_atom(Text(file))})",
        ]
    parts = [TestPart("at", format_atom(time), f" {action}") for time, action in acts]
    until = limit = ""
    over = isinstance(last, events.RunEnded) and last.reason == "done"
    if not over or end < last.cycle:
        until = f"(until (cycles {max(end - first, 1)}))"
    if spec.until is not None or not over:
        latest = 2 * last.time or LATEST if spec.until is None else spec.until
        limit = f"(until {format_atom(number(latest))})"
    expected = (outcome,) if outcome else ()
    return Exported(name, " ".join(clauses), until, parts, goal, expected, limit)


def last_cycle(told: Sequence[events.Event], task: int) -> int:
    """Return the cycle in which a task ended, or the last cycle of a run."""
    ends = (one.cycle for one in told if isinstance(one, _ENDS) and one.task == task)
    return next(ends, told[-1].cycle)


_NO_VALUE = ("(", "?", "#", "")
"""The first characters of inputs without a value yet, and of counters and sets."""

_ENDS = events.TaskSucceeded | events.TaskFailed | events.TaskRemoved


def _made(spec: RunSpec) -> list[str]:
    """Return the clauses for the world of a run, its options and the seed."""
    clauses = [f"(world {_world(spec)})"] if spec.world != "scripted" else []
    if spec.options:
        pairs = [f"({name} {_option(value)})" for name, value in spec.options.items()]
        clauses.append(f"(options {' '.join(pairs)})")
    return [*clauses, f"(seed {spec.seed})"]


def _world(spec: RunSpec) -> str:
    """Return the name of a world; a class is in quotes, which keep capitals."""
    named = spec.world_class
    return format_atom(Text(named)) if named else spec.world


def _given(task: str) -> str:
    """Return the clause that adds a task; an `at` for a task of a later time."""
    goal, end, options = task.rpartition(")")
    later = _LATER.search(options)
    if later is None:
        return f"(task {task})"
    return f"(at {later[1]} (task {goal}{end}{options.replace(later[0], '', 1)}))"


_LATER = re.compile(r" :at ([0-9.]+)")


def _option(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return format_atom(Text(value) if isinstance(value, str) else value)


def outcome_of(told: Iterable[events.Event], task: int) -> tuple[str, str]:
    """Return the goal of a task, and the expectation of its result.

    No expectation describes the result of a task that was removed.

    Raises:
        StateError: if the task does not exist.
    """
    goal, how, reason = None, "active", ""
    for event in told:
        match event:
            case events.TaskCreated() | events.TaskSelected() if event.task == task:
                goal = event.goal
            case events.TaskSucceeded() if event.task == task:
                how = "succeeds"
            case events.TaskFailed() if event.task == task:
                how, reason = "fails", f" {event.result}"
            case events.TaskRemoved() if event.task == task and event.cause != _OVER:
                how = ""
    if goal is None:
        raise StateError(f"unknown task [{task}]")
    inputs = [
        format_atom(part)
        if isinstance(part, int | float | Text)
        or (isinstance(part, str) and part[:1] not in _NO_VALUE)
        else "?"
        for part in goal.inputs
    ]
    said = f"({' '.join([goal.name, *inputs])})"
    return said, f"({how} {said}{reason})" if how else ""
