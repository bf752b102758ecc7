"""The libraries of a workspace, checked in one worker thread while the user types.

The thread of the protocol holds the buffers. The worker loads and checks libraries with
the texts of the buffers, first for errors, then, when the user pauses, for all rules.
Each result is a `Snapshot`, which never changes. An edit abandons a check under way.
"""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from pathlib import Path

import msgspec

from rapc.analysis import baseline, config, registry
from rapc.analysis.check_files import loaded_libraries
from rapc.analysis.config import Configured
from rapc.analysis.config_file import ConfigError, nearest_config
from rapc.analysis.driver import CheckReport, check_libraries
from rapc.analysis.facts.index import Index
from rapc.analysis.selection import Selection, UnknownRuleError, by_default
from rapc.base.files import names_at, path_of, read_text
from rapc.errors import Error, LoadError, in_a_line
from rapc.library.loader import Loaded, Units
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


class Member(msgspec.Struct, frozen=True):
    """A library of the workspace: the paths that `rapc check` would be given."""

    #: Files and folders.
    paths: tuple[str, ...]


class Part:
    """A linked library; its index and signatures are made when they are needed."""

    def __init__(self, loaded: Loaded) -> None:
        self.loaded = loaded
        self.library = loaded.library

    @cached_property
    def index(self) -> Index:
        """The nodes and names of the library."""
        return Index(self.library)

    @cached_property
    def signatures(self) -> Signatures:
        """The declared names of the library."""
        return Signatures.of(self.library)

    @cached_property
    def units(self) -> Mapping[str, SourceUnit]:
        """The files of the library by name."""
        return {unit.file.name: unit for unit in self.loaded.units}


class Snapshot(msgspec.Struct, frozen=True, eq=False):
    """A library at a moment: its parts, its findings and the state of the buffers."""

    member: Member
    #: The library, then a library for each group of test files.
    parts: tuple[Part, ...]
    report: CheckReport
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
        """Return whether a file is below the paths of the library."""
        real = os.path.realpath(path_of(name))
        return any(
            real == folder or real.startswith(folder + os.sep)
            for folder in map(os.path.realpath, self.member.paths)
        )


class Work(msgspec.Struct, frozen=True):
    """The state of the buffers for the worker."""

    texts: Mapping[str, str]
    revisions: Mapping[str, int]
    folders: tuple[str, ...]


class _State:
    """The progress of the checks of a library."""

    def __init__(self) -> None:
        self.files: frozenset[str] = frozenset()
        self.done = 0
        #: The state of the files that the last error check and full check have seen.
        self.errors_at = -1
        self.whole_at = -1
        #: The last change of a file of the library.
        self.changed_at = 0


Publish = Callable[[Snapshot], None]


class Worker:
    """The thread that loads and checks libraries.

    Args:
        delays: the times to wait after an edit.
        publish: receives each snapshot, in the worker's thread.
        log: receives messages about faults, in the worker's thread.
        clock: the time in seconds.
    """

    def __init__(
        self,
        delays: Delays,
        publish: Publish,
        log: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._delays = delays
        self._publish = publish
        self._log = log
        self._clock = clock
        self._units = Units()
        self._states: dict[Member, _State] = {}
        self._changed = threading.Condition()
        self._work = Work({}, {}, ())
        self._opened: dict[str, int] = {}
        #: The number of changes so far, and the time of the last one.
        self._now = 0
        self._last = 0.0
        self._stopped = False
        self._discovered_at = -1
        self._moved_at = 0
        self._thread = threading.Thread(target=self._run, daemon=True, name="checks")

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """Abandon the check under way, and end the thread."""
        with self._changed:
            self._stopped = True
            self._changed.notify()

    def tell(self, work: Work, name: str | None = None, *, typed: bool = False) -> None:
        """Replace the state of the buffers after a change.

        Args:
            work: the buffers.
            name: the file that has changed; None if any file may have changed, and
                files may have been added or removed.
            typed: whether the user has typed, and the check waits for a pause.
        """
        with self._changed:
            self._work = work
            self._now += 1
            if typed:
                self._last = self._clock()
            for state in self._states.values():
                if name is None or name in state.files or not state.files:
                    state.changed_at = self._now
            if name is None or not typed:
                self._moved_at = self._now
            self._changed.notify()

    # --- the thread -----------------------------------------------------------------

    def _run(self) -> None:
        while (job := self._next()) is not None:
            try:
                job()
            except AbandonedError:
                continue
            except Error as error:
                self._log(error.message)

    def _next(self) -> Callable[[], None] | None:
        """Wait for a job and return it; None when the worker is stopped."""
        with self._changed:
            while not self._stopped:
                job, wait = self._due()
                if job is not None:
                    return job
                self._changed.wait(wait)
        return None

    def _due(self) -> tuple[Callable[[], None] | None, float | None]:
        """Return the next job, or the time until one is due."""
        quiet = self._clock() - self._last
        if self._discovered_at < self._moved_at:
            return self._discover, None
        opened = self._work.revisions
        states = sorted(
            self._states.items(),
            key=lambda one: not any(name in one[1].files for name in opened),
        )
        for at_field, delay in (
            ("errors_at", self._delays.errors),
            ("whole_at", self._delays.everything),
        ):
            for member, state in states:
                if getattr(state, at_field) < state.changed_at:
                    if quiet < delay:
                        return None, delay - quiet
                    whole = at_field == "whole_at"
                    return (lambda m=member, w=whole: self._check(m, w)), None
        return None, None

    def _discover(self) -> None:
        """Find the libraries of the workspace."""
        with self._changed:
            work, now = self._work, self._now
        members = list(members_of(work))
        with self._changed:
            known = self._states
            self._states = {}
            for member in members:
                state = known.get(member) or _State()
                state.changed_at = max(state.changed_at, 0)
                self._states[member] = state
            self._discovered_at = now

    def _check(self, member: Member, whole: bool) -> None:
        """Load and check a library, and publish the snapshot."""
        with self._changed:
            work, now = self._work, self._now
            state = self._states[member]

        def going() -> None:
            if state.changed_at > now or self._stopped:
                raise AbandonedError

        loads, unreadable = self._loads(member, work)
        state.files = frozenset(name for one in loads for name in one.files)
        going()
        configured, selection = _configured(member, unreadable)
        if not whole:
            enabled = selection.enabled & registry.errors()
            selection = msgspec.structs.replace(selection, enabled=enabled)
        report = check_libraries(loads, selection, member.paths, going)
        if (file := configured.beside(configured.config.baseline)) is not None:
            report = baseline.compare(report, file).report
        parts = tuple(map(Part, loads))
        snapshot = Snapshot(member, parts, report, whole, work.revisions, unreadable)
        for part in parts[:1]:
            _ = part.index, part.signatures
        if whole:
            state.whole_at = now
        state.errors_at = now
        self._publish(snapshot)

    def _loads(self, member: Member, work: Work) -> tuple[list[Loaded], dict[str, str]]:
        """Load a library; a file that cannot be read counts as empty."""
        unreadable: dict[str, str] = {}
        try:
            return list(loaded_libraries(member.paths, work.texts, self._units)), {}
        except LoadError:
            texts = dict(work.texts)
            paths = [path for path in member.paths if os.path.exists(path_of(path))]
            for name in (name for path in paths for name in names_at(path, True)):
                if name not in texts:
                    try:
                        read_text(path_of(name))
                    except LoadError as error:
                        unreadable[name] = error.message
                        texts[name] = ""
            return list(loaded_libraries(paths, texts, self._units)), unreadable


def _configured(
    member: Member, unreadable: dict[str, str]
) -> tuple[Configured, Selection]:
    """Return the configuration of a library; note an invalid one as unreadable."""
    try:
        configured = nearest_config(member.paths[0])
        return configured, configured.selection()
    except (ConfigError, LoadError, UnknownRuleError) as error:
        file = next(config.files(Path(member.paths[0])))
        unreadable[str(file)] = in_a_line(error)
        return Configured(), Selection(by_default())


def members_of(work: Work) -> Iterator[Member]:
    """Yield the libraries of the workspace."""
    folders = {os.path.dirname(name) for name in work.revisions}
    for folder in sorted(folders):
        yield Member((folder,))
