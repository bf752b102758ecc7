"""What tests have exercised of libraries: methods, contexts, monitors, failures.

A `Coverage` gathers over any number of runs and sets that against what the files of
the libraries hold. How it is told is in `rapc.console.testing.coverage_table`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from os.path import normpath

import msgspec

from rapc.base.files import TEST_SUFFIX
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.runtime.events import events
from rapc.world import OKAY


class MethodCoverage(msgspec.Struct, frozen=True):
    """How often a method was chosen, ended badly, and its context held or did not.

    The last two are None for a method without a context.
    """

    name: str
    row: int
    chosen: int
    ended_badly: int
    context_true: int | None
    context_false: int | None


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


class FileCoverage(msgspec.Struct, frozen=True):
    """One file of the library and its RAPs, in the order of the text."""

    file: str
    raps: tuple[RapCoverage, ...]


class Coverage:
    """Counts what happens in runs, by file and RAP.

    It listens to events (`Interpreter.listen`) and contexts
    (`Interpreter.watch_contexts`). Test files themselves are left out.
    """

    def __init__(self) -> None:
        self._counts: Counter[tuple[str, ...]] = Counter()
        self._tasks: dict[int, str] = {}
        self._library: Library | None = None
        self._raps: dict[tuple[str, str], tuple[nodes.DefineRap, Library]] = {}

    def begin(self, library: Library) -> None:
        """A run of this library comes next."""
        self._tasks.clear()
        if library is self._library:
            return
        self._library = library
        for rap in library.raps.values():
            if not rap.span.file.endswith(TEST_SUFFIX):
                self._raps.setdefault((_file(rap), rap.name), (rap, library))

    def __call__(self, event: events.Event) -> None:
        """Take one event into account."""
        match event:
            case events.TaskCreated():
                self._tasks[event.task] = event.goal.name
            case events.MethodChosen():
                self._count("chosen", event.rap, event.method)
            case events.MethodEnded() if event.result != OKAY:
                self._count("badly", self._tasks[event.task], event.method)
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

    def context(self, rap: str, method: str, holds: bool) -> None:
        """A method's context was asked."""
        self._count("true" if holds else "false", rap, method)

    def _count(self, what: str, name: str, *more: str) -> None:
        rap = self._library.raps.get(name) if self._library is not None else None
        if rap is not None:
            self._counts[what, _file(rap), name, *more] += 1

    # --- what it comes to ------------------------------------------------------------

    def files(self) -> tuple[FileCoverage, ...]:
        """All files of all libraries, by name."""
        found: dict[str, list[RapCoverage]] = {}
        for (file, _), (rap, library) in self._raps.items():
            found.setdefault(file, []).append(self._rap(library, file, rap))
        return tuple(
            FileCoverage(file, tuple(sorted(found[file], key=lambda rap: rap.row)))
            for file in sorted(found)
        )

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
        name = f"#{method.position}" if method.name is None else str(method.name)
        at = (file, rap.name, name)
        asked = method.context is not None
        return MethodCoverage(
            name=name,
            row=_row(library, method),
            chosen=self._counts["chosen", *at],
            ended_badly=self._counts["badly", *at],
            context_true=self._counts["true", *at] if asked else None,
            context_false=self._counts["false", *at] if asked else None,
        )


def _is_monitor(event: events.TaskBlocked | events.TaskWoken) -> bool:
    """Whether a task waits for its monitors, not for a signal or a thing."""
    return event.holder is None and not event.on.startswith("(:")


_MONITOR = ("blocked", "woken")


def _file(rap: nodes.DefineRap) -> str:
    """A file by one name, however it was reached."""
    return normpath(rap.span.file)


def _row(library: Library, node: nodes.DefineRap | nodes.Method) -> int:
    source = library.files.get(node.span.file)
    return 0 if source is None else source.position(node.span.start).row
