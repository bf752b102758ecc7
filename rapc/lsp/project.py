"""The libraries of a workspace, checked in threads of their own while the user types.

The thread of the protocol holds the buffers. The reader reads an edited file at once,
also during a check, and publishes its syntax errors. Then the worker loads and checks
libraries with the texts of the buffers, first for errors, then, when the user pauses,
for all rules. Each result is a `Snapshot`, which never changes. An edit abandons a
check under way.
"""

from __future__ import annotations

import os
import threading
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path

import msgspec

from rapc.analysis import baseline, config, registry
from rapc.analysis.check import Pass
from rapc.analysis.check_files import loaded_libraries
from rapc.analysis.config import Configured
from rapc.analysis.config_file import ConfigError, nearest_config
from rapc.analysis.driver import (
    CheckReport,
    Finding,
    check_libraries,
    check_syntax,
)
from rapc.analysis.facts.effects import EFFECTS
from rapc.analysis.facts.index import INDEX, Index
from rapc.analysis.facts.kinds import INFERRED
from rapc.analysis.libraries import LibrarySpec, libraries_of
from rapc.analysis.rap_cache import RapCache
from rapc.analysis.selection import Selection, UnknownRuleError, by_default
from rapc.base.files import (
    STANDARD,
    lies_in,
    path_of,
    read_text,
)
from rapc.base.gc_paused import gc_aged
from rapc.base.source import SourceFile
from rapc.errors import Error, LoadError, in_a_line
from rapc.language.complete import fits
from rapc.library.loader import Loaded, Names, Units, names_below
from rapc.library.signatures import Signatures
from rapc.parser.unit import SourceUnit


class AbandonedError(Exception):
    """A check that was ended because a file has changed."""


class Delays(msgspec.Struct, frozen=True):
    """The times, in seconds, without an edit before the checks begin."""

    #: Before the check for errors.
    errors: float = 0.15
    #: Before the check for all rules.
    everything: float = 0.4


class Part:
    """A linked library, with the facts that the checker has computed about it."""

    def __init__(self, loaded: Loaded, run: Pass | None) -> None:
        self.loaded = loaded
        self.library = loaded.library
        self.run = run or Pass(self.library, required=loaded.required)

    @property
    def index(self) -> Index:
        """The nodes of the library."""
        return self.run.result(INDEX)

    @property
    def signatures(self) -> Signatures:
        """The declared names of the library."""
        return self.run.signatures

    @cached_property
    def units(self) -> Mapping[str, SourceUnit]:
        """The files of the library by name."""
        return {unit.file.name: unit for unit in self.loaded.units}


class Snapshot(msgspec.Struct, frozen=True, eq=False):
    """A library at a moment: its parts, its findings and the state of the buffers."""

    spec: LibrarySpec
    #: The library, then a library for each group of test files.
    parts: tuple[Part, ...]
    #: The findings of each file.
    findings: Mapping[str, Sequence[Finding]]
    #: Whether all rules were checked, not only those that find errors.
    whole: bool
    #: The number of changes of each open file when the library was read.
    revisions: Mapping[str, int]
    #: The reason why a file could not be read, by file.
    unreadable: Mapping[str, str] = {}

    def part(self, name: str) -> Part | None:
        """Return the first part with a file."""
        return next((one for one in self.parts if name in one.loaded.files), None)

    def owns(self, name: str) -> bool:
        """Return whether the library begins with a file, or with a folder above it."""
        return any(lies_in(name, path) for path in self.spec.paths)


class Syntax(msgspec.Struct, frozen=True):
    """The findings of reading an edited file, before its library is checked."""

    name: str
    #: The number of changes of the file when it was read.
    revision: int
    findings: Sequence[Finding]


class Work(msgspec.Struct, frozen=True):
    """The state of the buffers for the worker."""

    texts: Mapping[str, str]
    revisions: Mapping[str, int]
    folders: tuple[str, ...]


class _State:
    """The progress of the checks of a library."""

    def __init__(self) -> None:
        #: The files of the library, and the files that each file requires.
        self.files: frozenset[str] = frozenset()
        self.required: list[Mapping[str, tuple[str, ...]]] | None = None
        #: The state of the files that the last error check and full check have seen.
        self.errors_at = -1
        self.whole_at = -1
        #: The last change of a file of the library.
        self.changed_at = 0
        self.cache = RapCache()


class Worker:
    """The thread that loads and checks libraries.

    Args:
        delays: the times to wait after an edit.
        publish: receives each snapshot, in the worker's thread.
        read: receives the syntax errors of an edited file, in that thread.
        forget: receives the libraries that are no longer there, in that thread.
        log: receives messages about faults, in the worker's thread.
        clock: the time in seconds.
    """

    def __init__(
        self,
        delays: Delays,
        publish: Callable[[Snapshot], None],
        read: Callable[[Syntax], None],
        forget: Callable[[list[LibrarySpec]], None],
        log: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._delays = delays
        self._publish = publish
        self._read = read
        self._forget = forget
        self._log = log
        self._clock = clock
        self._units = Units()
        self._states: dict[LibrarySpec, _State] = {}
        self._changed = threading.Condition()
        self._work = Work({}, {}, ())
        #: The number of changes so far, and the time of the last one.
        self._now = 0
        self._last = 0.0
        #: The edited files that were not read since, and whether the reader reads.
        self._edited: set[str] = set()
        self._is_reading = False
        self._stopped = False
        self._is_warm = False
        #: The name of each file of the workspace.
        self._names: Names = {}
        #: Whether files or `require` forms have changed since the last search.
        self._are_folders_old = True
        jobs = {"checks": self._next, "reader": self._next_read}
        self._threads = [
            threading.Thread(target=self._run, args=(one,), daemon=True, name=name)
            for name, one in jobs.items()
        ]

    def start(self) -> None:
        """Start the threads."""
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """Abandon the check under way, and end the threads."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def tell(
        self, work: Work, names: Sequence[str] = (), *, typed: bool = False
    ) -> None:
        """Replace the state of the buffers after a change.

        Args:
            work: the buffers.
            names: the names of the file that has changed; without names, any file may
                have changed.
            typed: whether the user has typed, and the check waits for a pause.
        """
        with self._changed:
            self._work = work
            self._now += 1
            if typed:
                self._last = self._clock()
                self._edited.update(names)
            for state in self._states.values():
                if not names or not state.files or state.files.intersection(names):
                    state.changed_at = self._now
            if not typed:
                self._are_folders_old = True
            self._changed.notify_all()

    # --- the threads ----------------------------------------------------------------

    def _run(self, next_job: Callable[[], Callable[[], None] | None]) -> None:
        while (job := next_job()) is not None:
            try:
                with gc_aged():
                    job()
            except AbandonedError:
                continue
            except Error as error:
                self._log(in_a_line(error))
            except Exception:  # a fault of rapc must not end the server
                self._log(traceback.format_exc())

    def _next(self) -> Callable[[], None] | None:
        """Wait for a job and return it; None when the worker is stopped."""
        with self._changed:
            while not self._stopped:
                job, wait = self._due()
                if job is not None:
                    return job
                self._changed.wait(wait)
        return None

    def _next_read(self) -> Callable[[], None] | None:
        """Wait until an edited file is to be read; None when the worker is stopped."""
        with self._changed:
            while not self._stopped:
                left = self._delays.errors - (self._clock() - self._last)
                if self._edited and left <= 0:
                    self._is_reading = True
                    return self._read_edited
                self._changed.wait(left if self._edited else None)
        return None

    def _due(self) -> tuple[Callable[[], None] | None, float | None]:
        """Return the next job, or the time until one is due."""
        quiet = self._clock() - self._last
        if self._are_folders_old:
            return self._discover, None
        if self._edited or self._is_reading:
            return None, None
        opened = self._work.revisions
        states = sorted(
            self._states.items(),
            key=lambda one: not any(name in one[1].files for name in opened),
        )
        phases = [(True, self._delays.everything)]
        if self._delays.errors < self._delays.everything:
            phases.insert(0, (False, self._delays.errors))
        for whole, delay in phases:
            for spec, state in states:
                if (state.whole_at if whole else state.errors_at) < state.changed_at:
                    if quiet < delay:
                        return None, delay - quiet
                    return partial(self._check, spec, whole), None
        return (None, None) if self._is_warm else (self._warm, None)

    def _warm(self) -> None:
        """Load the grammar of completion, before the first request for completions."""
        self._is_warm = True
        fits("")

    def _discover(self) -> None:
        """Find the libraries of the workspace."""
        with self._changed:
            work = self._work
            self._are_folders_old = False
        names: Names = {}
        specs: list[LibrarySpec] = []
        for folder in work.folders:
            try:
                names |= names_below(folder)
                configured = configuration(folder)
                specs += libraries_of(folder, configured, work.texts, self._units)
            except LoadError as error:
                self._log(error.message)
        known = {*names.values()}
        for name in work.revisions:
            if not name.startswith(STANDARD) and name not in known:
                specs.append(LibrarySpec((name,)))
        with self._changed:
            gone = [spec for spec in self._states if spec not in specs]
            self._states = {one: self._states.get(one) or _State() for one in specs}
            self._names = names
        self._forget(gone)

    def _read_edited(self) -> None:
        """Read the edited files, and publish their syntax errors."""
        with self._changed:
            work, names = self._work, sorted(self._edited)
            self._edited.clear()
            states = dict(self._states)
        try:
            self._read_files(work, names, states)
        finally:
            with self._changed:
                self._is_reading = False
                self._changed.notify_all()

    def _read_files(
        self, work: Work, names: Sequence[str], states: Mapping[LibrarySpec, _State]
    ) -> None:
        for name in names:
            spec = next((s for s, one in states.items() if name in one.files), None)
            if spec is None or name not in work.texts:
                continue
            unit = self._units(SourceFile(name, work.texts[name]))
            configured, selection = _configured(spec, {})
            if configured.config.baseline is None:
                found = check_syntax(unit, selection)
                self._read(Syntax(name, work.revisions[name], found))

    def _check(self, spec: LibrarySpec, whole: bool) -> None:
        """Load and check a library, and publish the snapshot."""
        with self._changed:
            work, now = self._work, self._now
            state = self._states[spec]
            names = dict(self._names)

        def going() -> None:
            if state.changed_at > now or self._stopped:
                raise AbandonedError

        try:
            snapshot = self._snapshot(spec, state, work, names, whole, going)
        except AbandonedError:
            raise
        except Exception:
            state.errors_at = state.whole_at = now  # do not try again at once
            raise
        if whole:
            state.whole_at = now
        state.errors_at = now
        self._publish(snapshot)

    def _snapshot(
        self,
        spec: LibrarySpec,
        state: _State,
        work: Work,
        names: Names,
        whole: bool,
        going: Callable[[], None],
    ) -> Snapshot:
        loads, unreadable = self._loads(spec, work, names)
        state.files = frozenset(name for one in loads for name in one.files)
        required = [one.required for one in loads]
        if state.required is not None and required != state.required:
            self._are_folders_old = True
        state.required = required
        going()
        configured, selection = _configured(spec, unreadable)
        if not whole:
            enabled = selection.enabled & registry.errors()
            selection = msgspec.structs.replace(selection, enabled=enabled)
        runs: dict[int, Pass] = {}

        def note(run: Pass) -> None:
            going()
            runs[id(run.library)] = run

        paths = work.folders or spec.paths
        report = check_libraries(loads, selection, paths, note, state.cache)
        report = _without_known(configured, report, unreadable)
        for run in runs.values():  # the facts of all checks take much memory
            run.keep(INDEX, INFERRED, EFFECTS)
        parts = tuple([Part(one, runs.get(id(one.library))) for one in loads])
        for part in parts:
            part.index.shrink()
        found = by_file(report)
        return Snapshot(spec, parts, found, whole, work.revisions, unreadable)

    def _loads(
        self, spec: LibrarySpec, work: Work, names: Names
    ) -> tuple[list[Loaded], dict[str, str]]:
        """Load a library; a file that cannot be read counts as empty."""
        texts = work.texts
        unreadable: dict[str, str] = {}
        try:
            return list(loaded_libraries(spec.paths, texts, self._units, names)), {}
        except LoadError as error:
            left = {name: text for name, text in texts.items() if name in spec.paths}
            every = [*names.values(), *left]
            texts = dict(texts)
            for name in every:
                if name not in texts:
                    try:
                        read_text(path_of(name))
                    except LoadError as other:
                        unreadable[name] = other.message
                        texts[name] = ""
            paths = [one for one in spec.paths if one in texts or _exists(one)]
            configured = configuration(spec.paths[0])
            if not paths and configured.config.libraries is not None:
                unreadable[str(configured.file)] = error.message
            return list(loaded_libraries(paths, texts, self._units, names)), unreadable


def _exists(name: str) -> bool:
    return os.path.exists(path_of(name))


def by_file(report: CheckReport) -> dict[str, list[Finding]]:
    """Return the findings of a report by file."""
    found: dict[str, list[Finding]] = {}
    for one in report.findings:
        found.setdefault(one.diagnostic.span.file, []).append(one)
    return found


def _without_known(
    configured: Configured, report: CheckReport, unreadable: dict[str, str]
) -> CheckReport:
    """Return a report without the findings of the baseline of the configuration."""
    file = configured.beside(configured.config.baseline)
    if file is None:
        return report
    try:
        return baseline.compare(report, file).report
    except (baseline.BaselineError, LoadError) as error:
        unreadable[str(configured.file)] = in_a_line(error)
        return report


def configuration(folder: str) -> Configured:
    """Return the configuration of a folder; an empty one if it is invalid."""
    try:
        return nearest_config(folder)
    except (ConfigError, LoadError):  # the check of each library reports it
        return Configured()


def _configured(
    spec: LibrarySpec, unreadable: dict[str, str]
) -> tuple[Configured, Selection]:
    """Return the configuration of a library; note an invalid one as unreadable."""
    try:
        configured = nearest_config(spec.paths[0])
        return configured, configured.selection()
    except (ConfigError, LoadError, UnknownRuleError) as error:
        file = next(config.files(Path(spec.paths[0])))
        unreadable[str(file)] = in_a_line(error)
        return Configured(), Selection(by_default())
