"""Files of recorded runs, with access to events by row, cycle and time.

A trace may be larger than memory. Therefore a recording reads blocks of lines on
demand. It keeps the offset, the first cycle and the first time of each block. Not here:
the decoding of lines (`rapc.debug.recorded_lines`).
"""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Collection, Iterator, Sequence
from io import SEEK_END
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple, TypeVar

import msgspec
from msgspec.json import Decoder

from rapc import events
from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.names import plural
from rapc.base.values import number
from rapc.debug.log import MOST, ToldEvent, Want
from rapc.debug.recorded_lines import Count, Number, as_told, event_lines
from rapc.errors import LoadError, reason
from rapc.events import Event
from rapc.runtime.interpreter import TRACE_FORMAT
from rapc.spec import RunSpec
from rapc.world import Time

_ROWS = 256
"""The number of lines in a block."""

_BLOCKS = 8
"""The number of blocks in the cache."""

_TAIL = 65_536
"""The number of bytes at the end of a file that are searched first."""

_WHOLE = 3
"""The number of parts needed to find the last whole line; the first may be cut."""

_LEAVING = ("primitive-cancelled", "skill-disabled")
"""Further events when a task is removed with an ancestor."""

_STARTED = "run-started"
_ENDED = "run-ended"

_T = TypeVar("_T")


class _Started(msgspec.Struct, frozen=True):
    """The keys of the first line: the options of the run."""

    spec: RunSpec


class _Format(msgspec.Struct, frozen=True):
    """The version of the trace format, in the first line."""

    format: int = TRACE_FORMAT


class _Tag(msgspec.Struct, frozen=True):
    """The key of a line with the kind of the event."""

    event: str


class _Head(msgspec.Struct, frozen=True, gc=False):
    """The keys of a line that the search uses."""

    event: str
    n: Count
    cycle: Count
    time: Number
    #: The reason for the removal of a task.
    cause: str = ""

    @property
    def ends(self) -> bool:
        """Whether the event belongs to the end of a run, which removes all tasks."""
        return self.event == _ENDED or self.cause == "run-over"

    @property
    def leaves(self) -> bool:
        """Whether the event belongs to the removal of an ancestor."""
        return self.event in _LEAVING or self.cause == "parent-removed"


class _Tail(msgspec.Struct, frozen=True):
    """The keys of the last line."""

    event: str
    cycle: Count
    reason: str = ""


_TAG, _HEAD, _TAIL_OF = Decoder(_Tag), Decoder(_Head), Decoder(_Tail)
_BEGUN, _FORMAT = Decoder(_Started), Decoder(_Format)


class _Block(NamedTuple):
    """A block of successive lines, from a row on."""

    row: int
    lines: Sequence[bytes]
    heads: Sequence[_Head]
    #: The error in the line after the block, if any.
    wrong: LoadError | None


class Recording:
    """A file with the trace of a run, in the form jsonl.

    Every method that reads the file raises LoadError if the file is unreadable or
    damaged.

    Args:
        path: the file.

    Raises:
        LoadError: if the file is unreadable, or not the trace of a run from its
            beginning.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        #: The offset of each block, and the cycle and time of its first event.
        self._offsets: list[int] = []
        self._cycles: list[int] = []
        self._times: list[Time] = []
        #: The next offset and row, and the last event, after the known blocks.
        self._offset = 0
        self._rows = 0
        self._last: _Head | None = None
        self._complete = False
        self._wrong: LoadError | None = None
        #: The row of the first event of the end of the run; None while unknown.
        self._end: int | None = None
        self._kept: deque[_Block] = deque(maxlen=_BLOCKS)
        #: The options of the run.
        self.begun = self._spec()
        tail = self._tail()
        #: The number of the last cycle.
        self.last_cycle = tail.cycle
        #: The end reason of the run; empty if the trace was cut off before.
        self.reason = tail.reason if tail.event == _ENDED else ""

    def __str__(self) -> str:
        """Return the extent of the recording as text."""
        cycles = plural(self.last_cycle, "cycle")
        return f"{cycles}, {f'ended ({self.reason})' if self.reason else 'cut off'}"

    # --- the first line and the last ------------------------------------------------

    def _spec(self) -> RunSpec:
        line = self._bytes(0, lambda file: file.readline())
        said = f"`{self.path}` is not a trace from the start of a run"
        if not line or self._decoded(line, 0, _TAG).event != _STARTED:
            raise LoadError(said)
        version = self._decoded(line, 0, _FORMAT).format
        if version != TRACE_FORMAT:
            found = f"trace format {version}, not {TRACE_FORMAT}"
            raise LoadError(
                f"`{self.path}` was written by another version of rapc: {found}"
            )
        return self._decoded(line, 0, _BEGUN).spec

    def _tail(self) -> _Tail:
        """Return the last complete line; a trace may be cut off within a line."""
        size = self._bytes(0, lambda file: file.seek(0, SEEK_END))
        length, lines = _TAIL, [b""]
        while len(lines) < _WHOLE and length < _TAIL + size * 2:
            start = max(size - length, 0)
            lines = self._bytes(start, lambda file: file.read()).splitlines(True)
            length *= 4
        cut = len(lines) > 1 and _is_cut(lines[-1])
        return self._decoded(lines[-2] if cut else lines[-1], None, _TAIL_OF)

    # --- finding events -------------------------------------------------------------

    @property
    def rows(self) -> int:
        """The number of events."""
        self._grow(lambda last: False)
        return self._rows

    def row_after(self, cycle: int) -> int:
        """Return the row of the first event after the end of a cycle.

        After the last cycle, return the row of the first event of the end of the run.
        """
        self._grow(lambda last: last.cycle > cycle)
        before = bisect_right(self._cycles, cycle)
        return self._first_row(before, lambda head: head.cycle > cycle)

    def row_later(self, time: Time) -> int:
        """Return the row of the first event after a time, or of the end of the run."""
        self._grow(lambda last: last.time > time)
        before = bisect_right(self._times, time)
        return self._first_row(before, lambda head: head.time > time)

    def _first_row(self, blocks: int, wanted: Callable[[_Head], bool]) -> int:
        """Return the first wanted row; the first `blocks` blocks begin unwanted."""
        if blocks == 0:
            return 0
        block = self._block(blocks - 1)
        rows = (at for at, head in enumerate(block.heads, block.row) if wanted(head))
        row = next(rows, block.row + len(block.heads))
        return row if self._end is None else min(row, self._end)

    def time_of(self, row: int) -> Time:
        """Return the time of the event in a row."""
        return number(self._block(row // _ROWS).heads[row % _ROWS].time)

    def cycle_of(self, row: int) -> int:
        """Return the cycle of the event in a row."""
        return self._block(row // _ROWS).heads[row % _ROWS].cycle

    def scan(
        self, first: int, until: int, kinds: Collection[type[Any]] = ()
    ) -> Iterator[ToldEvent]:
        """Yield the events in a range of rows, of the given kinds (default: all)."""
        for row, line in self._lines(range(first, until), kinds):
            yield as_told(row, self._decoded(line, row, event_lines()))

    def backwards(
        self, until: int, kinds: Collection[type[Any]] = ()
    ) -> Iterator[ToldEvent]:
        """Yield the events before a row, latest first; see `scan`."""
        for row, line in self._lines(range(until - 1, -1, -1), kinds):
            yield as_told(row, self._decoded(line, row, event_lines()))

    def lines(self) -> Iterator[bytes]:
        """Yield the lines of the file, including damaged lines."""
        offset = 0
        while lines := self._bytes(offset, _next_lines):
            yield from lines
            offset += sum(map(len, lines))

    def written(self, kinds: Collection[type[Any]]) -> Iterator[dict[str, Any]]:
        """Yield all events of the given kinds in the form of the file."""
        for row, line in self._lines(range(self.rows), kinds):
            event = self._decoded(line, row, event_lines())
            yield msgspec.to_builtins(event)

    def _lines(
        self, rows: range, kinds: Collection[type[Any]]
    ) -> Iterator[tuple[int, bytes]]:
        """Yield the rows and lines of the events of the given kinds (default: all)."""
        tags = {str(kind.__struct_config__.tag) for kind in kinds}
        block = None
        for row in rows:
            if block is None or block.row != row - row % _ROWS:
                block = self._block(row // _ROWS)
            if not tags or block.heads[row % _ROWS].event in tags:
                yield row, block.lines[row % _ROWS]

    # --- reading --------------------------------------------------------------------

    def _grow(self, enough: Callable[[_Head], bool]) -> None:
        """Read blocks until `enough` accepts the last event, or to the end."""
        while not self._complete and (self._last is None or not enough(self._last)):
            if self._wrong is not None:
                raise self._wrong
            block = self._read(self._offset, self._rows, self._last)
            if block.heads:
                self._offsets.append(self._offset)
                self._cycles.append(block.heads[0].cycle)
                self._times.append(block.heads[0].time)
                self._last = block.heads[-1]
                self._kept.append(block)
            if self._end is None:
                ends = (at for at, one in enumerate(block.heads, block.row) if one.ends)
                found = next(ends, None)
                self._end = None if found is None else self._with_leaving(found)
            self._offset += sum(map(len, block.lines))
            self._rows += len(block.heads)
            self._wrong = block.wrong
            self._complete = self._wrong is None and len(block.heads) < _ROWS

    def _with_leaving(self, row: int) -> int:
        """Return the first row of the removals that directly precede a row."""
        while row and self._block((row - 1) // _ROWS).heads[(row - 1) % _ROWS].leaves:
            row -= 1
        return row

    def _block(self, at: int) -> _Block:
        """Return a known block by number, from the cache or the file."""
        row = at * _ROWS
        for block in self._kept:
            if block.row == row:
                return block
        block = self._read(self._offsets[at], row, None)
        self._kept.append(block)
        return block

    def _read(self, offset: int, row: int, last: _Head | None) -> _Block:
        """Read the block at an offset; `row` and `last` describe its start."""
        lines = self._bytes(offset, _next_lines)
        if lines and row + len(lines) > 1 and _is_cut(lines[-1]):
            lines.pop()
        heads: list[_Head] = []
        for at, line in enumerate(lines, row):
            try:
                last = self._head(line, at, last)
            except LoadError as wrong:
                return _Block(row, lines[: len(heads)], heads, wrong)
            heads.append(last)
        return _Block(row, lines, heads, None)

    def _head(self, line: bytes, row: int, last: _Head | None) -> _Head:
        """Return the validated head of a line; `last` is the preceding head."""
        head = self._decoded(line, row, _HEAD)
        wrong = ""
        if head.event not in events.kinds():
            wrong = f"has the unknown event `{head.event}`"
        elif head.n != row or (
            last is not None and (head.cycle < last.cycle or head.time < last.time)
        ):
            wrong = "is out of order"
        if wrong:
            raise LoadError(f"`{self.path}` is not a trace: line {row + 1} {wrong}")
        return head

    def _bytes(self, offset: int, read: Callable[[BinaryIO], _T]) -> _T:
        """Return the result of `read` on the file, opened at an offset."""
        try:
            with self.path.open("rb") as file:
                file.seek(offset)
                return read(file)
        except OSError as error:
            said = f"cannot read `{self.path}`: {reason(error)}"
            raise LoadError(said) from error

    def _decoded(self, line: bytes, row: int | None, decoder: Decoder[_T]) -> _T:
        """Return the decoded line; `row` is None for the last line."""
        try:
            return decoder.decode(line)
        except UNREADABLE as error:
            where = "the last line" if row is None else f"line {row + 1}"
            said = f"`{self.path}` is not a trace: {where}: {flaw(error)}"
            raise LoadError(said) from error


class Playback:
    """A recorded run without library or world; it begins before its first cycle.

    A playback keeps only its position and reads events again on demand. Methods that
    read the recording raise LoadError if the recording is damaged.

    Args:
        recording: the file.
    """

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        #: The specification of the run.
        self.spec = recording.begun
        self.last_cycle = recording.last_cycle
        self.goto(0)

    def goto(self, cycle: int) -> None:
        """Go to the end of a cycle; after the last cycle, to the end of the run."""
        recording, over = self._recording, cycle > self.last_cycle
        #: The row of the next event.
        self.serial = recording.rows if over else recording.row_after(cycle)
        #: The number of the present cycle.
        self.cycle = min(cycle, self.last_cycle)
        self._over = over

    def step(self) -> bool:
        """Go to the end of the next cycle; return False if the run is over."""
        self.goto(self.cycle + 1)
        return not self._over

    @property
    def now(self) -> Time:
        """The time of the last event up to the present moment."""
        return self._recording.time_of(self.serial - 1) if self.serial else 0

    @property
    def reason(self) -> str:
        """The end reason of the run; empty before its end."""
        return (self._recording.reason or "end of the recording") if self._over else ""

    def cycle_by(self, time: Time) -> int:
        """Return the last cycle that ended at or before a time."""
        row = self._recording.row_later(time)
        if row == self._recording.rows:
            return self.last_cycle + 1
        cycle = self._recording.cycle_of(row)
        return cycle if row == self._recording.row_after(cycle) else cycle - 1

    def seek(self, kinds: Collection[type[Event]], want: Want) -> ToldEvent | None:
        """Go to the cycle of the next wanted event; return the event or None."""
        told = self._recording.scan(self.serial, self._recording.rows, kinds)
        found = next(filter(want, told), None)
        if found is not None:
            at_end = found.serial >= self._recording.row_after(found.cycle)
            self.goto(found.cycle + at_end)
        return found

    def has(self, cycle: int) -> bool:
        """Return True: a recording has all events."""
        return True

    def scan(
        self, cycle: int, kinds: Collection[type[Event]] = (), want: Want | None = None
    ) -> Iterator[ToldEvent]:
        """Yield the events from a cycle to the present moment, filtered."""
        first = self._recording.row_after(cycle - 1)
        told = self._recording.scan(first, self.serial, kinds)
        return told if want is None else filter(want, told)

    def backwards(self, *kinds: type[Event]) -> Iterator[ToldEvent]:
        """Yield the events up to the present moment, latest first."""
        return self._recording.backwards(self.serial, kinds)

    def since(self, serial: int) -> list[ToldEvent]:
        """Return the events from a row on: at most the latest `MOST`."""
        first = max(serial, self.serial - MOST)
        return list(self._recording.scan(first, self.serial))


def _next_lines(file: BinaryIO) -> list[bytes]:
    """Return the next lines of a file, at most a block."""
    return list(islice(file, _ROWS))


def _is_cut(line: bytes) -> bool:
    """Return whether the last line of a file is incomplete."""
    if line.endswith(b"\n"):
        return False
    try:
        _TAG.decode(line)
    except UNREADABLE:
        return True
    return False
