"""Log of the latest events of a run.

The log keeps events in raw form, because constructing event objects is slow. The log
keeps at most `most` events, to limit memory; a history replays older events.
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
"""The default number of events that a log keeps."""


class ToldEvent(NamedTuple):
    """An event in raw form, before the event object is constructed."""

    kind: type[Event]
    serial: int
    cycle: int
    time: Time
    keys: dict[str, Any]

    def event(self) -> Event:
        """Return the event object."""
        return self.kind(n=self.serial, cycle=self.cycle, time=self.time, **self.keys)


Hear = Callable[[ToldEvent], None]
Want = Callable[[ToldEvent], bool]


class EventLog:
    """The latest events of a run; a listener for `Interpreter.listen`.

    Args:
        most: the number of events to keep.
    """

    def __init__(self, most: int = MOST) -> None:
        self._kept: deque[ToldEvent] = deque(maxlen=most)
        #: The events before the first cycle, kept because no replay can repeat them.
        self.opening: list[ToldEvent] = []
        #: An optional callback for each event, to compare a run with a recording.
        self.follower: Hear | None = None
        #: The receiver of events during a replay for a question; the log keeps none.
        self.elsewhere: Hear | None = None

    def __call__(self, event: Event) -> None:
        """Keep an event object; see `raw` for events in raw form."""
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
        """Keep an event in raw form; see `Recorder.listen`."""
        told = ToldEvent(kind, serial, cycle, time, keys)
        if self.elsewhere is not None:
            self.elsewhere(told)
            return
        (self._kept if cycle else self.opening).append(told)
        if self.follower is not None:
            self.follower(told)

    def has(self, cycle: int) -> bool:
        """Return whether the log keeps all events from a cycle on."""
        opened = self.opening[-1].serial + 1 if self.opening else 0
        kept = self._kept
        return not kept or kept[0].serial == opened or kept[0].cycle < cycle

    def forget_from(self, serial: int) -> None:
        """Remove the events from a serial number on, after the run went back."""
        for kept in (self._kept, self.opening):
            while kept and kept[-1].serial >= serial:
                kept.pop()

    def scan(
        self, cycle: int, kinds: Collection[type[Event]] = (), want: Want | None = None
    ) -> list[ToldEvent]:
        """Return the kept events from a cycle on, filtered by kind and predicate."""
        return [
            told
            for told in chain(self.opening, self._kept)
            if told.cycle >= cycle
            and (not kinds or told.kind in kinds)
            and (want is None or want(told))
        ]

    def backwards(self, *kinds: type[Event]) -> Iterator[ToldEvent]:
        """Yield the kept events of the given kinds (default: all), latest first."""
        for told in chain(reversed(self._kept), reversed(self.opening)):
            if not kinds or told.kind in kinds:
                yield told

    def since(self, serial: int) -> list[ToldEvent]:
        """Return the kept events from a serial number on, in order."""
        found = list(takewhile(lambda told: told.serial >= serial, self.backwards()))
        return found[::-1]


def in_lines(told: Iterable[ToldEvent]) -> list[str]:
    """Return events as lines of a text trace."""
    return text_lines(one.event() for one in told)
