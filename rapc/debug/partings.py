"""Partings of belief and truth: when a believed fact became wrong, and for how long.

Beliefs are compared with the truth whenever a task is selected, after the messages of
that time, and at the end of the run. So a belief that the world corrects at once is
never wrong.
"""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from rapc.base.values import Fact
from rapc.events import Event
from rapc.runtime.truth import WrongBelief
from rapc.world import Time


class Parting(msgspec.Struct):
    """A time for which a belief was wrong."""

    fact: Fact
    #: The time of the belief's last assertion; None if nobody asserted it.
    believed: Time | None
    #: The true facts with the same index; see `WrongBelief`.
    truth: tuple[Fact, ...]
    #: The cycle and the time at which the belief was first found wrong.
    cycle: int
    time: Time
    #: The time at which the belief was right or gone; None while it is wrong.
    ended: Time | None = None
    #: The serial numbers of the events at the start and the end.
    start: int = 0
    end: int | None = None


class Partings:
    """The partings of a branch, in order of their start."""

    def __init__(self, found: Iterable[Parting] = (), seen: int = 0) -> None:
        self.all: list[Parting] = list(found)
        #: The serial number after the last comparison.
        self.seen = seen
        self._open = {one.fact: one for one in self.all if one.end is None}

    def compare(self, event: Event, wrong: Iterable[WrongBelief]) -> list[Parting]:
        """Add the wrong beliefs at an event; return the partings that begin."""
        before, self._open, new = self._open, {}, []
        for belief in wrong:
            one = before.pop(belief.fact, None)
            if one is None:
                place = event.cycle, event.time
                one = Parting(
                    belief.fact, belief.since, belief.truth, *place, start=event.n
                )
                new.append(one)
            self._open[belief.fact] = one
        for one in before.values():
            one.ended, one.end = event.time, event.n
        self.all += new
        self.seen = event.n + 1
        return new

    def up_to(self, serial: int) -> Partings:
        """Return a copy with the comparisons before a serial number."""
        found = []
        for one in self.all:
            if one.start < serial:
                later = one.end is not None and one.end >= serial
                ended = (None, None) if later else (one.ended, one.end)
                found.append(msgspec.structs.replace(one, ended=ended[0], end=ended[1]))
        return Partings(found, min(self.seen, serial))
