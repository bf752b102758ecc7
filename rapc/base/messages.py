"""Messages from a world to the interpreter: results, data, signals, times [T 3.3].

Authors of worlds import the names from `rapc.world`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

import msgspec

from rapc.base.values import Fact, Number

Time = Number
"""Simulated time units since the start of the run; never negative."""

OKAY: Final = "okay"
"""The result symbol of a primitive that succeeded."""

NOT_KNOWN: Final[Time] = math.inf
"""The result of `World.next_time` if the time of the next message is not known."""


Change = Fact
"""A change of memory as data, items by sensor name: `("assert", "lit", "lamp-1")`.

The first part is the name of a method of `HandlerMemory`, by `CHANGES`; the other parts
are its arguments."""

CHANGES: Mapping[str, tuple[int, int | None]] = {
    "assert": (1, None),
    "erase": (1, None),
    "introduce": (3, 3),
    "move": (2, 2),
    "lose": (1, 1),
    "fix-cardinality": (1, 1),
    "expire": (0, 0),
    "arrive": (1, 1),
}
"""The changes of memory, each with its lowest and highest number of arguments."""


class Datum(msgspec.Struct, frozen=True, tag=True):
    """One notification of the sensors: `(name arg...)`, items by sensor name."""

    content: Fact
    #: The changes of memory by the datum. They apply after its handler, or in place of
    #: its declared effects; None: there are no others.
    memory: tuple[Change, ...] | None = None
    #: The number that the machine has given to the message, for a machine that sends
    #: messages again: a run with a journal takes in a message only if its number is
    #: above those of its name so far. None: without number.
    number: int | None = None


class Signal(msgspec.Struct, frozen=True, tag=True):
    """A signal `(:name arg...)`, items by sensor name [S 4]."""

    content: Fact
    #: The tickets of the activations, or of the request, that caused the signal; none
    #: for a signal of the world by itself.
    tickets: tuple[int, ...] = ()
    #: See `Datum.number`.
    number: int | None = None


class Reply(msgspec.Struct, frozen=True):
    """The result of a primitive and the data that came with it, in order."""

    result: str
    data: tuple[Fact, ...] = ()
    #: The changes of memory by the result, before those of the data: see `Datum`.
    memory: tuple[Change, ...] | None = None


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


class Resumed(msgspec.Struct, frozen=True, tag=True):
    """The first message after a run was resumed, put before those of the world."""

    #: The time in seconds for which no process ran the run.
    seconds: Number
