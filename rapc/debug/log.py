"""Log of the latest events of a run.

Events are kept in raw form, because constructing event objects is slow. At most `MOST`
events of a branch are kept, to limit memory; a history replays older events.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator
from itertools import chain, islice, takewhile
from typing import Any, NamedTuple

from rapc.events import Event
from rapc.runtime.events.trace import text_lines
from rapc.world import Time

MOST = 60_000
"""The default number of events that are kept for a branch."""


class ToldEvent(NamedTuple):
    """An event in raw form, before the event object is constructed."""

    kind: type[Event]
    serial: int
    cycle: int
    time: Time
    keys: dict[str, Any]

    @classmethod
    def of(cls, event: Event) -> ToldEvent:
        """Return an event object in raw form."""
        keys = {name: getattr(event, name) for name in event.__struct_fields__}
        serial, cycle, time = keys.pop("n"), keys.pop("cycle"), keys.pop("time")
        return cls(type(event), serial, cycle, time, keys)

    def event(self) -> Event:
        """Return the event object."""
        return self.kind(n=self.serial, cycle=self.cycle, time=self.time, **self.keys)


Hear = Callable[[ToldEvent], None]
Want = Callable[[ToldEvent], bool]


class Events:
    """The latest events of a branch, up to the furthest moment of the branch.

    Args:
        most: the number of events to keep, besides those before the first cycle.
    """

    def __init__(self, most: int = MOST) -> None:
        #: The events before the first cycle, kept because no replay can repeat them.
        self.opening: list[ToldEvent] = []
        #: The latest events; their serial numbers have no gaps.
        self.latest: deque[ToldEvent] = deque(maxlen=most)

    def keep(self, most: int) -> None:
        """Keep another number of events from now on."""
        self.latest = deque(self.latest, maxlen=most)

    @property
    def end(self) -> int:
        """The serial number after the last event; 0 without events."""
        last = self.latest or self.opening
        return last[-1].serial + 1 if last else 0

    def add(self, told: ToldEvent) -> None:
        """Add the next event."""
        (self.latest if told.cycle else self.opening).append(told)

    def up_to(self, serial: int) -> Events:
        """Return a copy with the events before a serial number."""
        found = Events(self.latest.maxlen or MOST)
        found.opening += [one for one in self.opening if one.serial < serial]
        found.latest.extend(self._latest(serial))
        return found

    def has(self, cycle: int) -> bool:
        """Return whether all events from a cycle on are kept."""
        opened = self.opening[-1].serial + 1 if self.opening else 0
        kept = self.latest
        return not kept or kept[0].serial == opened or kept[0].cycle < cycle

    def before(self, serial: int) -> Iterator[ToldEvent]:
        """Yield the kept events before a serial number, in order."""
        opening = (one for one in self.opening if one.serial < serial)
        return chain(opening, self._latest(serial))

    def backwards(self, serial: int) -> Iterator[ToldEvent]:
        """Yield the kept events before a serial number, latest first."""
        beyond = max(self.end - serial, 0)
        latest = islice(reversed(self.latest), beyond, None)
        opening = (one for one in reversed(self.opening) if one.serial < serial)
        return chain(latest, opening)

    def _latest(self, serial: int) -> Iterator[ToldEvent]:
        count = serial - self.latest[0].serial if self.latest else 0
        return islice(self.latest, max(count, 0))


class EventLog:
    """The log of a run: the events of the present branch up to the present moment.

    The log is a listener for `Interpreter.listen`. A replay repeats events that the
    branch has already; these are not kept again.
    """

    def __init__(self) -> None:
        #: The events of the present branch, also those after the present moment.
        self.events = Events()
        #: The serial number of the next event.
        self.serial = 0
        #: An optional callback for each new event, to compare a run with a recording.
        self.follower: Hear | None = None
        #: The receiver of events during a replay for a question; the log keeps none.
        self.elsewhere: Hear | None = None

    def __call__(self, event: Event) -> None:
        """Keep an event object; see `raw` for events in raw form."""
        self.raw(*ToldEvent.of(event))

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
        self.serial = serial + 1
        if serial < self.events.end:
            return
        self.events.add(told)
        if self.follower is not None:
            self.follower(told)

    def has(self, cycle: int) -> bool:
        """Return whether the log keeps all events from a cycle on."""
        return self.events.has(cycle)

    def scan(
        self, cycle: int, kinds: Collection[type[Event]] = (), want: Want | None = None
    ) -> list[ToldEvent]:
        """Return the kept events from a cycle on, filtered by kind and predicate."""
        return [
            told
            for told in self.events.before(self.serial)
            if told.cycle >= cycle
            and (not kinds or told.kind in kinds)
            and (want is None or want(told))
        ]

    def backwards(self, *kinds: type[Event]) -> Iterator[ToldEvent]:
        """Yield the kept events of the given kinds (default: all), latest first."""
        for told in self.events.backwards(self.serial):
            if not kinds or told.kind in kinds:
                yield told

    def since(self, serial: int) -> list[ToldEvent]:
        """Return the kept events from a serial number on, in order."""
        found = list(takewhile(lambda told: told.serial >= serial, self.backwards()))
        return found[::-1]


def in_lines(told: Iterable[ToldEvent]) -> list[str]:
    """Return events as lines of a text trace."""
    return text_lines(one.event() for one in told)
