"""Faults put into any world: chosen requests fail as told, whatever the world is.

A faulted request never reaches the world. It takes the time that the world says such
requests usually take (`World.usual_time`) and holds the robot meanwhile; then its
result, and the handler for it, are what the fault says. No data come with it.
"""

from __future__ import annotations

import random
from base64 import b64decode, b64encode
from collections.abc import Iterable, Sequence

import msgspec

from rapc.base.names import counted, nearest
from rapc.base.values import Fact, match, number
from rapc.world import (
    Callables,
    Handlers,
    Message,
    Offer,
    Option,
    Picture,
    Reply,
    Time,
    World,
)


class Fault(msgspec.Struct, frozen=True):
    """Requests that are to fail, and how.

    `request` is a pattern over what is sent to the world (items by sensor name); `p`
    the chance that one fails; `start` and `stop` bound the time of the request, both
    included.
    """

    request: Fact
    result: str
    p: float = 1
    start: Time = 0
    stop: Time | None = None

    def concerns(self, request: Fact, now: Time) -> bool:
        """Whether a request made now may be hit."""
        on_time = self.start <= now and (self.stop is None or now <= self.stop)
        return on_time and match(self.request, request) is not None


def problem(fault: Fault, offer: Offer) -> str | None:
    """Why a fault can hit nothing in a world that offers so much, or None."""
    name = str(fault.request[0])
    arity, results = offer.primitives.get(name, (None, ()))
    if arity is None:
        return f"there is no primitive `{name}`{_meant(name, offer.primitives)}"
    if arity != len(fault.request) - 1:
        takes = counted(arity, "argument")
        return f"`{name}` takes {takes}, not {len(fault.request) - 1}"
    if fault.result not in results:
        meant = _meant(fault.result, results)
        return f"`{fault.result}` is no result of `{name}`{meant}"
    return None


def _meant(name: str, names: Iterable[str]) -> str:
    near = nearest(name, names)
    return f"; did you mean `{near}`?" if near else ""


class _Saved(msgspec.Struct, frozen=True):
    world: str
    rng: tuple[int, tuple[int, ...], float | None]


class FaultyWorld(World):
    """A world some of whose requests fail.

    Args:
        world: what is behind it.
        faults: tried in this order for each request; the first that hits counts.
        seed: the run's seed; faults have a random stream of their own, drawn from
            once for each fault of a chance below 1 that concerns a request.
    """

    def __init__(self, world: World, faults: Sequence[Fault], seed: int) -> None:
        self.name = world.name
        self._world = world
        self._faults = tuple(faults)
        self._rng = random.Random(f"{seed}:faults")
        # What a class registers is asked of the one behind, whose class is not known.
        self.functions = self._functions  # type: ignore[method-assign]
        self.comparators = self._comparators  # type: ignore[method-assign]
        self.solvers = self._solvers  # type: ignore[method-assign]

    @classmethod
    def options(cls) -> Sequence[Option]:
        """None: it is put around a world that has its own."""
        return ()

    def offer(self) -> Offer:
        """What the world behind offers."""
        return self._world.offer()

    def handlers(self) -> Handlers:
        """The handlers of the world behind."""
        return self._world.handlers()

    def _functions(self) -> Callables:
        return self._world.functions()

    def _comparators(self) -> Callables:
        return self._world.comparators()

    def _solvers(self) -> Callables:
        return self._world.solvers()

    def facts(self) -> Iterable[Fact]:
        """What the robot knows at first."""
        return self._world.facts()

    def now(self) -> Time:
        """The clock."""
        return self._world.now()

    def perform(self, ticket: int, request: Fact) -> Reply | None:
        """Fail as told, or hand the request on."""
        now = self._world.now()
        for fault in self._faults:
            if fault.concerns(request, now) and self._hits(fault):
                takes = self._world.usual_time(request)
                if takes:
                    self._world.advance(number(now + takes))
                return Reply(fault.result)
        return self._world.perform(ticket, request)

    def _hits(self, fault: Fault) -> bool:
        return fault.p >= 1 or self._rng.random() < fault.p

    def usual_time(self, request: Fact) -> Time:
        """What the world behind says."""
        return self._world.usual_time(request)

    def next_time(self) -> Time | None:
        """When the world behind will send something."""
        return self._world.next_time()

    def advance(self, to: Time) -> None:
        """Move the clock on."""
        self._world.advance(to)

    def messages(self) -> Sequence[Message]:
        """What the world behind has sent."""
        return self._world.messages()

    def ended(self) -> str | None:
        """Why the world behind has ended the run, or None."""
        return self._world.ended()

    def picture(self) -> Picture | None:
        """The picture of the world behind, or None."""
        return self._world.picture()

    def save(self) -> bytes:
        """The state of the world behind and of the random stream, as JSON."""
        version, internal, gauss = self._rng.getstate()
        inner = b64encode(self._world.save()).decode()
        return msgspec.json.encode(_Saved(inner, (version, tuple(internal), gauss)))

    def restore(self, state: bytes) -> None:
        """Take up a state that `save` returned."""
        saved = msgspec.json.decode(state, type=_Saved)
        self._rng.setstate(saved.rng)
        self._world.restore(b64decode(saved.world))
