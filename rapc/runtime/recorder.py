"""The one place where events of a run are made and handed to who listens."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rapc.runtime.events import Event
from rapc.runtime.world import Time

Listener = Callable[[Event], None]


class Recorder:
    """Numbers events and hands them on; makes nothing while nobody listens.

    Callers test `on` first, so that a silent run allocates nothing for tracing.
    """

    def __init__(self) -> None:
        self.on = False
        self.time: Time = 0
        self.cycle = 0
        self._serial = 0
        self._listeners: tuple[Listener, ...] = ()

    def listen(self, listener: Listener) -> None:
        """Call `listener` with every event from now on, in order."""
        self._listeners = (*self._listeners, listener)
        self.on = True

    def emit(self, kind: type[Event], /, **keys: Any) -> None:
        """Make an event of a kind and hand it to all listeners."""
        event = kind(n=self._serial, cycle=self.cycle, time=self.time, **keys)
        self._serial += 1
        for listener in self._listeners:
            listener(event)
