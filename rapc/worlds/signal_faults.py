"""What happens to signals on the way from a world: lost, late, doubled, spurious.

A late signal comes some time after it was sent, if an activation under which it arose
is still on by then; a spurious one that time after an activation came on for which
it might be told, though nothing has told it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import msgspec

from rapc.base.values import Fact, number
from rapc.world import Message, Signal, Time

LOST = "lost"
LATE = "late"
DOUBLED = "doubled"
SPURIOUS = "spurious"

HOW = (LOST, LATE, DOUBLED, SPURIOUS)
"""What can happen to a signal."""


class Held(msgspec.Struct, frozen=True):
    """A signal that is still to come, and when."""

    time: Time
    content: Fact
    #: The activations that it belongs to, if it belongs to any.
    tickets: tuple[int, ...] = ()


class Struck(msgspec.Struct, frozen=True):
    """What a fault does to one signal, and how long that takes."""

    how: str
    by: Time = 0


class SignalFaults:
    """The signals of one world that do not come as they were sent.

    Args:
        strike: says what becomes of a signal that is sent now, or None.
    """

    def __init__(self, strike: Callable[[Fact, Time], Struck | None]) -> None:
        #: What is still to come, soonest first.
        self.held: list[Held] = []
        self._strike = strike

    def pass_on(self, messages: Iterable[Message], now: Time) -> Sequence[Message]:
        """Return what comes of `messages`, then what has been held back until now."""
        found: list[Message] = []
        for message in messages:
            if not isinstance(message, Signal):
                found.append(message)
                continue
            struck = self._strike(message.content, now)
            how = None if struck is None else struck.how
            if struck is not None and how == LATE:
                self.hold(number(now + struck.by), message.content, message.tickets)
            elif how != LOST:
                found += [message] * (2 if how == DOUBLED else 1)
        due = [held for held in self.held if held.time <= now]
        self.held = self.held[len(due) :]
        return [*found, *(Signal(held.content, held.tickets) for held in due)]

    def hold(self, time: Time, content: Fact, tickets: tuple[int, ...]) -> None:
        """Let a signal come at a time."""
        self.held.append(Held(time, content, tickets))
        self.held.sort(key=lambda held: held.time)

    def deactivate(self, ticket: int) -> None:
        """Forget what would come for an activation that is on no more."""
        kept = []
        for held in self.held:
            left = tuple([one for one in held.tickets if one != ticket])
            if left or not held.tickets:
                kept.append(msgspec.structs.replace(held, tickets=left))
        self.held = kept

    def next_time(self) -> Time | None:
        """Return when the next signal that is held back comes."""
        return self.held[0].time if self.held else None
