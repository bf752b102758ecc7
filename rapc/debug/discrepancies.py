"""Discrepancies of belief and truth: when a belief became wrong, and for how long.

The beliefs are compared with the truth (`rapc.runtime.truth`) whenever a task is
selected, after the messages of that time, and at the end of the run. A wrong belief
that the world corrects before a task is selected gives no discrepancy.
"""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from rapc.events import Event
from rapc.runtime.truth import WrongBelief
from rapc.world import Time


class Discrepancy(msgspec.Struct):
    """A time for which a belief was wrong."""

    #: The belief when it was first found wrong.
    belief: WrongBelief
    #: The cycle and the time at which the belief was first found wrong.
    cycle: int
    time: Time
    #: The serial number of the event at which the belief was first found wrong.
    first_serial: int
    #: The time at which the belief was true or erased; None while it is wrong.
    ended: Time | None = None
    #: The serial number of the event at that time.
    end_serial: int | None = None


class Discrepancies:
    """The discrepancies of a branch, in order of their start."""

    def __init__(self, found: Iterable[Discrepancy] = (), compared: int = 0) -> None:
        self.all: list[Discrepancy] = list(found)
        #: The serial number after the last event of a comparison.
        self.compared = compared
        self._open = {one.belief.fact: one for one in self.all if one.ended is None}

    def compare(self, event: Event, wrong: Iterable[WrongBelief]) -> list[Discrepancy]:
        """Add the wrong beliefs at an event; return the discrepancies that begin."""
        before, self._open, new = self._open, {}, []
        for belief in wrong:
            one = before.pop(belief.fact, None)
            if one is None:
                one = Discrepancy(belief, event.cycle, event.time, event.n)
                new.append(one)
            self._open[belief.fact] = one
        for one in before.values():
            one.ended, one.end_serial = event.time, event.n
        self.all += new
        self.compared = event.n + 1
        return new

    def up_to(self, serial: int) -> Discrepancies:
        """Return a copy with the comparisons before a serial number."""
        found = []
        for one in self.all:
            if one.first_serial < serial:
                copy = msgspec.structs.replace(one)
                if copy.end_serial is not None and copy.end_serial >= serial:
                    copy.ended = copy.end_serial = None
                found.append(copy)
        return Discrepancies(found, min(self.compared, serial))
