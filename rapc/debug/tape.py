"""Recorded runs without what they ran: only to look at, forth and back.

Nothing of a recording is kept but where it stands; what is asked for is read again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import islice
from typing import Any

from rapc.debug.log import MOST, EventLog, ToldEvent
from rapc.debug.recording import Recording
from rapc.debug.stepped import Stepped, Stop
from rapc.events import Event
from rapc.world import Time


class Tape(Stepped):
    """A recorded run that is only looked at; it stands before its first cycle.

    What reads the recording raises LoadError where that is damaged.

    Args:
        recording: the file.
    """

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._log = _TapeLog(recording)
        super().__init__(self._log)
        self._number = 0
        self._over = False
        self._put(0)

    @property
    def cycle(self) -> int:
        """The number of the cycle that was looked at last."""
        return self._number

    @property
    def now(self) -> Time:
        """The time of the last event up to here."""
        return self._recording.time_of(self._log.at - 1) if self._log.at else 0

    @property
    def reason(self) -> str:
        """The reason why the run was over, at its end; empty before."""
        return (self._recording.reason or "no more is recorded") if self._over else ""

    @property
    def serial(self) -> int:
        """The row of the next event."""
        return self._log.at

    @property
    def seen(self) -> int:
        """The last cycle that was recorded."""
        return self._recording.last_cycle

    @property
    def seen_over(self) -> bool:
        """Whether the recording ends there: always."""
        return True

    def scan(
        self,
        *kinds: type[Any],
        first: int = 0,
        want: Callable[[ToldEvent], bool] | None = None,
    ) -> Iterator[ToldEvent]:
        """Iterate over events up to here: see `Stepped.scan`."""
        row = self._recording.row_after(first - 1)
        told = self._recording.scan(row, self._log.at, kinds)
        return told if want is None else filter(want, told)

    def last(
        self, *kinds: type[Any], want: Callable[[ToldEvent], bool]
    ) -> ToldEvent | None:
        """Return the last event up to here of some kinds that is wanted, or None."""
        told = self._recording.backwards(self._log.at, kinds)
        return next(filter(want, told), None)

    def seek(
        self, *kinds: type[Any], want: Callable[[ToldEvent], bool]
    ) -> ToldEvent | None:
        """Go to the cycle of the next event of some kinds: see `Stepped.seek`."""
        told = self._recording.scan(self._log.at, self._recording.rows, kinds)
        found = next(filter(want, told), None)
        if found is not None:
            before_end = found.serial < self._recording.row_after(found.cycle)
            self.goto(found.cycle + (not before_end))
        return found

    def goto(self, cycle: int, *, heed: bool = False) -> Stop:
        """Go to the end of a cycle: see `Stepped.goto`; nothing stops it."""
        if cycle > self.seen:
            self._put(self.seen, over=True)
            return Stop("over", self.reason)
        self._put(max(cycle, 0))
        return Stop("asked")

    def goto_time(self, time: Time, *, heed: bool = False) -> Stop:
        """Go to the last moment at or before a time: see `Stepped.goto_time`."""
        row = self._recording.row_later(time)
        if row == self._recording.rows:
            return self.goto(self.seen + 1)
        cycle = self._recording.cycle_of(row)
        return self.goto(
            cycle if row == self._recording.row_after(cycle) else cycle - 1
        )

    def _cycle(self) -> bool:
        if self._number < self.seen:
            self._put(self._number + 1)
            return True
        self._put(self.seen, over=True)
        return False

    def _go_back(self, cycle: int) -> None:
        self._put(cycle)

    def _put(self, cycle: int, *, over: bool = False) -> None:
        """Stand at the end of a cycle, or of the run."""
        recording = self._recording
        at = recording.rows if over else recording.row_after(cycle)
        self._number, self._over, self._log.at = cycle, over, at


class _TapeLog(EventLog):
    """The events of a recorded run up to a row."""

    def __init__(self, recording: Recording) -> None:
        super().__init__(most=0)
        self._recording = recording
        #: The row before which it stands.
        self.at = 0

    def backwards(self) -> Iterator[ToldEvent]:
        """Iterate over the events up to here, the last one first."""
        return self._recording.backwards(self.at)

    def since(self, serial: int) -> list[ToldEvent]:
        """Return the events from a row on, the last of them if there are too many."""
        return list(self._recording.scan(max(serial, self.at - MOST), self.at))

    def last(self, *kinds: type[Event]) -> ToldEvent | None:
        """Return the last event of some kinds."""
        return next(islice(self._recording.backwards(self.at, kinds), 1), None)
