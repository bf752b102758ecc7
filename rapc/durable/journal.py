"""The journal of a run: each record is written before its content is used.

Not here: the files (`rapc.durable.folder`), and the resumption of a run
(`rapc.durable.resuming`).
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol

import msgspec

from rapc.base.writing import Output
from rapc.debug.act_lines import Library
from rapc.durable.folder import (
    Options,
    Snapshot,
    Writer,
    numbers,
    part_file,
    snapshot_file,
    write_snapshot,
)
from rapc.durable.records import (
    Acted,
    ActFailed,
    Answered,
    Ended,
    Reached,
    Record,
    Requested,
    Solved,
    framed,
)
from rapc.errors import StateError, WriteError
from rapc.runtime.answers import Answer, Answers, Goal, RecordedWorld
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.planner import Planned

CYCLES = 1_000
"""The number of cycles between two snapshots."""

SECONDS = 30.0
"""The longest time between two snapshots, if the run has gone on."""

PAUSE = 50
"""The shortest time between two snapshots, as a multiple of the time that one takes.

Both are times of the processor.
"""

_PROGRESS = 0.1
"""The time between two records of the reached cycle."""

_MOST_MESSAGES = 256
"""The number of messages of a world after which they are acknowledged."""

_MEGABYTE = 1 << 20


class Report(Protocol):
    """A listener whose state is part of a snapshot."""

    def state(self) -> bytes:
        """Return the state."""

    def take_up(self, state: bytes) -> None:
        """Replace the state. Raises ValueError."""


class Trace:
    """The file of a trace that can be continued after a crash.

    Args:
        path: the file.
        size: the number of bytes to keep; what follows is cut off.

    Raises:
        WriteError: if the file cannot be written, or has fewer bytes.
    """

    def __init__(self, path: Path, size: int = 0) -> None:
        self.path = path
        output = Output(path, "r+" if size else "w")
        if output.seek(0, os.SEEK_END) < size:
            output.close()
            raise WriteError(f"cannot continue the trace `{path}`: it is too short")
        output.seek(size)
        output.truncate()
        self._file, self._stream = output, output.text()
        #: Write text.
        self.write = self._stream.write

    def size(self) -> int:
        """Flush the stream; return the size of the file."""
        self._stream.flush()
        return self._file.tell()

    def close(self) -> None:
        """Close the file."""
        self._stream.close()


class Journal:
    """The journal of a run, open to be written.

    Args:
        folder: the folder.
        writer: the writer of the last part.
        options: the options of the journal.
        reports: listeners whose state is part of a snapshot.
    """

    def __init__(
        self,
        folder: Path,
        writer: Writer,
        options: Options,
        reports: Sequence[Report] = (),
    ) -> None:
        self.folder = folder
        self._reports = reports
        self._writer = writer
        self._sync, self._limit = options.sync, options.limit * _MEGABYTE
        self._before = _size_of(folder, writer.number)
        #: The library of the run, if an act has replaced the first library.
        self.library: Library | None = None
        self.run: Interpreter | None = None
        self._answers = Answers()
        self._world: RecordedWorld | None = None
        self._acknowledge: Callable[[int], None] | None = None
        self._acknowledged = 0
        self._next_progress = 0.0
        #: The cycle and the time of the last snapshot.
        self._last = 0, time.monotonic()
        #: The processor time before which there is no further snapshot.
        self._pause = 0.0

    def follow(self, run: Interpreter) -> None:
        """Receive the answers of a run from now on."""
        self.run = run
        world = run.port.behind
        self._world = world if isinstance(world, RecordedWorld) else None
        self._acknowledge = getattr(run.port, "acknowledge", None)
        self._answers = run.keep_answers()
        self._answers.store = self
        self._last = run.cycle, time.monotonic()

    # --- records ------------------------------------------------------------------

    def asking(self, readings: int, call: str, asked: tuple[Any, ...]) -> None:
        """Write a request, before the world receives the request."""
        self._write(Requested(readings, call, asked))
        if self._sync != "off":
            self._synced()

    def keep(self, answer: Answer) -> None:
        """Write an answer of the world.

        An answer that no world may give is not written; it ends the run.
        """
        call = answer.call
        try:
            data = framed(Answered(answer.readings, call, answer.asked, answer.told))
        except (TypeError, ValueError, OverflowError):
            return
        self._writer.write(data)
        world = self._world
        if self._sync == "always" or (
            world is not None
            and world.received - self._acknowledged >= _MOST_MESSAGES
            and call == "messages"
        ):
            self._synced()

    def solved(self, cycle: int, goal: Goal, methods: Any) -> None:
        """Write the methods of a solver; invalid ones end the run."""
        try:
            if isinstance(methods, Planned):
                record = Solved(cycle, str(goal[0]), (), methods)
            else:
                record = Solved(cycle, str(goal[0]), tuple(methods))
            data = framed(record)
        except TypeError:
            return
        self._writer.write(data)

    def act(self, cycle: int, arrivals: int, act: msgspec.Struct) -> None:
        """Write an act of the host, before the act is performed."""
        assert self.run is not None
        now = self.run.now
        self._write(Acted(self._readings, cycle, arrivals, now, act))
        if self._sync != "off":
            self._synced()

    def void(self) -> None:
        """Write that the last act has failed."""
        self._write(ActFailed())

    def ended(self) -> None:
        """Write the end of the run."""
        run = self.run
        assert run is not None
        self._write(Ended(self._readings, run.cycle, run.now, run.reason or ""))
        if self._sync != "off":
            self._synced()

    @property
    def _readings(self) -> int:
        return self._answers.position.readings

    @property
    def _repeats(self) -> bool:
        """Whether the run repeats the contents of the journal."""
        return self._answers.at_end is not None

    def _write(self, record: Record) -> None:
        self._writer.write(framed(record))

    def _synced(self) -> None:
        """Wait for the disk; then let the world forget the messages."""
        self._writer.sync()
        self.acknowledge()

    def acknowledge(self) -> None:
        """Let the world forget the messages that are in the journal."""
        world, tell = self._world, self._acknowledge
        if world is None or tell is None or world.received == self._acknowledged:
            return
        if self._repeats:
            return
        self._acknowledged = world.received
        tell(world.received)

    # --- snapshots ----------------------------------------------------------------

    def after_cycle(self, trace: Trace | None, *, arrivals: int = 0) -> None:
        """Write a snapshot or the reached cycle, if it is time for that."""
        run = self.run
        assert run is not None
        if self._repeats:
            return
        clock = time.monotonic()
        cycle, since = self._last
        due = run.cycle - cycle >= CYCLES and time.process_time() >= self._pause
        due = due or clock - since >= SECONDS
        due = due and run.cycle > cycle and run.reason is None
        if due or clock >= self._next_progress:
            self._next_progress = clock + _PROGRESS
            self._write(Reached(self._readings, run.cycle, run.now))
        if due:
            self.snapshot(trace, arrivals)

    def snapshot(self, trace: Trace | None, arrivals: int = 0) -> None:
        """Write a snapshot and begin a new part.

        A run that cannot be saved has no snapshots: it is repeated from the beginning.
        """
        run = self.run
        assert run is not None
        begun = time.process_time()
        self._last = run.cycle, time.monotonic()
        try:
            state = run.save()
        except StateError:
            return
        number = self._writer.number + 1
        end = self._answers.end
        size = None if trace is None else trace.size()
        moment = run.cycle, arrivals, run.now
        reports = tuple([one.state() for one in self._reports])
        write_snapshot(
            self.folder,
            Snapshot(number, *moment, end, size, self.library, state, reports),
        )
        writer = Writer(self.folder, number)
        self._writer.close()
        self._before += self._writer.end + len(state)
        self._writer = writer
        self.acknowledge()
        if self._before > self._limit:
            self._before = drop(self.folder, number, self._limit)
        taken = time.process_time() - begun
        self._pause = begun + PAUSE * taken

    def close(self) -> None:
        """Close the files."""
        self._writer.close()


def _size_of(folder: Path, last: int) -> int:
    """Return the size of the parts and snapshots before the last part."""
    parts, snapshots = numbers(folder)
    files = [part_file(folder, one) for one in parts if one != last]
    files += [snapshot_file(folder, one) for one in snapshots]
    return sum(file.stat().st_size for file in files)


def drop(folder: Path, last: int, limit: int) -> int:
    """Remove the oldest parts until the size is within a limit; return the size.

    The last snapshot and the last part stay.
    """
    size = _size_of(folder, last)
    parts, snapshots = numbers(folder)
    for number in sorted({*parts, *snapshots}):
        if size <= limit or number >= last:
            break
        for file in (snapshot_file(folder, number), part_file(folder, number)):
            if file.exists():
                size -= file.stat().st_size
                file.unlink()
    return size
