"""Messages from a world to the interpreter: results, data, signals, times [T 3.3].

Authors of worlds import the names from `rapc.world`.
"""

from __future__ import annotations

import math
from typing import Final

import msgspec

from rapc.base.values import Fact, Number

Time = Number
"""Simulated time units since the start of the run; never negative."""

OKAY: Final = "okay"
"""The result symbol of a primitive that succeeded."""

NOT_KNOWN: Final[Time] = math.inf
"""The result of `World.next_time` if the time of the next message is not known."""


class Datum(msgspec.Struct, frozen=True, tag=True):
    """One notification of the sensors: `(name arg...)`, items by sensor name."""

    content: Fact


class Signal(msgspec.Struct, frozen=True, tag=True):
    """A signal `(:name arg...)`, items by sensor name [S 4]."""

    content: Fact
    #: The tickets of the activations, or of the request, that caused the signal; none
    #: for a signal of the world by itself.
    tickets: tuple[int, ...] = ()


class Reply(msgspec.Struct, frozen=True):
    """The result of a primitive and the data that came with it, in order."""

    result: str
    data: tuple[Fact, ...] = ()


class Refused(msgspec.Struct, frozen=True):
    """The refusal of a request or activation that cannot be carried out now.

    `conflicts` are the tickets of the conflicting requests and activations under way.
    The interpreter waits for their end or cancels them, and then repeats the request.
    If it can do neither, the request fails.
    """

    conflicts: tuple[int, ...] = ()
    #: The reason, a text for people.
    reason: str = ""


class Finished(msgspec.Struct, frozen=True, tag=True):
    """The end of a primitive that was not atomic, by the ticket of its request."""

    ticket: int
    reply: Reply


class Lost(msgspec.Struct, frozen=True, tag=True):
    """The end of a request or activation whose outcome nobody knows.

    The method ends like that of a refused request, with the result `interference`; no
    handler is called.
    """

    ticket: int
    #: The reason, a text for people.
    reason: str = ""


Message = Datum | Signal | Finished | Lost
