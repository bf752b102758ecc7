"""Test coverage of libraries: methods, monitors, queries, agendas.

A `Coverage` collects counts over any number of runs and compares the counts with the
definitions in the files of the libraries. `table` and `as_json` return the results.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from os.path import normpath
from typing import Any, NamedTuple

import msgspec

from rapc import events
from rapc.base.files import TEST_SUFFIX
from rapc.base.values import format_list
from rapc.ir import nodes, walk
from rapc.library.library import Library, own_methods
from rapc.testing.patterns import flat
from rapc.world import OKAY


class WaitCoverage(msgspec.Struct):
    """A signal that a method or a step waits for, and the count of its arrivals."""

    signal: str
    row: int
    heard: int = 0


class RuleCoverage(msgspec.Struct):
    """A query of a rule over memory, and the count of its firings."""

    #: The RAP or signal that the rule belongs to.
    name: str
    row: int
    ran: int = 0


class MethodCoverage(msgspec.Struct):
    """Counts of one method of a RAP."""

    name: str
    row: int
    chosen: int = 0
    ended_badly: int = 0
    #: How often its context held and did not hold; None without a context.
    context_true: int | None = None
    context_false: int | None = None
    #: How often its constraints ended it; None without constraints.
    constraints_broken: int | None = None
    waits: tuple[WaitCoverage, ...] = ()


class AddedMethodCoverage(MethodCoverage):
    """Counts of a method that `define-method` adds to a RAP."""

    rap: str = ""


class MonitorCoverage(msgspec.Struct):
    """Counts of the tasks that a RAP's monitor blocked and woke."""

    blocked: int = 0
    woken: int = 0


class RapCoverage(msgspec.Struct):
    """One RAP: its own methods, its monitor if present, the ends of its tasks.

    `failed` counts its failures by reason.
    """

    name: str
    row: int
    methods: tuple[MethodCoverage, ...]
    monitor: MonitorCoverage | None
    succeeded: int = 0
    failed: dict[str, int] = {}


class QueryCoverage(msgspec.Struct):
    """A named query, and the count of evaluated clauses that name the query."""

    name: str
    row: int
    asked: int = 0


class GivenCoverage(msgspec.Struct):
    """A task of an agenda, and how often it was added to a run."""

    goal: str
    row: int
    given: int = 0


class AgendaCoverage(msgspec.Struct):
    """An agenda and its tasks, in the order of the text."""

    name: str
    row: int
    tasks: tuple[GivenCoverage, ...]


class FileCoverage(msgspec.Struct):
    """One file of the library, with its definitions in the order of the text."""

    file: str
    raps: tuple[RapCoverage, ...]
    queries: tuple[QueryCoverage, ...] = ()
    agendas: tuple[AgendaCoverage, ...] = ()
    rules: tuple[RuleCoverage, ...] = ()
    #: The methods that the file adds to RAPs.
    methods: tuple[AddedMethodCoverage, ...] = ()


Asker = tuple[str, str, str]
"""A RAP, a method (no text for the RAP itself), and `context` or no text."""


class _Key(NamedTuple):
    """The key of a counted thing in a file: a form or an alternative of a rule."""

    kind: type[nodes.Node]
    #: The file, by the same name for each path to the file.
    file: str
    #: The name of the form, or the row of the alternative or of the added method.
    name: str | int


class _Task(msgspec.Struct):
    """A task of the run under way."""

    rap: str
    parent: int | None
    #: The method chosen last, as a trace names it.
    method: str = ""


class Coverage:
    """Counts of what happens in runs, by file and RAP.

    A `Coverage` listens to events (`Interpreter.listen`) and contexts
    (`Interpreter.watch_contexts`). Test files themselves are left out.
    """

    def __init__(self) -> None:
        #: The definitions in the files of all libraries.
        self._known: dict[_Key, Any] = {}
        #: How often each top-level task was added.
        self._given: Counter[str] = Counter()
        # the run under way
        self._library: Library | None = None
        self._asked_with: Mapping[Asker, frozenset[str]] = {}
        #: The keys of added methods by RAP and name.
        self._added: Mapping[tuple[str, str], _Key] = {}
        #: The methods that enable skills, in the form of `Asker`.
        self._of_skills: frozenset[tuple[str, str]] = frozenset()
        self._tasks: dict[int, _Task] = {}
        #: The latest signal, if no task has been selected since: a task that wakes, a
        #: step that ends or a primitive of skills that ends does so because of this
        #: signal.
        self._signal: str | None = None

    def begin(self, library: Library) -> None:
        """Begin to count for a run of a library."""
        self._tasks.clear()
        self._signal = None
        if library is not self._library:
            self._library = library
            self._asked_with = asked_with(library)
            self._added = {
                (rap.name, method.traced_name): _key(form, _row(library, form))
                for form, rap, method in _added(library)
            }
            self._of_skills = frozenset(
                (rap.name, method.traced_name)
                for rap in library.raps.values()
                for method in rap.methods
                if isinstance(method.body, nodes.Skills)
            )
            for key, record in _countable(library):
                if not key.file.endswith(TEST_SUFFIX):
                    self._known.setdefault(key, record)

    def __call__(self, event: events.Event) -> None:  # noqa: PLR0912  # one a kind
        """Count one event."""
        match event:
            case events.TaskCreated():
                self._tasks[event.task] = _Task(event.goal.name, event.parent)
                if event.parent is None:
                    self._given[format_list((event.goal.name, *event.goal.inputs))] += 1
            case events.TaskSelected():
                self._signal = None
                self._ask((self._tasks[event.task].rap, "", ""))
            case events.SignalReceived():
                self._signal = str(event.what[0])
            case events.MethodChosen():
                self._tasks[event.task].method = event.method
                _count(self._method(event.rap, event.method), "chosen")
                self._ask((event.rap, event.method, ""))
            case events.MethodEnded():
                self._end_method(event)
            case events.TaskBlocked() if _is_monitor(event):
                _count(self._monitor(event.task), "blocked")
            case events.TaskWoken() if _is_monitor(event):
                _count(self._monitor(event.task), "woken")
            case events.TaskWoken() if event.on.startswith("(:"):
                self._hear(self._tasks[event.task].parent)
            case events.TaskSucceeded():
                self._hear(self._tasks[event.task].parent)
                _count(self._rap(self._tasks[event.task].rap), "succeeded")
            case events.TaskFailed():
                self._hear(self._tasks[event.task].parent)
                rap = self._rap(self._tasks[event.task].rap)
                if rap is not None:
                    rap.failed[event.reason] = rap.failed.get(event.reason, 0) + 1
            case events.RuleRun():
                file, _, row = event.at.rpartition(":")
                key = _Key(nodes.Alternative, normpath(file), int(row))
                _count(self._known.get(key), "ran")
            case _:
                pass

    def _end_method(self, event: events.MethodEnded) -> None:
        task = self._tasks[event.task]
        method = self._method(task.rap, event.method)
        if (task.rap, task.method) in self._of_skills:
            self._hear(event.task)
        if event.result != OKAY:
            _count(method, "ended_badly")
            if event.because is not None and "constraints" in event.because.clause:
                _count(method, "constraints_broken")

    def _hear(self, number: int | None) -> None:
        """Count that the latest signal, if any, has decided a wait in a method."""
        if self._signal is not None and number is not None:
            task = self._tasks[number]
            method = self._method(task.rap, task.method)
            for wait in method.waits if method is not None else ():
                if wait.signal == self._signal:
                    _count(wait, "heard")

    def context(self, rap: str, method: str, holds: bool) -> None:
        """Count an evaluation of the context of a method."""
        asked = "context_true" if holds else "context_false"
        _count(self._method(rap, method), asked)
        self._ask((rap, method, "context"))

    def _ask(self, asker: Asker) -> None:
        """Count an evaluation of a clause and of the queries that it names."""
        for name in self._asked_with.get(asker, ()):
            assert self._library is not None
            query = self._library.queries[name]
            _count(self._known.get(_key(query, query.name)), "asked")

    def _rap(self, name: str) -> RapCoverage | None:
        """Return the record of a RAP of the library that runs."""
        form = self._library.raps.get(name) if self._library is not None else None
        return None if form is None else self._known.get(_key(form, form.name))

    def _method(self, rap: str, name: str) -> MethodCoverage | None:
        found = self._rap(rap)
        named = (m for m in found.methods if m.name == name) if found else iter(())
        own, key = next(named, None), self._added.get((rap, name))
        return own if key is None else self._known.get(key)

    def _monitor(self, task: int) -> MonitorCoverage | None:
        found = self._rap(self._tasks[task].rap)
        return None if found is None else found.monitor

    def files(self) -> tuple[FileCoverage, ...]:
        """Return the counts for all files of all libraries, by name."""
        found: dict[str, dict[type[nodes.Node], list[Any]]] = {}
        for key, record in sorted(self._known.items(), key=lambda item: item[1].row):
            of_file = found.setdefault(key.file, {kind: [] for kind in _KINDS})
            of_file[key.kind].append(record)
            if isinstance(record, RapCoverage):
                record.failed = dict(sorted(record.failed.items()))
            elif isinstance(record, AgendaCoverage):
                for task in record.tasks:
                    task.given = self._given[task.goal]
        return tuple(
            [
                FileCoverage(file, *[tuple(found[file][kind]) for kind in _KINDS])
                for file in sorted(found)
            ]
        )


def _count(record: msgspec.Struct | None, what: str) -> None:
    """Add one to a count of a record; do nothing if the record is None."""
    number = getattr(record, what, None)
    if number is not None:
        setattr(record, what, number + 1)


def _is_monitor(event: events.TaskBlocked | events.TaskWoken) -> bool:
    """Return whether a task waits for its monitors, not for a signal or a thing."""
    return event.holder is None and not event.on.startswith("(:")


# --- definitions in the files ---------------------------------------------------------

_KINDS = (
    nodes.DefineRap,
    nodes.DefineQuery,
    nodes.DefineAgenda,
    nodes.Alternative,
    nodes.DefineMethod,
)
"""The counted things of a file, in the order of the fields of `FileCoverage`."""


def _key(node: nodes.Node, name: str | int) -> _Key:
    return _Key(type(node), normpath(node.span.file), name)


def _countable(library: Library) -> Iterator[tuple[_Key, Any]]:
    """Yield a record for each counted thing of a library, with its key."""
    for rap in library.raps.values():
        yield _key(rap, rap.name), _rap_record(library, rap)
    for form, rap, method in _added(library):
        counts = msgspec.structs.asdict(_method_record(library, method))
        added = AddedMethodCoverage(**counts, rap=rap.name)
        yield _key(form, _row(library, form)), added
    for query in library.queries.values():
        record = QueryCoverage(query.name, _row(library, query))
        yield _key(query, query.name), record
    for agenda in library.agendas.values():
        tasks = [
            GivenCoverage(format_list(flat(task.goal)), _row(library, task))
            for task in agenda.tasks
        ]
        made = AgendaCoverage(agenda.name, _row(library, agenda), tuple(tasks))
        yield _key(agenda, agenda.name), made
    for name, rule in _rules(library):
        for alternative in rule.alternatives:
            row = _row(library, alternative)
            yield _key(alternative, row), RuleCoverage(name, row)


def _rap_record(library: Library, rap: nodes.DefineRap) -> RapCoverage:
    monitored = rap.monitor_state is not None or rap.monitor_time is not None
    return RapCoverage(
        rap.name,
        _row(library, rap),
        tuple([_method_record(library, method) for method in own_methods(rap)]),
        MonitorCoverage() if monitored else None,
    )


def _added(
    library: Library,
) -> Iterator[tuple[nodes.DefineMethod, nodes.DefineRap, nodes.Method]]:
    """Yield the added methods, each with its RAP and as a method of the RAP."""
    for form in library.methods:
        rap = library.raps[form.rap]
        yield from [(form, rap, m) for m in rap.methods if m.span == form.span]


def _method_record(library: Library, method: nodes.Method) -> MethodCoverage:
    waits: dict[str, WaitCoverage] = {}
    for wait in _waits_of(method):
        waits.setdefault(wait.signal, WaitCoverage(wait.signal, _row(library, wait)))
    asked = None if method.context is None else 0
    return MethodCoverage(
        method.traced_name,
        _row(library, method),
        context_true=asked,
        context_false=asked,
        constraints_broken=None if method.constraints is None else 0,
        waits=tuple(waits.values()),
    )


def _waits_of(method: nodes.Method) -> list[nodes.WaitFor]:
    """Return the signals that a method or a step waits for, in text order."""
    if isinstance(method.body, nodes.Skills):
        return list(method.body.waits)
    steps = method.body.steps if isinstance(method.body, nodes.TaskNet) else ()
    notes = [note for step in steps for note in step.annotations]
    return [note for note in notes if isinstance(note, nodes.WaitFor)]


def _rules(library: Library) -> Iterator[tuple[str, nodes.Rule]]:
    """Yield each rule over memory with the RAP or signal that it belongs to."""
    for memory in library.memory_rules:
        for case in memory.cases:
            for rule in case.rules:
                yield memory.index.name, rule
    for event in library.event_rules:
        for rule in event.rules:
            yield event.signal, rule


def _row(library: Library, node: nodes.Node) -> int:
    source = library.files.get(node.span.file)
    return 0 if source is None else source.position(node.span.start).row


def asked_with(library: Library) -> Mapping[Asker, frozenset[str]]:
    """Return the queries that are evaluated with a clause, by the clause's owner.

    The clauses of a RAP are evaluated when its task is selected, a context when a
    method is chosen, the other clauses of a method after the choice.
    """
    found: dict[Asker, set[str]] = {}
    for rap in library.raps.values():
        for at in walk.formulas(rap):
            method = "" if at.method is None else at.method.traced_name
            clause = "context" if at.clause.word == "context" else ""
            named = found.setdefault((rap.name, method, clause), set())
            named.update(
                part.name
                for part in walk.through_queries(at.formula, library.queries)
                if isinstance(part, nodes.Proposition) and part.name in library.queries
            )
    return {asker: frozenset(named) for asker, named in found.items() if named}


# --- results --------------------------------------------------------------------------

FORMAT = 1
"""The version of the JSON form."""

COLUMNS = {
    "methods_chosen": "methods",
    "contexts_true": "true",
    "contexts_false": "false",
    "methods_ended_badly": "bad end",
    "monitors_woken": "woken",
    "raps_failed": "failed",
}
"""The main totals, by name in JSON, with the name in the table."""

OTHERS = {
    "queries_asked": "queries asked",
    "agenda_tasks_given": "tasks of agendas given",
    "constraints_broken": "constraints of methods broken",
    "waits_heard": "awaited signals heard",
    "rules_run": "rules run",
}
"""The other totals, by name in JSON, with the name below the table."""

_NEED_NOT = ("methods_ended_badly", "raps_failed", "constraints_broken")
"""The totals that tests may omit; `--coverage-min` does not count them."""

_NAME = 24

_NOTHING = "the tests run no library outside of test files"


class Share(msgspec.Struct, frozen=True):
    """The number of exercised things, and the number of all things."""

    covered: int
    of: int


def shares(files: Iterable[FileCoverage]) -> dict[str, Share]:
    """Return the exercised share of some files, by column.

    The columns: methods chosen and methods that failed; contexts seen true and seen
    false; RAPs with a monitor that has woken a task; RAPs with a failed task; queries,
    tasks of agendas, constraints of methods.
    """
    counts: dict[str, list[int]] = {column: [] for column in (*COLUMNS, *OTHERS)}
    for file in files:
        for column, count in _counts(file):
            if count is not None:
                counts[column].append(count)
    return {c: Share(sum(n > 0 for n in many), len(many)) for c, many in counts.items()}


def _counts(file: FileCoverage) -> Iterator[tuple[str, int | None]]:
    """Yield the count of each thing in a file, with its column."""
    for rap in file.raps:
        yield "raps_failed", sum(rap.failed.values())
        yield "monitors_woken", rap.monitor.woken if rap.monitor is not None else None
    for method in (*[m for rap in file.raps for m in rap.methods], *file.methods):
        yield "methods_chosen", method.chosen
        yield "contexts_true", method.context_true
        yield "contexts_false", method.context_false
        yield "methods_ended_badly", method.ended_badly
        yield "constraints_broken", method.constraints_broken
        for wait in method.waits:
            yield "waits_heard", wait.heard
    for rule in file.rules:
        yield "rules_run", rule.ran
    for query in file.queries:
        yield "queries_asked", query.asked
    for agenda in file.agendas:
        for task in agenda.tasks:
            yield "agenda_tasks_given", task.given


def share_in_all(files: Iterable[FileCoverage]) -> Share:
    """Return the exercised share of all things that a test should exercise."""
    found = shares(files)
    parts = [share for column, share in found.items() if column not in _NEED_NOT]
    return Share(sum(p.covered for p in parts), sum(p.of for p in parts))


def per_cent(share: Share) -> str:
    """Return a share as text: `87.5 % (35 of 40)`, rounded down."""
    tenths = 1000 * share.covered // share.of if share.of else 1000
    return f"{tenths / 10:g} % ({share.covered} of {share.of})"


def verdict(files: Sequence[FileCoverage], least: float) -> tuple[bool, str]:
    """Return whether coverage is below `least` per cent, and a line about it.

    If the tests run no library, no minimum is met.
    """
    share = share_in_all(files)
    short = share.covered * 100 < least * share.of or (least > 0 and not files)
    more = f", less than the {least:g} % that are asked for" if short else ""
    return short, f"coverage: {per_cent(share) if files else _NOTHING}{more}"


def as_json(files: Sequence[FileCoverage]) -> bytes:
    """Return all counts, with the totals for each file and for all files."""
    listed = [
        {
            "file": one.file,
            "covered": shares([one]),
            "raps": one.raps,
            "queries": one.queries,
            "agendas": one.agendas,
            "rules": one.rules,
            "methods": one.methods,
        }
        for one in files
    ]
    whole = shares(files)
    told = {"format": FORMAT, "covered": whole, "files": listed}
    return msgspec.json.format(msgspec.json.encode(told), indent=2) + b"\n"


def table(files: Sequence[FileCoverage]) -> Iterator[str]:
    """Return a line for each file, a total, and what each RAP still lacks."""
    if not files:
        yield f"coverage: {_NOTHING}"
        return
    yield _line("coverage", COLUMNS.values())
    for one in files:
        yield _line(one.file, _told(shares([one])))
    whole = shares(files)
    if len(files) > 1:
        yield _line("all", _told(whole))
    others = [
        f"{words}: {whole[column].covered}/{whole[column].of}"
        for column, words in OTHERS.items()
        if whole[column].of
    ]
    if others:
        yield "; ".join(others)
    reasons: Counter[str] = Counter()
    for rap in (rap for one in files for rap in one.raps):
        reasons.update(rap.failed)
    if reasons:
        listed = ", ".join(f"{reason} {reasons[reason]}" for reason in sorted(reasons))
        yield f"tasks failed: {listed}"
    for one in files:
        yield from _lacking_in(one)


def _lacking_in(file: FileCoverage) -> Iterator[str]:
    """Yield the definitions of a file that no test has exercised."""
    for rap in file.raps:
        lacking = "; ".join(_lacking(rap))
        if lacking:
            yield f"{file.file}:{rap.row} {rap.name}: {lacking}"
    for method in file.methods:
        lacking = "; ".join(_lacking_of([method]))
        if lacking:
            yield f"{file.file}:{method.row} {method.rap}: {lacking}"
    for query in file.queries:
        if not query.asked:
            yield f"{file.file}:{query.row} {query.name}: never asked"
    for rule in file.rules:
        if not rule.ran:
            yield f"{file.file}:{rule.row} rule for {rule.name}: never run"
    for agenda in file.agendas:
        for task in agenda.tasks:
            if not task.given:
                place = f"{file.file}:{task.row}"
                yield f"{place} {agenda.name}: never given {task.goal}"


def _line(name: str, cells: Iterable[str]) -> str:
    """Return a name, cut at its front, and aligned numbers: 79 columns."""
    name = name if len(name) <= _NAME else "…" + name[1 - _NAME :]
    return f"{name:<{_NAME}}" + "".join(f"{cell:>9}" for cell in cells)


def _told(found: Mapping[str, Share]) -> list[str]:
    told = [found[column] for column in COLUMNS]
    return [f"{s.covered}/{s.of}" if s.of else "-" for s in told]


def _lacking(rap: RapCoverage) -> Iterator[str]:
    """Yield the parts of a RAP that no test has exercised, except failures."""
    yield from _lacking_of(rap.methods)
    if rap.monitor is not None and not rap.monitor.woken:
        yield "monitor never woken"


def _lacking_of(methods: Sequence[MethodCoverage]) -> Iterator[str]:
    """Yield the parts of methods that no test has exercised, except failures."""
    lacks = (
        ("never chosen", [m.name for m in methods if not m.chosen]),
        ("context never true", [m.name for m in methods if m.context_true == 0]),
        ("context never false", [m.name for m in methods if m.context_false == 0]),
    )
    for what, names in lacks:
        if names:
            yield f"{what} {' '.join(names)}"
    unheard = [w.signal for m in methods for w in m.waits if not w.heard]
    if unheard:
        yield f"never heard {' '.join(unheard)}"
