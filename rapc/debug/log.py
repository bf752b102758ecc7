"""The events of a session: the last ones are kept, older ones are made again by replay.

A log is what a session reads to say what has just happened. It keeps events as they are
emitted, unmade, which costs little; and no more of them than `most`, so that a session
may last as long as it likes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from itertools import chain
from typing import Any, NamedTuple

from rapc.events import Event
from rapc.world import Time

MOST = 60_000
"""How many events a log keeps."""


class ToldEvent(NamedTuple):
    """An event as it was emitted, before it is made."""

    kind: type[Event]
    serial: int
    cycle: int
    time: Time
    keys: dict[str, Any]

    def event(self) -> Event:
        """Return the event itself."""
        return self.kind(n=self.serial, cycle=self.cycle, time=self.time, **self.keys)


class Wanted(NamedTuple):
    """Which events are wanted: see `Stepped.scan`."""

    kinds: tuple[type[Event], ...]
    first: int
    want: Callable[[ToldEvent], bool] | None

    def fits(self, told: ToldEvent) -> bool:
        """Whether an event is one of them."""
        return (
            told.cycle >= self.first
            and (not self.kinds or told.kind in self.kinds)
            and (self.want is None or self.want(told))
        )


Watcher = Callable[[ToldEvent], None]


class EventLog:
    """The last events of a run: a listener for `Interpreter.listen`.

    Args:
        most: how many events are kept.
    """

    def __init__(self, most: int = MOST) -> None:
        self._kept: deque[ToldEvent] = deque(maxlen=most)
        #: What was told before the first cycle: it cannot be replayed, so it stays.
        self.opening: list[ToldEvent] = []
        #: Called with each event besides, if set: what stops a run.
        self.watcher: Watcher | None = None
        #: Called with each event too, if set: what compares a run with a recording.
        self.follower: Watcher | None = None
        #: Gets the events while a run is replayed for a question; then nothing is kept.
        self.elsewhere: Watcher | None = None

    def __call__(self, event: Event) -> None:
        """Keep an event that was made already; `raw` takes those that were not."""
        keys = {name: getattr(event, name) for name in event.__struct_fields__}
        serial, cycle, time = keys.pop("n"), keys.pop("cycle"), keys.pop("time")
        self.raw(type(event), serial, cycle, time, keys)

    def raw(
        self,
        kind: type[Event],
        serial: int,
        cycle: int,
        time: Time,
        keys: dict[str, Any],
    ) -> None:
        """Keep an event that has not been made: see `Recorder.listen`."""
        told = ToldEvent(kind, serial, cycle, time, keys)
        if self.elsewhere is not None:
            self.elsewhere(told)
            return
        (self._kept if cycle else self.opening).append(told)
        if self.follower is not None:
            self.follower(told)
        if self.watcher is not None:
            self.watcher(told)

    @property
    def first(self) -> int:
        """The serial number of the first event from which on all are kept."""
        opened = self.opening[-1].serial + 1 if self.opening else 0
        if not self._kept or self._kept[0].serial == opened:
            return 0
        return self._kept[0].serial

    def forget_from(self, serial: int) -> None:
        """Forget the events from a serial number on: the run went back."""
        for kept in (self._kept, self.opening):
            while kept and kept[-1].serial >= serial:
                kept.pop()

    def backwards(self) -> Iterator[ToldEvent]:
        """Iterate over the events that are kept, the last one first."""
        return chain(reversed(self._kept), reversed(self.opening))

    def first_from(self, cycle: int) -> int:
        """Return the first serial number that must be kept to know all from a cycle."""
        if cycle > 1:
            for told in self.backwards():
                if told.cycle < cycle:
                    return told.serial
        return 0

    def since(self, serial: int) -> list[ToldEvent]:
        """Return the events that are kept from a serial number on, in order."""
        found = []
        for told in self.backwards():
            if told.serial < serial:
                break
            found.append(told)
        return found[::-1]

    def last(self, *kinds: type[Event]) -> ToldEvent | None:
        """Return the last event of some kinds among those that are kept."""
        return next((told for told in self.backwards() if told.kind in kinds), None)
