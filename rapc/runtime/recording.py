"""A run's events, kept as they were told and made into events when they are read.

To keep one costs a fraction of making and writing it, so a run may be recorded in full
that is hardly ever looked at. What writes events out as they come is in
`rapc.runtime.trace`.
"""

from __future__ import annotations

from collections.abc import Iterator

from rapc.runtime.events import Event
from rapc.runtime.recorder import Recorder, made


class Recording:
    """The events of a run from a moment on; it may be read while the run goes on."""

    def __init__(self, recorder: Recorder) -> None:
        self._tape = recorder.keep()
        self._start = len(self._tape)
        self._first = recorder.serial

    def __len__(self) -> int:
        return len(self._tape) - self._start

    def __iter__(self) -> Iterator[Event]:
        """The events, in order: what a listener would have been called with."""
        for at in range(len(self)):
            yield made(self._tape[self._start + at], self._first + at)
