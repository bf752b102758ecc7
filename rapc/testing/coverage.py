"""What tests have exercised of libraries: methods, monitors, queries, agendas.

A `Coverage` gathers over any number of runs and sets that against what the files of
the libraries hold. How it is told is in `rapc.console.testing.coverage_table`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from os.path import normpath
from typing import TypeVar

import msgspec

from rapc.base.files import TEST_SUFFIX
from rapc.base.values import format_list
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.runtime.events import events
from rapc.testing.asked_queries import Asker, asked_with, name_of
from rapc.testing.heard_signals import HeardSignals, waits_of
from rapc.testing.patterns import flat
from rapc.world import OKAY


class WaitCoverage(msgspec.Struct, frozen=True):
    """A signal that a method, or a step of it, waits for, and how often it came."""

    signal: str
    row: int
    heard: int


class RuleCoverage(msgspec.Struct, frozen=True):
    """A query of a rule over memory, and how often it has acted."""

    #: What the rule is for: a RAP, or a signal.
    name: str
    row: int
    ran: int


class MethodCoverage(msgspec.Struct, frozen=True):
    """What became of one method of a RAP."""

    name: str
    row: int
    chosen: int
    ended_badly: int
    #: How often its context held, and did not; None without a context.
    context_true: int | None
    context_false: int | None
    #: How often its constraints ended it; None without constraints.
    constraints_broken: int | None
    waits: tuple[WaitCoverage, ...] = ()


class MonitorCoverage(msgspec.Struct, frozen=True):
    """How often a RAP's monitor blocked a task, and woke one."""

    blocked: int
    woken: int


class RapCoverage(msgspec.Struct, frozen=True):
    """One RAP: its methods, its monitor if it has one, how its tasks ended.

    `failed` counts its failures by reason.
    """

    name: str
    row: int
    methods: tuple[MethodCoverage, ...]
    monitor: MonitorCoverage | None
    succeeded: int
    failed: Mapping[str, int]


class QueryCoverage(msgspec.Struct, frozen=True):
    """A named query, and how often a clause was asked that names it."""

    name: str
    row: int
    asked: int


class GivenCoverage(msgspec.Struct, frozen=True):
    """A task of an agenda, and how often it was given."""

    goal: str
    row: int
    given: int


class AgendaCoverage(msgspec.Struct, frozen=True):
    """An agenda and its tasks, in the order of the text."""

    name: str
    row: int
    tasks: tuple[GivenCoverage, ...]


class FileCoverage(msgspec.Struct, frozen=True):
    """One file of the library, with what it defines in the order of the text."""

    file: str
    raps: tuple[RapCoverage, ...]
    queries: tuple[QueryCoverage, ...] = ()
    agendas: tuple[AgendaCoverage, ...] = ()
    rules: tuple[RuleCoverage, ...] = ()


class Coverage:
    """Counts what happens in runs, by file and RAP.

    It listens to events (`Interpreter.listen`) and contexts
    (`Interpreter.watch_contexts`). Test files themselves are left out.
    """

    def __init__(self) -> None:
        self._counts: Counter[tuple[str, ...]] = Counter()
        self._tasks: dict[int, str] = {}
        #: How often each top-level task was given.
        self._given: Counter[str] = Counter()
        self._library: Library | None = None
        self._raps: dict[tuple[str, str], tuple[nodes.DefineRap, Library]] = {}
        self._queries: dict[tuple[str, str], tuple[nodes.DefineQuery, Library]] = {}
        self._agendas: dict[tuple[str, str], tuple[nodes.DefineAgenda, Library]] = {}
        self._asked_with: Mapping[Asker, frozenset[str]] = {}
        self._rules: dict[tuple[str, int], str] = {}
        self._heard: HeardSignals | None = None

    def begin(self, library: Library) -> None:
        """A run of this library comes next."""
        self._tasks.clear()
        self._heard = HeardSignals(library)
        if library is self._library:
            return
        self._library = library
        self._asked_with = asked_with(library)
        _gather(self._raps, library.raps, library)
        _gather(self._queries, library.queries, library)
        _gather(self._agendas, library.agendas, library)
        for name, alternative in _alternatives(library):
            if not alternative.span.file.endswith(TEST_SUFFIX):
                place = normpath(alternative.span.file), _row(library, alternative)
                self._rules.setdefault(place, name)

    def __call__(self, event: events.Event) -> None:
        """Take one event into account."""
        self._hear(event)
        match event:
            case events.TaskCreated():
                self._tasks[event.task] = event.goal.name
                if event.parent is None:
                    self._given[format_list((event.goal.name, *event.goal.inputs))] += 1
            case events.TaskSelected():
                self._ask((self._tasks[event.task], "", ""))
            case events.MethodChosen():
                self._count("chosen", event.rap, event.method)
                self._ask((event.rap, event.method, ""))
            case events.MethodEnded() if event.result != OKAY:
                self._count("badly", self._tasks[event.task], event.method)
                if event.because is not None and "constraints" in event.because.clause:
                    self._count("broken", self._tasks[event.task], event.method)
            case events.TaskBlocked() if _is_monitor(event):
                self._count("blocked", self._tasks[event.task])
            case events.TaskWoken() if _is_monitor(event):
                self._count("woken", self._tasks[event.task])
            case events.TaskSucceeded():
                self._count("succeeded", self._tasks[event.task])
            case events.TaskFailed():
                self._count("failed", self._tasks[event.task], event.reason)
            case _:
                pass

    def _hear(self, event: events.Event) -> None:
        """Count what a signal has decided, and what a rule has done."""
        heard = None if self._heard is None else self._heard.heard(event)
        if heard is not None:
            self._count("heard", *heard)
        if isinstance(event, events.RuleRun):
            file, _, row = event.at.rpartition(":")
            self._counts["rule", normpath(file), row] += 1

    def context(self, rap: str, method: str, holds: bool) -> None:
        """A method's context was asked."""
        self._count("true" if holds else "false", rap, method)
        self._ask((rap, method, "context"))

    def _ask(self, asker: Asker) -> None:
        """A clause was asked, and the queries that it names."""
        for name in self._asked_with.get(asker, ()):
            assert self._library is not None
            self._counts["asked", _file(self._library.queries[name]), name] += 1

    def _count(self, what: str, name: str, *more: str) -> None:
        rap = self._library.raps.get(name) if self._library is not None else None
        if rap is not None:
            self._counts[what, _file(rap), name, *more] += 1

    # --- what it comes to ------------------------------------------------------------

    def files(self) -> tuple[FileCoverage, ...]:
        """All files of all libraries, by name."""
        tables = (self._raps, self._queries, self._agendas, self._rules)
        names = sorted({file for table in tables for file, _ in table})
        return tuple([self._of_file(name) for name in names])

    def _of_file(self, file: str) -> FileCoverage:
        raps = [
            self._rap(library, file, rap)
            for (where, _), (rap, library) in self._raps.items()
            if where == file
        ]
        queries = [
            QueryCoverage(name, _row(library, form), self._counts["asked", file, name])
            for (where, name), (form, library) in self._queries.items()
            if where == file
        ]
        agendas = [
            AgendaCoverage(
                name,
                _row(library, form),
                tuple([self._task(library, task) for task in form.tasks]),
            )
            for (where, name), (form, library) in self._agendas.items()
            if where == file
        ]
        rules = [
            RuleCoverage(name, row, self._counts["rule", file, str(row)])
            for (where, row), name in self._rules.items()
            if where == file
        ]
        return FileCoverage(
            file,
            _in_order(raps),
            _in_order(queries),
            _in_order(agendas),
            _in_order(rules),
        )

    def _task(self, library: Library, task: nodes.GivenTask) -> GivenCoverage:
        goal = format_list(flat(task.goal))
        return GivenCoverage(goal, _row(library, task), self._given[goal])

    def _rap(self, library: Library, file: str, rap: nodes.DefineRap) -> RapCoverage:
        count = self._counts
        monitor = None
        if rap.monitor_state is not None or rap.monitor_time is not None:
            blocked, woken = (count[what, file, rap.name] for what in _MONITOR)
            monitor = MonitorCoverage(blocked, woken)
        failed = {
            key[3]: number
            for key, number in sorted(count.items())
            if key[:3] == ("failed", file, rap.name)
        }
        return RapCoverage(
            name=rap.name,
            row=_row(library, rap),
            methods=tuple([self._method(library, file, rap, m) for m in rap.methods]),
            monitor=monitor,
            succeeded=count["succeeded", file, rap.name],
            failed=failed,
        )

    def _method(
        self, library: Library, file: str, rap: nodes.DefineRap, method: nodes.Method
    ) -> MethodCoverage:
        name = name_of(method)
        at = (file, rap.name, name)
        asked = method.context is not None
        return MethodCoverage(
            name=name,
            row=_row(library, method),
            chosen=self._counts["chosen", *at],
            ended_badly=self._counts["badly", *at],
            context_true=self._counts["true", *at] if asked else None,
            context_false=self._counts["false", *at] if asked else None,
            constraints_broken=(
                None if method.constraints is None else self._counts["broken", *at]
            ),
            waits=self._waits(library, at, method),
        )

    def _waits(
        self, library: Library, at: tuple[str, str, str], method: nodes.Method
    ) -> tuple[WaitCoverage, ...]:
        first: dict[str, nodes.WaitFor] = {}
        for wait in waits_of(method):
            first.setdefault(wait.signal, wait)
        return tuple(
            [
                WaitCoverage(
                    name, _row(library, wait), self._counts["heard", *at, name]
                )
                for name, wait in first.items()
            ]
        )


def _alternatives(library: Library) -> Iterator[tuple[str, nodes.Alternative]]:
    """Yield each query of a rule over memory with what the rule is for."""
    found: list[tuple[str, tuple[nodes.Rule, ...]]] = [
        (memory.index.name, case.rules)
        for memory in library.memory_rules
        for case in memory.cases
    ]
    found += [(event.signal, event.rules) for event in library.event_rules]
    for name, rules in found:
        for rule in rules:
            for alternative in rule.alternatives:
                yield name, alternative


def _is_monitor(event: events.TaskBlocked | events.TaskWoken) -> bool:
    """Whether a task waits for its monitors, not for a signal or a thing."""
    return event.holder is None and not event.on.startswith("(:")


_MONITOR = ("blocked", "woken")


_Form = TypeVar("_Form", nodes.DefineRap, nodes.DefineQuery, nodes.DefineAgenda)
_Known = dict[tuple[str, str], tuple[_Form, Library]]
"""Forms with their libraries, by file and name."""


def _gather(known: _Known[_Form], forms: Mapping[str, _Form], of: Library) -> None:
    """Note the forms of a library that stand in no file of tests."""
    for form in forms.values():
        if not form.span.file.endswith(TEST_SUFFIX):
            known.setdefault((_file(form), form.name), (form, of))


_Rowed = TypeVar("_Rowed", RapCoverage, QueryCoverage, AgendaCoverage, RuleCoverage)


def _in_order(found: Iterable[_Rowed]) -> tuple[_Rowed, ...]:
    """Return what stands in a file in the order of its rows."""
    return tuple(sorted(found, key=lambda one: one.row))


def _file(form: nodes.DefineRap | nodes.DefineQuery | nodes.DefineAgenda) -> str:
    """A file by one name, however it was reached."""
    return normpath(form.span.file)


_Placed = (
    nodes.DefineRap
    | nodes.Method
    | nodes.DefineQuery
    | nodes.DefineAgenda
    | nodes.GivenTask
    | nodes.WaitFor
    | nodes.Alternative
)


def _row(library: Library, node: _Placed) -> int:
    source = library.files.get(node.span.file)
    return 0 if source is None else source.position(node.span.start).row
