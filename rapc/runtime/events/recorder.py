"""The recorder: makes the events of a run and passes them to its listeners."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from rapc.events import Event, MethodEnded, TaskFailed
from rapc.world import Time

Listener = Callable[[Event], None]

_WITH_CAUSES: frozenset[type[Event]] = frozenset((MethodEnded, TaskFailed))
"""The kinds of events with causes."""


class Recorder:
    """Numbers events and passes them on; makes none without listeners.

    Callers test `on` first: a run without listeners allocates nothing for tracing. A
    `buffer`, if any, keeps the keys of events; the events are made later.
    """

    def __init__(self) -> None:
        self.on = False
        self.time: Time = 0
        self.cycle = 0
        self.serial = 0
        #: For each event its kind, cycle, time and other keys, one after the other:
        #: Python's garbage collector traverses kept objects again and again, and this
        #: form halves their number.
        self.buffer: list[Any] | None = None
        #: Positions in the buffer where the count of serials starts again, each with
        #: the first serial.
        self.jumps: list[tuple[int, int]] = []
        #: Whether a listener receives causes of failures; otherwise they are not
        #: computed.
        self.tells_causes = False
        self._listeners: tuple[Listener, ...] = ()
        self._raw: tuple[Callable[..., None], ...] = ()
        self._of_kind: dict[type[Event], tuple[Listener, ...]] = {}
        #: Whether there are listeners besides those to raw events.
        self._makes_events = False
        #: Whether a listener receives events of all kinds.
        self._tells_all = False

    def listen(self, listener: Listener, *kinds: type[Event]) -> None:
        """Call `listener` with every event from now on, or those of `kinds`, in order.

        An event of a kind without a listener is not made. A listener to all kinds with
        a method `raw` receives events as they are emitted: the kind, its serial number,
        cycle, time, and its other keys, which the listener must not change.
        """
        self.tells_causes |= not kinds or not _WITH_CAUSES.isdisjoint(kinds)
        self._tells_all |= not kinds
        raw = None if kinds else getattr(listener, "raw", None)
        if raw is not None:
            self._raw = (*self._raw, raw)
            self.on = True
            return
        self._makes_events = True
        everywhere = self._listeners
        if not kinds:
            self._listeners = (*everywhere, listener)
        for kind in kinds or self._of_kind:
            before = self._of_kind.get(kind, everywhere)
            self._of_kind[kind] = (*before, listener)
        self.on = True

    def take_over(self, other: Recorder) -> None:
        """Take over the listeners of another recorder, which gets no more events."""
        self.on, self.tells_causes = other.on, other.tells_causes
        self.buffer, self.jumps = other.buffer, other.jumps
        self._listeners, self._raw = other._listeners, other._raw
        self._of_kind, self._makes_events = dict(other._of_kind), other._makes_events
        self._tells_all = other._tells_all

    def start_buffer(self) -> list[Any]:
        """Return the buffer to which all events from now on are added."""
        if self.buffer is None:
            self.buffer = []
        self.on = self.tells_causes = self._tells_all = True
        return self.buffer

    def jump(self, time: Time, cycle: int, serial: int) -> None:
        """Continue from another position of the run, after a restore."""
        self.time, self.cycle, self.serial = time, cycle, serial
        if self.buffer is not None:
            self.jumps.append((len(self.buffer), serial))

    def wants(self, event_class: type[Event]) -> bool:
        """Return whether a kind of event has listeners; if not, count one event.

        Call this method before expensive computations of keys.
        """
        if self._tells_all or event_class in self._of_kind:
            return True
        self.serial += 1
        return False

    def emit(self, event_class: type[Event], /, **keys: Any) -> None:
        """Emit an event of a kind to all of its listeners."""
        buffer = self.buffer
        if buffer is not None:
            buffer.extend((event_class, self.cycle, self.time, keys))
        elif not self._tells_all and event_class not in self._of_kind:
            self.serial += 1
            return
        if self._raw:
            for raw in self._raw:
                raw(event_class, self.serial, self.cycle, self.time, keys)
        if self._makes_events:
            listeners = self._of_kind.get(event_class, self._listeners)
            if listeners:
                event = event_class(
                    n=self.serial, cycle=self.cycle, time=self.time, **keys
                )
                for listener in listeners:
                    listener(event)
        self.serial += 1


_PARTS = 4
"""The number of buffer entries for an event."""


class Recording:
    """The events of a run from a moment on, readable while the run goes on."""

    def __init__(self, recorder: Recorder) -> None:
        self._buffer = recorder.start_buffer()
        self._start = len(self._buffer)
        self._first = recorder.serial
        self._jumps = recorder.jumps

    def __len__(self) -> int:
        return (len(self._buffer) - self._start) // _PARTS

    def __iter__(self) -> Iterator[Event]:
        """Yield the events in order, as a listener would have received them."""
        jumps = dict(self._jumps)
        serial = self._first
        for at in range(self._start, len(self._buffer), _PARTS):
            serial = jumps.get(at, serial)
            kind, cycle, time, keys = self._buffer[at : at + _PARTS]
            yield kind(n=serial, cycle=cycle, time=time, **keys)
            serial += 1
