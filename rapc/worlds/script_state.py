"""How far a scripted world has come: all that changes in it, as plain records."""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from rapc.base.values import Fact
from rapc.world import Datum, Finished, Message, Signal, Time
from rapc.worlds.script import At, Row

AT = "at"
"""The datum by which an `At` reaches its handler; no library declares it."""


class Due(msgspec.Struct, frozen=True):
    """Something to come: an entry of `at`, the end of a primitive, or of a skill."""

    time: Time
    entry: At | None = None
    #: The row of a primitive that ends, or of a skill that is on.
    row: Row | None = None
    ticket: int = 0
    #: The skill that has something to tell, and which of its signals it is.
    skill: Fact | None = None
    signal: int = 0


class SkillOn(msgspec.Struct):
    """A skill that is on, and the activations that have it, the oldest first."""

    skill: Fact
    tickets: list[int]


class SentMessage(msgspec.Struct, frozen=True):
    """A message not yet fetched, as it is saved: one of the three."""

    datum: Datum | None = None
    signal: Signal | None = None
    finished: Finished | None = None

    def message(self) -> Message:
        """Return the message itself."""
        found = self.datum or self.signal or self.finished
        if found is None:
            raise ValueError("a message is empty")
        return found


ENTRY = SentMessage(datum=Datum((AT,)))


class ScriptState(msgspec.Struct):
    """All that changes in a scripted world."""

    #: How often each row has been used.
    used: list[int]
    now: Time = 0
    #: What is to come, soonest first.
    coming: list[Due] = []
    #: The messages not yet fetched.
    sent: list[SentMessage] = []
    #: The entries of `at` whose handler has not run.
    entries: list[At] = []
    #: Rows whose end is among `sent`.
    ends: list[Row] = []
    #: Rows whose end was fetched and whose handler has not run.
    told: list[Row] = []
    #: The entries of `at` that fell into the primitive that `answered` answers.
    before: list[At] = []
    #: The row that has just answered, its handler not yet run.
    answered: Row | None = None
    #: The skills that are on, in the order in which they came on.
    on: list[SkillOn] = []

    def under_way(self) -> tuple[int, ...]:
        """Return the tickets of all requests and activations under way."""
        requests = [due.ticket for due in self.coming if due.row and not due.skill]
        return (*requests, *sorted({t for on in self.on for t in on.tickets}))

    def found(self, skill: Fact) -> SkillOn | None:
        """Return the skill if it is on, else None."""
        return next((on for on in self.on if on.skill == skill), None)

    def expect(self, due: Due) -> None:
        """Put something among what is to come."""
        self.coming.append(due)
        self.coming.sort(key=time_of)

    def change_memory(self, row: Row) -> None:
        """Have the handler of entries do what a row does to memory."""
        changes = (row.asserts, row.erases, row.moves, row.loses)
        if any(changes):
            self.entries.append(At(self.now, *changes))
            self.sent.append(ENTRY)

    def send(self, signals: Iterable[Fact], tickets: tuple[int, ...] = ()) -> None:
        """Send signals that arose under activations or a request, `tickets`."""
        self.sent += (
            SentMessage(signal=Signal(content, tickets)) for content in signals
        )


def time_of(due: Due) -> Time:
    """Return when something is due."""
    return due.time
