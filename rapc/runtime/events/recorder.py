"""The one place where events of a run are made and handed to who listens."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from rapc.base.values import format_list
from rapc.runtime.events.events import Event
from rapc.world import Time

Listener = Callable[[Event], None]

Told = tuple[type[Event], int, Time, dict[str, Any]]
"""An event before it is made: its kind, cycle, time and other keys."""

_FACTS = ("fact", "request", "sent")


class Recorder:
    """Numbers events and hands them on; makes nothing while nobody listens.

    Callers test `on` first, so that a silent run allocates nothing for tracing. On
    the `tape`, if there is one, an event is kept as it is told, to be made later.
    """

    def __init__(self) -> None:
        self.on = False
        self.time: Time = 0
        self.cycle = 0
        self.serial = 0
        self.tape: list[Told] | None = None
        #: Places on the tape from which serials are counted anew, each with the first.
        self.jumps: list[tuple[int, int]] = []
        self._listeners: tuple[Listener, ...] = ()
        self._of_kind: dict[type[Event], tuple[Listener, ...]] = {}

    def listen(self, listener: Listener, *kinds: type[Event]) -> None:
        """Call `listener` with every event from now on, or those of `kinds`, in order.

        An event of a kind that nobody asked for is not made.
        """
        everywhere = self._listeners
        if not kinds:
            self._listeners = (*everywhere, listener)
        for kind in kinds or self._of_kind:
            before = self._of_kind.get(kind, everywhere)
            self._of_kind[kind] = (*before, listener)
        self.on = True

    def keep(self) -> list[Told]:
        """The tape to which all is added that is told from now on."""
        if self.tape is None:
            self.tape = []
        self.on = True
        return self.tape

    def jump(self, time: Time, cycle: int, serial: int) -> None:
        """Go on from another place of the run: a saved state has been taken up."""
        self.time, self.cycle, self.serial = time, cycle, serial
        if self.tape is not None:
            self.jumps.append((len(self.tape), serial))

    def emit(self, event_class: type[Event], /, **keys: Any) -> None:
        """Tell of an event of a kind to all that want to know.

        Facts and requests may be given as they are; an event has them in words.
        """
        tape = self.tape
        if tape is not None:
            tape.append((event_class, self.cycle, self.time, keys))
        listeners = self._of_kind.get(event_class, self._listeners)
        if listeners:
            event = made((event_class, self.cycle, self.time, keys), self.serial)
            for listener in listeners:
                listener(event)
        self.serial += 1


def made(told: Told, serial: int) -> Event:
    """An event with its serial number, from what was told of it."""
    what, cycle, time, keys = told
    for name in _FACTS:
        fact = keys.get(name)
        if type(fact) is tuple:
            keys = {**keys, name: format_list(fact)}
    return what(n=serial, cycle=cycle, time=time, **keys)


class Recording:
    """The events of a run from a moment on; it may be read while the run goes on."""

    def __init__(self, recorder: Recorder) -> None:
        self._tape = recorder.keep()
        self._start = len(self._tape)
        self._first = recorder.serial
        self._jumps = recorder.jumps

    def __len__(self) -> int:
        return len(self._tape) - self._start

    def __iter__(self) -> Iterator[Event]:
        """The events, in order: what a listener would have been called with."""
        jumps = dict(self._jumps)
        serial = self._first
        for at in range(self._start, len(self._tape)):
            serial = jumps.get(at, serial)
            yield made(self._tape[at], serial)
            serial += 1
