"""Faults put into any world: chosen requests fail, chosen signals go astray.

A faulted request never reaches the world. It takes the time that the world says such
requests usually take (`Timed.usual_time`) and holds the robot meanwhile; then its
result, and the handler for it, are what the fault says. No data come with it. What may
happen to signals is in `rapc.worlds.signal_faults`.
"""

from __future__ import annotations

import math
import random
from collections.abc import Container, Sequence

import msgspec

from rapc.base.chance import Stream, stream_in, stream_state
from rapc.base.code_places import place_of
from rapc.base.values import Fact, format_list, is_variable, match_pattern, number
from rapc.errors import PortError
from rapc.library.signatures import Signatures
from rapc.world import (
    Message,
    Refused,
    Reply,
    Time,
    Timed,
    World,
    Wrapper,
)
from rapc.worlds.signal_faults import HOW, SPURIOUS, Held, SignalFaults, Struck


class InjectedFault(msgspec.Struct, frozen=True):
    """Requests that are to fail, or signals that are to go astray, and how."""

    #: A pattern over the requests, or the signals, with items by sensor name.
    request: Fact
    #: The result of a request that fails; of a signal what happens to it: `HOW`.
    result: str
    #: The chance that one fails.
    p: float = 1
    #: The first and the last time at which requests may fail.
    start: Time = 0
    stop: Time | None = None
    #: How long after it was sent a late signal comes, or, after an activation for which
    #: it might be told came on, a spurious one.
    by: Time = 1

    @property
    def of_signal(self) -> bool:
        """Whether signals are meant, not requests."""
        return str(self.request[0]).startswith(":")

    def concerns(self, request: Fact, now: Time) -> bool:
        """Whether a request made, or a signal sent, now may be hit."""
        on_time = self.start <= now and (self.stop is None or now <= self.stop)
        return on_time and match_pattern(self.request, request) is not None


def problem(
    fault: InjectedFault, signatures: Signatures, told: Container[str] | None = None
) -> str | None:
    """Return why a fault can hit nothing in a world, or None.

    Args:
        fault: the fault.
        signatures: what the world offers.
        told: the events that may be told for skills, if that is known.
    """
    name = str(fault.request[0])
    if fault.of_signal:
        wrong = signatures.fault("event", name, len(fault.request) - 1)
        if wrong is None and fault.result not in HOW:
            return f"a signal is {', '.join(HOW[:-1])} or {HOW[-1]}, not {fault.result}"
        if wrong is None and fault.result == SPURIOUS and _open(fault.request):
            return f"a spurious signal has no variables: {format_list(fault.request)}"
        if wrong is None and fault.result == SPURIOUS and told is not None:
            return (
                None if name in told else f"`{name}` is told for no skills that come on"
            )
        return None if wrong is None else str(wrong)
    found = signatures.fault("primitive", name, len(fault.request) - 1)
    found = found or signatures.no_result(name, fault.result)
    return None if found is None else str(found)


def _open(signal: Fact) -> bool:
    return any(is_variable(part) for part in signal)


class _Saved(msgspec.Struct, frozen=True):
    """What `save` writes: the state of the world behind, and of the random stream."""

    world: bytes
    rng: Stream
    #: The signals that are still to come.
    held: tuple[Held, ...] = ()


def usual_time(world: World, request: Fact) -> Time:
    """Return how long a request usually takes; 0 if the world is not `Timed`.

    Raises:
        PortError: for what is no time.
    """
    if not isinstance(world, Timed):
        return 0
    takes = world.usual_time(request)
    if type(takes) not in (int, float) or not 0 <= takes < math.inf:
        place = place_of(world.usual_time)
        said = f"the usual time of {format_list(request)} is `{takes!a}`"
        raise PortError(f"{said}; see `usual_time`{place}")
    return takes


class FaultyWorld(Wrapper):
    """A world some of whose requests fail.

    Args:
        world: the world behind.
        faults: tried in this order for each request; the first that hits counts.
        seed: the run's seed; faults have a random stream of their own, drawn from
            once for each fault of a chance below 1 that concerns a request.
    """

    def __init__(
        self, world: World, faults: Sequence[InjectedFault], seed: int
    ) -> None:
        super().__init__(world)
        self._faults = tuple(faults)
        self._rng = random.Random(f"{seed}:faults")
        self._signals = SignalFaults(self._strike)

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Fail as a fault says, or hand the request on."""
        now = self.now()
        for fault in self._faults:
            if fault.concerns(request, now) and self._hits(fault):
                if takes := usual_time(self.behind, request):
                    self.advance(number(now + takes))
                return Reply(fault.result)
        return super().perform(ticket, request)

    def _hits(self, fault: InjectedFault) -> bool:
        return fault.p >= 1 or self._rng.random() < fault.p

    def next_time(self) -> Time | None:
        """Return when the world behind, or a signal held back, will send something."""
        times = (super().next_time(), self._signals.next_time())
        return min((time for time in times if time is not None), default=None)

    def messages(self) -> Sequence[Message]:
        """Return the messages of the world behind, as faults of signals change them."""
        sent = super().messages()
        if not (sent or self._signals.held) or not isinstance(sent, tuple | list):
            return sent
        return self._signals.pass_on(sent, self.now())

    def _strike(self, signal: Fact, now: Time) -> Struck | None:
        for fault in self._faults:
            meant = fault.of_signal and fault.result != SPURIOUS
            if meant and fault.concerns(signal, now) and self._hits(fault):
                return Struck(fault.result, fault.by)
        return None

    def _activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Have the world behind switch skills on; draw what will be told falsely."""
        refused: Refused | None = self.behind.activate(ticket, skills, events)
        now = self.now()
        for fault in self._faults if refused is None else ():
            told = fault.result == SPURIOUS and fault.request[0] in events
            if told and fault.concerns(fault.request, now) and self._hits(fault):
                time = number(now + fault.by)
                self._signals.hold(time, fault.request, (ticket,))
        return refused

    def _deactivate(self, ticket: int) -> None:
        self.behind.deactivate(ticket)
        self._signals.deactivate(ticket)

    def _save(self) -> bytes:
        state: bytes = self.behind.save()
        if not isinstance(state, bytes):
            return state  # the interpreter says so
        held = tuple(self._signals.held)
        return msgspec.json.encode(_Saved(state, stream_state(self._rng), held))

    def _restore(self, state: bytes) -> None:
        try:
            saved = msgspec.json.decode(state, type=_Saved)
            rng = stream_in(saved.rng)
        except ValueError as error:
            raise ValueError(f"no state of a world with faults: {error}") from error
        self.behind.restore(saved.world)
        self._rng = rng
        self._signals.held = list(saved.held)
