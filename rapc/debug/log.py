"""The events of a session: the last ones are kept, older ones are made again by replay.

A log is what a session reads to say what has just happened. It keeps events as they are
emitted, unmade, which costs little; and no more of them than `most`, so that a session
may last as long as it likes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator
from itertools import chain, takewhile
from typing import Any, NamedTuple

from rapc.events import Event
from rapc.runtime.events.trace import text_lines
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


Hear = Callable[[ToldEvent], None]
Want = Callable[[ToldEvent], bool]


class EventLog:
    """The last events of a run: a listener for `Interpreter.listen`.

    Args:
        most: how many events are kept.
    """

    def __init__(self, most: int = MOST) -> None:
        self._kept: deque[ToldEvent] = deque(maxlen=most)
        #: What was told before the first cycle: it cannot be replayed, so it stays.
        self.opening: list[ToldEvent] = []
        #: Called with each event too, if set: what compares a run with a recording.
        self.follower: Hear | None = None
        #: Gets the events while a run is replayed for a question; then nothing is kept.
        self.elsewhere: Hear | None = None

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

    def has(self, cycle: int) -> bool:
        """Whether all events from a cycle on are kept."""
        opened = self.opening[-1].serial + 1 if self.opening else 0
        kept = self._kept
        return not kept or kept[0].serial == opened or kept[0].cycle < cycle

    def forget_from(self, serial: int) -> None:
        """Forget the events from a serial number on: the run went back."""
        for kept in (self._kept, self.opening):
            while kept and kept[-1].serial >= serial:
                kept.pop()

    def scan(
        self, cycle: int, kinds: Collection[type[Event]] = (), want: Want | None = None
    ) -> list[ToldEvent]:
        """Return the events that are kept from a cycle on; of some kinds, if wanted."""
        return [
            told
            for told in chain(self.opening, self._kept)
            if told.cycle >= cycle
            and (not kinds or told.kind in kinds)
            and (want is None or want(told))
        ]

    def backwards(self, *kinds: type[Event]) -> Iterator[ToldEvent]:
        """Iterate over the events that are kept, the last one first; of some kinds."""
        for told in chain(reversed(self._kept), reversed(self.opening)):
            if not kinds or told.kind in kinds:
                yield told

    def since(self, serial: int) -> list[ToldEvent]:
        """Return the events that are kept from a serial number on, in order."""
        found = list(takewhile(lambda told: told.serial >= serial, self.backwards()))
        return found[::-1]


def in_lines(told: Iterable[ToldEvent]) -> list[str]:
    """Return events as lines of a text trace."""
    return text_lines(one.event() for one in told)
