"""A journal in the debugger: the history of its run, which may still go on.

A simulator is run again, up to the last cycle that the run has reached. The answers of
every other world are those in the journal; the world itself is never asked.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from msgspec.structs import replace

from rapc.base.names import plural
from rapc.base.values import Atom
from rapc.compiler.program import Program
from rapc.debug import act_lines
from rapc.debug.history import History
from rapc.debug.log import EventLog
from rapc.durable.folder import Stored, is_running, part_file, read, read_part
from rapc.durable.past import fill, past_of
from rapc.durable.records import Record
from rapc.runtime.answers import Answers, UnknownAnswerError
from rapc.runtime.interpreter import Interpreter
from rapc.world import Drawable, Savable, Skilled, Time, Timed, World, methods_of
from rapc.worlds.registry import build_world

_WAIT = 0.1
"""The time in seconds between two looks for further records."""

_END = "end of the journal"
"""The reason for a stop at the end of the records."""

Build = Callable[[type[World], int, Mapping[str, Atom | bool]], World]


class Opened:
    """The history of a journal.

    Args:
        folder: the folder.
        follow: whether to wait for further records while the run goes on.

    Raises:
        LoadError: if the journal cannot be read or is damaged.
    """

    def __init__(self, folder: Path, *, follow: bool = False) -> None:
        self.stored: Stored = read(folder, whole=True)
        self.spec = self.stored.meta.spec
        self._folder, self._follow = folder, follow
        self._part, self._offset = self.stored.last.number, self.stored.last.end
        self._past = past_of(self.stored.records, self.stored.first_cycle)
        #: The last cycle that the run is known to have reached.
        self.cycle, self.reason = self._past.cycle, self._past.reason
        self._answers = Answers()
        self._history: History | None = None

    def __str__(self) -> str:
        """Return the extent of the journal as text."""
        cycles = plural(self.cycle, "cycle")
        if self.reason:
            return f"{cycles}, ended ({self.reason})"
        goes_on = is_running(self._folder)
        return f"{cycles}, {'the run goes on' if goes_on else 'to be resumed'}"

    def program(self) -> Program:
        """Return the library at the beginning of the history.

        Raises:
            CheckError: if the checker reports an error.
        """
        snapshot, meta = self.stored.snapshot, self.stored.meta
        first = snapshot.library if snapshot else None
        return act_lines.read_library(first or meta.library)

    def build(
        self, kind: type[World], seed: int, options: Mapping[str, Atom | bool]
    ) -> World:
        """Return a world for the history; see `build_world`."""
        if issubclass(kind, Savable):
            return build_world(kind, seed, options)
        world = _absent(kind, self.stored.meta.begun)
        world.made_with = dict(options)
        return world

    def history(self, run: Interpreter) -> History:
        """Return the history, at its beginning.

        Args:
            run: a run of `program` that has not begun, in a world that `build` made.
        """
        log, snapshot = EventLog(), self.stored.snapshot
        self._answers = answers = run.keep_answers()
        fill(answers, self.stored, self._past)
        simulated = isinstance(run.world, Savable)
        if not simulated:
            answers.closed, answers.at_end = True, self._at_end
        run.listen(log)
        if snapshot is None:
            run.start(self.spec.until)
        else:
            run.restore(snapshot.run)
        history = self._history = History(run, log, self._past.acts)
        history.spec = replace(history.spec, until=self.spec.until)
        if simulated:
            history.checks["journal"] = self._stops
        return history

    def go_to_end(self, history: History) -> None:
        """Go to the last known moment, without waiting for further records."""
        follow, self._follow = self._follow, False
        history.go()
        self._follow = follow

    # --- further records ----------------------------------------------------------

    def _stops(self) -> str | None:
        """Return the reason to stop after a cycle of a simulator, or None."""
        history = self._history
        assert history is not None
        if history.branch is not history.branches[0] or self.reason:
            return None
        while history.cycle >= self.cycle:
            if self.reason or not self._more():
                return None if self.reason else _END
        return None

    def _at_end(self, *question: object) -> bool:
        if self._more():
            return True
        raise UnknownAnswerError(_END)

    def _more(self) -> bool:
        """Read further records, and wait for them while the run goes on."""
        while not self._poll():
            history = self._history
            if (
                not self._follow
                or history is None
                or history.paused
                or not is_running(self._folder)
            ):
                return self._poll()
            time.sleep(_WAIT)
        return True

    def _poll(self) -> bool:
        """Read further records; return whether there are any."""
        folder, number = self._folder, self._part
        part = read_part(folder, number, is_last=True, start=self._offset)
        if part.records:
            self._offset = part.end
            self._add(part.records)
            return True
        if not part_file(folder, number + 1).exists():
            return False
        self._part, self._offset = number + 1, 0
        return self._poll()

    def _add(self, records: Sequence[Record]) -> None:
        found = past_of(records, self.cycle)
        self.cycle, self.reason = found.cycle, found.reason
        self._answers.kept += found.answers
        readings = found.readings
        if not found.answers:
            readings = max(readings, self._answers.readings)
        self._answers.readings = readings
        self._answers.coming.extend(found.solved)
        if self._history is not None:
            self._history.branches[0].acts += found.acts


def _absent(kind: type[World], begun: Time) -> World:
    """Return a world with the methods of a class, which have no answers."""

    def unknown(name: str) -> Callable[..., NoReturn]:
        def call(*_: object) -> NoReturn:
            raise UnknownAnswerError(f"the answer of the world to `{name}` is unknown")

        return call

    names = [
        name
        for protocol in (World, Skilled, Timed, Drawable)
        if issubclass(kind, protocol)
        for name in methods_of(protocol)
        if name != "ended" or kind.ended is not World.ended
    ]
    methods: dict[str, Any] = {name: unknown(name) for name in names}
    methods |= {"now": lambda _: begun, "facts": lambda _: ()}
    methods |= {"name": kind.name, "kit": kind.kit}
    made: World = type(kind.__name__, (World,), methods)()
    return made
