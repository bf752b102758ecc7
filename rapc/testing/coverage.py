"""What tests have exercised of libraries: methods, monitors, queries, agendas.

A `Coverage` gathers over any number of runs and sets that against what the files of
the libraries hold. How it is told is in `rapc.console.testing.coverage_table`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from os.path import normpath
from typing import Any, TypeVar

import msgspec

from rapc import events
from rapc.base.files import TEST_SUFFIX
from rapc.base.values import format_list
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.testing.asked_queries import Asker, asked_with, traced_name
from rapc.testing.heard_signals import HeardSignals, waits_of
from rapc.testing.patterns import flat
from rapc.world import OKAY


class WaitCoverage(msgspec.Struct):
    """A signal that a method, or a step of it, waits for, and how often it came."""

    signal: str
    row: int
    heard: int = 0


class RuleCoverage(msgspec.Struct):
    """A query of a rule over memory, and how often it has acted."""

    #: What the rule is for: a RAP, or a signal.
    name: str
    row: int
    ran: int = 0


class MethodCoverage(msgspec.Struct):
    """What became of one method of a RAP."""

    name: str
    row: int
    chosen: int = 0
    ended_badly: int = 0
    #: How often its context held, and did not; None without a context.
    context_true: int | None = None
    context_false: int | None = None
    #: How often its constraints ended it; None without constraints.
    constraints_broken: int | None = None
    waits: tuple[WaitCoverage, ...] = ()


class MonitorCoverage(msgspec.Struct):
    """How often a RAP's monitor blocked a task, and woke one."""

    blocked: int = 0
    woken: int = 0


class RapCoverage(msgspec.Struct):
    """One RAP: its methods, its monitor if it has one, how its tasks ended.

    `failed` counts its failures by reason.
    """

    name: str
    row: int
    methods: tuple[MethodCoverage, ...]
    monitor: MonitorCoverage | None
    succeeded: int = 0
    failed: dict[str, int] = {}


class QueryCoverage(msgspec.Struct):
    """A named query, and how often a clause was asked that names it."""

    name: str
    row: int
    asked: int = 0


class GivenCoverage(msgspec.Struct):
    """A task of an agenda, and how often it was given."""

    goal: str
    row: int
    given: int = 0


class AgendaCoverage(msgspec.Struct):
    """An agenda and its tasks, in the order of the text."""

    name: str
    row: int
    tasks: tuple[GivenCoverage, ...]


class FileCoverage(msgspec.Struct):
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
        # what stands in the files of all libraries, by file with name or row
        self._raps: dict[tuple[str, str], RapCoverage] = {}
        self._queries: dict[tuple[str, str], QueryCoverage] = {}
        self._agendas: dict[tuple[str, str], AgendaCoverage] = {}
        self._rules: dict[tuple[str, int], RuleCoverage] = {}
        #: How often each top-level task was given.
        self._given: Counter[str] = Counter()
        # the run under way
        self._library: Library | None = None
        self._tasks: dict[int, str] = {}
        self._asked_with: Mapping[Asker, frozenset[str]] = {}
        self._heard: HeardSignals | None = None

    def begin(self, library: Library) -> None:
        """Begin to count for a run of a library."""
        self._tasks.clear()
        self._heard = HeardSignals(library)
        if library is self._library:
            return
        self._library = library
        self._asked_with = asked_with(library)
        for rap in _outside_tests(library.raps.values()):
            self._raps.setdefault(_key(rap), _rap(library, rap))
        for query in _outside_tests(library.queries.values()):
            found = QueryCoverage(query.name, _row(library, query))
            self._queries.setdefault(_key(query), found)
        for agenda in _outside_tests(library.agendas.values()):
            self._agendas.setdefault(_key(agenda), _agenda(library, agenda))
        for name, alternative in _alternatives(library):
            if not alternative.span.file.endswith(TEST_SUFFIX):
                rule = RuleCoverage(name, _row(library, alternative))
                place = normpath(alternative.span.file), rule.row
                self._rules.setdefault(place, rule)

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
                _count(self._method(event.rap, event.method), "chosen")
                self._ask((event.rap, event.method, ""))
            case events.MethodEnded() if event.result != OKAY:
                method = self._method(self._tasks[event.task], event.method)
                _count(method, "ended_badly")
                if event.because is not None and "constraints" in event.because.clause:
                    _count(method, "constraints_broken")
            case events.TaskBlocked() if _is_monitor(event):
                _count(self._monitor(event.task), "blocked")
            case events.TaskWoken() if _is_monitor(event):
                _count(self._monitor(event.task), "woken")
            case events.TaskSucceeded():
                _count(self._rap(self._tasks[event.task]), "succeeded")
            case events.TaskFailed():
                rap = self._rap(self._tasks[event.task])
                if rap is not None:
                    rap.failed[event.reason] = rap.failed.get(event.reason, 0) + 1
            case _:
                pass

    def _hear(self, event: events.Event) -> None:
        """Count what a signal has decided, and what a rule has done."""
        heard = None if self._heard is None else self._heard.heard(event)
        if heard is not None:
            rap, name, signal = heard
            method = self._method(rap, name)
            for wait in method.waits if method is not None else ():
                if wait.signal == signal:
                    _count(wait, "heard")
        if isinstance(event, events.RuleRun):
            file, _, row = event.at.rpartition(":")
            _count(self._rules.get((normpath(file), int(row))), "ran")

    def context(self, rap: str, method: str, holds: bool) -> None:
        """Count that the context of a method was asked."""
        asked = "context_true" if holds else "context_false"
        _count(self._method(rap, method), asked)
        self._ask((rap, method, "context"))

    def _ask(self, asker: Asker) -> None:
        """Count that a clause was asked, and the queries that it names."""
        for name in self._asked_with.get(asker, ()):
            assert self._library is not None
            _count(self._queries.get(_key(self._library.queries[name])), "asked")

    def _rap(self, name: str) -> RapCoverage | None:
        """Return what is known of a RAP of the library that runs."""
        form = self._library.raps.get(name) if self._library is not None else None
        return None if form is None else self._raps.get(_key(form))

    def _method(self, rap: str, name: str) -> MethodCoverage | None:
        found = self._rap(rap)
        named = (m for m in found.methods if m.name == name) if found else iter(())
        return next(named, None)

    def _monitor(self, task: int) -> MonitorCoverage | None:
        found = self._rap(self._tasks[task])
        return None if found is None else found.monitor

    def files(self) -> tuple[FileCoverage, ...]:
        """Return what was counted of all files of all libraries, by name."""
        for agenda in self._agendas.values():
            for task in agenda.tasks:
                task.given = self._given[task.goal]
        for rap in self._raps.values():
            rap.failed = dict(sorted(rap.failed.items()))
        tables = (self._raps, self._queries, self._agendas, self._rules)
        names = sorted({file for table in tables for file, _ in table})
        return tuple(
            [
                FileCoverage(
                    name,
                    _of_file(name, self._raps),
                    _of_file(name, self._queries),
                    _of_file(name, self._agendas),
                    _of_file(name, self._rules),
                )
                for name in names
            ]
        )


def _count(record: msgspec.Struct | None, what: str) -> None:
    """Add one to a count of a record; nothing where there is none to be counted."""
    number = getattr(record, what, None)
    if number is not None:
        setattr(record, what, number + 1)


# --- what stands in the files ---------------------------------------------------------


def _rap(library: Library, rap: nodes.DefineRap) -> RapCoverage:
    monitored = rap.monitor_state is not None or rap.monitor_time is not None
    return RapCoverage(
        rap.name,
        _row(library, rap),
        tuple([_method(library, method) for method in rap.methods]),
        MonitorCoverage() if monitored else None,
    )


def _method(library: Library, method: nodes.Method) -> MethodCoverage:
    waits: dict[str, WaitCoverage] = {}
    for wait in waits_of(method):
        waits.setdefault(wait.signal, WaitCoverage(wait.signal, _row(library, wait)))
    asked = None if method.context is None else 0
    return MethodCoverage(
        traced_name(method),
        _row(library, method),
        context_true=asked,
        context_false=asked,
        constraints_broken=None if method.constraints is None else 0,
        waits=tuple(waits.values()),
    )


def _agenda(library: Library, agenda: nodes.DefineAgenda) -> AgendaCoverage:
    tasks = [
        GivenCoverage(format_list(flat(task.goal)), _row(library, task))
        for task in agenda.tasks
    ]
    return AgendaCoverage(agenda.name, _row(library, agenda), tuple(tasks))


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


_Form = TypeVar("_Form", nodes.DefineRap, nodes.DefineQuery, nodes.DefineAgenda)


def _outside_tests(forms: Iterable[_Form]) -> Iterator[_Form]:
    """Yield the forms that stand in no file of tests."""
    return (form for form in forms if not form.span.file.endswith(TEST_SUFFIX))


def _key(
    form: nodes.DefineRap | nodes.DefineQuery | nodes.DefineAgenda,
) -> tuple[str, str]:
    """Return the file of a form, by one name however it was reached, and its name."""
    return normpath(form.span.file), form.name


_Rowed = TypeVar("_Rowed", RapCoverage, QueryCoverage, AgendaCoverage, RuleCoverage)


def _of_file(file: str, table: Mapping[tuple[str, Any], _Rowed]) -> tuple[_Rowed, ...]:
    """Return what stands in a file in the order of its rows."""
    found = [one for (where, _), one in table.items() if where == file]
    return tuple(sorted(found, key=lambda one: one.row))


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
