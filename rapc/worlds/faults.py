"""Faults put into any world: chosen requests fail as told, whatever the world is.

A faulted request never reaches the world. It takes the time that the world says such
requests usually take (`Timed.usual_time`) and holds the robot meanwhile; then its
result, and the handler for it, are what the fault says. No data come with it.
"""

from __future__ import annotations

import random
from base64 import b64decode, b64encode
from collections.abc import Iterable, Sequence

import msgspec

from rapc.base.values import Fact, match, number
from rapc.library.signatures import Signatures
from rapc.world import (
    Drawable,
    Message,
    Refused,
    Reply,
    Savable,
    Skilled,
    Time,
    Timed,
    World,
)
from rapc.worlds.streams import Stream, stream_in, stream_state


class InjectedFault(msgspec.Struct, frozen=True):
    """Requests that are to fail, and how."""

    #: A pattern over the requests as the world gets them, items by sensor name.
    request: Fact
    #: The result of a request that fails.
    result: str
    #: The chance that one fails.
    p: float = 1
    #: The first and the last time at which requests may fail.
    start: Time = 0
    stop: Time | None = None

    def concerns(self, request: Fact, now: Time) -> bool:
        """Whether a request made now may be hit."""
        on_time = self.start <= now and (self.stop is None or now <= self.stop)
        return on_time and match(self.request, request) is not None


def problem(fault: InjectedFault, signatures: Signatures) -> str | None:
    """Return why a fault can hit nothing in a world, or None.

    Args:
        fault: the fault.
        signatures: what the world offers.
    """
    name = str(fault.request[0])
    found = signatures.fault("primitive", name, len(fault.request) - 1)
    found = found or signatures.no_result(name, fault.result)
    return None if found is None else str(found)


class _Saved(msgspec.Struct, frozen=True):
    """What `save` writes: the state of the world behind, and of the random stream."""

    world: str
    rng: Stream


class FaultyWorld(World):
    """A world some of whose requests fail.

    The optional parts of the port are there if the world behind has them.

    Args:
        world: the world behind.
        faults: tried in this order for each request; the first that hits counts.
        seed: the run's seed; faults have a random stream of their own, drawn from
            once for each fault of a chance below 1 that concerns a request.
    """

    def __init__(
        self, world: World, faults: Sequence[InjectedFault], seed: int
    ) -> None:
        self.name = world.name
        self.kit = world.kit
        self._world = world
        #: The world whose author answers for it, as Python's own wrappers have it.
        self.__wrapped__ = world
        self._faults = tuple(faults)
        self._rng = random.Random(f"{seed}:faults")
        if isinstance(world, Drawable):
            self.picture = world.picture
        if isinstance(world, Timed):
            self.usual_time = world.usual_time
        if isinstance(world, Skilled):
            self.activate, self.deactivate = world.activate, world.deactivate
        if isinstance(world, Savable):
            self._behind = world
            self.save, self.restore = self._save, self._restore

    def facts(self) -> Iterable[Fact]:
        """Return what the robot knows at first."""
        return self._world.facts()

    def now(self) -> Time:
        """Return the time of the clock."""
        return self._world.now()

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Fail as a fault says, or hand the request on."""
        now = self._world.now()
        for fault in self._faults:
            if fault.concerns(request, now) and self._hits(fault):
                behind = self._world
                takes = behind.usual_time(request) if isinstance(behind, Timed) else 0
                if takes:
                    behind.advance(number(now + takes))
                return Reply(fault.result)
        return self._world.perform(ticket, request)

    def cancel(self, ticket: int) -> None:
        """Have the world behind stop what it does for a request."""
        self._world.cancel(ticket)

    def _hits(self, fault: InjectedFault) -> bool:
        return fault.p >= 1 or self._rng.random() < fault.p

    def next_time(self) -> Time | None:
        """Return when the world behind will send something."""
        return self._world.next_time()

    def advance(self, to: Time) -> None:
        """Move the clock on."""
        self._world.advance(to)

    def messages(self) -> Sequence[Message]:
        """Return what the world behind has sent."""
        return self._world.messages()

    def ended(self) -> str | None:
        """Return why the world behind has ended the run, or None."""
        return self._world.ended()

    def _save(self) -> bytes:
        inner = b64encode(self._behind.save()).decode()
        return msgspec.json.encode(_Saved(inner, stream_state(self._rng)))

    def _restore(self, state: bytes) -> None:
        try:
            saved = msgspec.json.decode(state, type=_Saved)
            rng, inner = stream_in(saved.rng), b64decode(saved.world, validate=True)
        except ValueError as error:
            raise ValueError(f"no state of a world with faults: {error}") from error
        self._behind.restore(inner)
        self._rng = rng
