"""Files of recorded runs: events found by row, cycle and time, decoded when asked.

A trace may be larger than memory. It is read in blocks of lines as far as somebody
asks; of each block the offset, the first cycle and the first time are kept. Not here:
what a line holds (`rapc.debug.recorded_lines`).
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
"""How many lines a block has."""

_BLOCKS = 8
"""How many blocks are kept that were read last."""

_TAIL = 65_536
"""How many bytes at the end of a file are looked at first for the last line."""

_WHOLE = 3
"""How many parts of the end hold the last whole line: the first part may be cut."""

UNREADABLE = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)
"""What decoding a damaged line raises."""

_LEAVING = ("primitive-cancelled", "skill-disabled")
"""What else is told when a task leaves with one above it."""

_STARTED = "run-started"
_ENDED = "run-ended"

_T = TypeVar("_T")


class _Started(msgspec.Struct, frozen=True):
    """The keys of the first line: what the run was begun with."""

    spec: RunSpec


class _Format(msgspec.Struct, frozen=True):
    """The version of the trace format, in the first line."""

    format: int = TRACE_FORMAT


class _Tag(msgspec.Struct, frozen=True):
    """The key of a line that says which event it is."""

    event: str


class _Head(msgspec.Struct, frozen=True, gc=False):
    """The keys of a line by which it is found."""

    event: str
    n: Count
    cycle: Count
    time: Number
    #: Why a task was removed.
    cause: str = ""

    @property
    def ends(self) -> bool:
        """Whether the event belongs to the end of a run, at which all tasks go."""
        return self.event == _ENDED or self.cause == "run-over"

    @property
    def leaves(self) -> bool:
        """Whether the event belongs to the removal of a task above."""
        return self.event in _LEAVING or self.cause == "parent-removed"


class _Tail(msgspec.Struct, frozen=True):
    """The keys of the last line."""

    event: str
    cycle: Count
    reason: str = ""


_TAG, _HEAD, _TAIL_OF = Decoder(_Tag), Decoder(_Head), Decoder(_Tail)
_BEGUN, _FORMAT = Decoder(_Started), Decoder(_Format)


class _Block(NamedTuple):
    """Lines that follow each other, from a row on."""

    row: int
    lines: Sequence[bytes]
    heads: Sequence[_Head]
    #: What is wrong with the line behind them, if anything is.
    wrong: LoadError | None


class Recording:
    """A file with the trace of a run, in the form jsonl.

    Whatever reads it raises LoadError for a file that cannot be read or is damaged.

    Args:
        path: the file.

    Raises:
        LoadError: for what cannot be read, and for what is not the trace of a run from
            its beginning.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        #: Where each block begins, and the cycle and time of its first event.
        self._offsets: list[int] = []
        self._cycles: list[int] = []
        self._times: list[Time] = []
        #: As far as blocks are known: the next offset and row, the last event.
        self._offset = 0
        self._rows = 0
        self._last: _Head | None = None
        self._complete = False
        self._wrong: LoadError | None = None
        #: The row of the first event of the end of the run, once it is known.
        self._end: int | None = None
        self._kept: deque[_Block] = deque(maxlen=_BLOCKS)
        #: What the run was begun with.
        self.begun = self._spec()
        tail = self._tail()
        #: The number of the last cycle.
        self.last_cycle = tail.cycle
        #: Why the run was over; empty if the trace was cut off before.
        self.reason = tail.reason if tail.event == _ENDED else ""

    def __str__(self) -> str:
        """Return in words how far it goes."""
        cycles = plural(self.last_cycle, "cycle")
        return f"{cycles}, {f'over ({self.reason})' if self.reason else 'cut off'}"

    # --- the first line and the last ------------------------------------------------

    def _spec(self) -> RunSpec:
        line = self._bytes(0, lambda file: file.readline())
        said = f"`{self.path}` is not a trace of a run from its beginning"
        if not line or self._decoded(line, 0, _TAG).event != _STARTED:
            raise LoadError(said)
        version = self._decoded(line, 0, _FORMAT).format
        if version != TRACE_FORMAT:
            found = f"trace format {version}, not {TRACE_FORMAT}"
            raise LoadError(f"`{self.path}` was written by another rapc: {found}")
        return self._decoded(line, 0, _BEGUN).spec

    def _tail(self) -> _Tail:
        """Return the last line that is whole: a trace may be cut off within one."""
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
        """How many events there are."""
        self._grow(lambda last: False)
        return self._rows

    def row_after(self, cycle: int) -> int:
        """Return the row of the first event after the end of a cycle.

        That is the first of the end of the run after the last cycle.
        """
        self._grow(lambda last: last.cycle > cycle)
        before = bisect_right(self._cycles, cycle)
        return self._first_row(before, lambda head: head.cycle > cycle)

    def row_later(self, time: Time) -> int:
        """Return the row of the first event after a time, or the first of the end."""
        self._grow(lambda last: last.time > time)
        before = bisect_right(self._times, time)
        return self._first_row(before, lambda head: head.time > time)

    def _first_row(self, blocks: int, wanted: Callable[[_Head], bool]) -> int:
        """Return the first row that is wanted, if blocks before it begin otherwise."""
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
        """Iterate over the events in some rows; of some kinds, if any are given."""
        for row, line in self._lines(range(first, until), kinds):
            yield as_told(row, self._decoded(line, row, event_lines()))

    def backwards(
        self, until: int, kinds: Collection[type[Any]] = ()
    ) -> Iterator[ToldEvent]:
        """Iterate over the events before a row, the last one first; see `scan`."""
        for row, line in self._lines(range(until - 1, -1, -1), kinds):
            yield as_told(row, self._decoded(line, row, event_lines()))

    def lines(self) -> Iterator[bytes]:
        """Iterate over the lines of the file, damaged or not."""
        offset = 0
        while lines := self._bytes(offset, _next_lines):
            yield from lines
            offset += sum(map(len, lines))

    def written(self, kinds: Collection[type[Any]]) -> Iterator[dict[str, Any]]:
        """Iterate over all events of some kinds as the file has them."""
        for row, line in self._lines(range(self.rows), kinds):
            event = self._decoded(line, row, event_lines())
            yield msgspec.to_builtins(event)

    def _lines(
        self, rows: range, kinds: Collection[type[Any]]
    ) -> Iterator[tuple[int, bytes]]:
        """Iterate over the lines in some rows whose events are of some kinds."""
        tags = {str(kind.__struct_config__.tag) for kind in kinds}
        block = None
        for row in rows:
            if block is None or block.row != row - row % _ROWS:
                block = self._block(row // _ROWS)
            if not tags or block.heads[row % _ROWS].event in tags:
                yield row, block.lines[row % _ROWS]

    # --- reading --------------------------------------------------------------------

    def _grow(self, enough: Callable[[_Head], bool]) -> None:
        """Read on until the last event read is enough, or all are read."""
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
        """Return the row of the first task that leaves with that of a row."""
        while row and self._block((row - 1) // _ROWS).heads[(row - 1) % _ROWS].leaves:
            row -= 1
        return row

    def _block(self, at: int) -> _Block:
        """Return a block that was read before."""
        row = at * _ROWS
        for block in self._kept:
            if block.row == row:
                return block
        block = self._read(self._offsets[at], row, None)
        self._kept.append(block)
        return block

    def _read(self, offset: int, row: int, last: _Head | None) -> _Block:
        """Read the block that begins at an offset, with a row, after an event."""
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
        """Return the head of a line that comes after another."""
        head = self._decoded(line, row, _HEAD)
        wrong = ""
        if head.event not in events.kinds():
            wrong = f"is an event `{head.event}`, which is not known"
        elif head.n != row or (
            last is not None and (head.cycle < last.cycle or head.time < last.time)
        ):
            wrong = "is out of order"
        if wrong:
            raise LoadError(f"`{self.path}` is not a trace: line {row + 1} {wrong}")
        return head

    def _bytes(self, offset: int, read: Callable[[BinaryIO], _T]) -> _T:
        """Read from an offset of the file."""
        try:
            with self.path.open("rb") as file:
                file.seek(offset)
                return read(file)
        except OSError as error:
            said = f"cannot read `{self.path}`: {reason(error)}"
            raise LoadError(said) from error

    def _decoded(self, line: bytes, row: int | None, decoder: Decoder[_T]) -> _T:
        """Return what a line holds; `row` is None for the last."""
        try:
            return decoder.decode(line)
        except UNREADABLE as error:
            where = "the last line" if row is None else f"line {row + 1}"
            said = f"`{self.path}` is not a trace: {where}: {_said(error)}"
            raise LoadError(said) from error


class Playback:
    """A recorded run that is only looked at; it begins before its first cycle.

    Nothing of it is kept but where it stands; what is asked for is read again. What
    reads the recording raises LoadError where that is damaged.

    Args:
        recording: the file.
    """

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self.last_cycle = recording.last_cycle
        self.goto(0)

    def goto(self, cycle: int) -> None:
        """Stand at the end of a cycle, or of the run for one after the last."""
        recording, over = self._recording, cycle > self.last_cycle
        #: The row of the next event.
        self.serial = recording.rows if over else recording.row_after(cycle)
        #: The number of the cycle that was looked at last.
        self.cycle = min(cycle, self.last_cycle)
        self._over = over

    def step(self) -> bool:
        """Go to the end of the next cycle; return False if the run is over instead."""
        self.goto(self.cycle + 1)
        return not self._over

    @property
    def now(self) -> Time:
        """The time of the last event up to here."""
        return self._recording.time_of(self.serial - 1) if self.serial else 0

    @property
    def reason(self) -> str:
        """Why the run was over, at its end; empty before."""
        return (self._recording.reason or "no more is recorded") if self._over else ""

    def cycle_by(self, time: Time) -> int:
        """Return the last cycle that was over by a time."""
        row = self._recording.row_later(time)
        if row == self._recording.rows:
            return self.last_cycle + 1
        cycle = self._recording.cycle_of(row)
        return cycle if row == self._recording.row_after(cycle) else cycle - 1

    def seek(self, kinds: Collection[type[Event]], want: Want) -> ToldEvent | None:
        """Go to the cycle of the next event of some kinds that is wanted."""
        told = self._recording.scan(self.serial, self._recording.rows, kinds)
        found = next(filter(want, told), None)
        if found is not None:
            at_end = found.serial >= self._recording.row_after(found.cycle)
            self.goto(found.cycle + at_end)
        return found

    def has(self, cycle: int) -> bool:
        """Whether all events from a cycle on are at hand: always."""
        return True

    def scan(
        self, cycle: int, kinds: Collection[type[Event]] = (), want: Want | None = None
    ) -> Iterator[ToldEvent]:
        """Iterate over the events up to here from a cycle on; of some, if wanted."""
        first = self._recording.row_after(cycle - 1)
        told = self._recording.scan(first, self.serial, kinds)
        return told if want is None else filter(want, told)

    def backwards(self, *kinds: type[Event]) -> Iterator[ToldEvent]:
        """Iterate over the events up to here, the last one first; of some kinds."""
        return self._recording.backwards(self.serial, kinds)

    def since(self, serial: int) -> list[ToldEvent]:
        """Return the events from a row on, the last of them if there are too many."""
        first = max(serial, self.serial - MOST)
        return list(self._recording.scan(first, self.serial))


def _next_lines(file: BinaryIO) -> list[bytes]:
    """Read the lines of a block."""
    return list(islice(file, _ROWS))


def _said(error: BaseException) -> str:
    """Return what is wrong with a line, in a few words."""
    text = "lists nested too deep" if isinstance(error, RecursionError) else str(error)
    return text if text[1:2].isupper() else text[:1].lower() + text[1:]


def _is_cut(line: bytes) -> bool:
    """Whether the last line of a file was not written to its end."""
    if line.endswith(b"\n"):
        return False
    try:
        _TAG.decode(line)
    except UNREADABLE:
        return True
    return False
