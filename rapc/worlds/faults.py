"""Faults for any world: chosen requests fail, chosen signals are lost or changed.

A faulted request does not reach the world. The request holds the robot for the usual
duration (`Timed.usual_time`). Then the interpreter gets the result of the fault, and
calls the handler of this result. The result comes without data.

A late signal comes some time after its sending, if one of its activations is still
active. A spurious signal comes that time after the start of an activation for which
the signal might be reported, although no skill has reported it.
"""

from __future__ import annotations

import math
import random
from abc import abstractmethod
from collections.abc import Container, Mapping, Sequence
from typing import Any, ClassVar

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
    Signal,
    Time,
    Timed,
    World,
    Wrapper,
)
from rapc.worlds.states import reading_state

LOST = "lost"
LATE = "late"
DOUBLED = "doubled"
SPURIOUS = "spurious"

HOW = (LOST, LATE, DOUBLED, SPURIOUS)
"""The faults of a signal."""


class InjectedFault(msgspec.Struct, frozen=True):
    """Requests to fail, or signals to change, with the kind of fault."""

    #: A pattern over the requests, or the signals, with items by sensor name.
    request: Fact
    #: The result of a failing request; for a signal, its fault: `HOW`.
    result: str
    #: The probability of the fault.
    p: float = 1
    #: The first and the last time of the fault.
    start: Time = 0
    stop: Time | None = None
    #: The delay of a late signal after its sending, or of a spurious signal after the
    #: start of an activation for which the signal might be reported.
    by: Time = 1

    @property
    def of_signal(self) -> bool:
        """Return whether the fault concerns signals, not requests."""
        return str(self.request[0]).startswith(":")

    def concerns(self, request: Fact, now: Time) -> bool:
        """Return whether the fault may affect a request or a signal at this time."""
        on_time = self.start <= now and (self.stop is None or now <= self.stop)
        return on_time and match_pattern(self.request, request) is not None


def problem(
    fault: InjectedFault, signatures: Signatures, told: Container[str] | None = None
) -> str | None:
    """Return the reason why a fault can affect nothing in a world, or None.

    Args:
        fault: the fault.
        signatures: the offer of the world.
        told: the events that may be reported for skills, if known.
    """
    name, count = str(fault.request[0]), len(fault.request) - 1
    if not fault.of_signal:
        wrong = signatures.fault("primitive", name, count)
        wrong = wrong or signatures.no_result(name, fault.result)
        return None if wrong is None else str(wrong)
    if wrong := signatures.fault("event", name, count):
        return str(wrong)
    if fault.result not in HOW:
        return f"a signal is {', '.join(HOW[:-1])} or {HOW[-1]}, not {fault.result}"
    if fault.result == SPURIOUS:
        if any(map(is_variable, fault.request)):
            return f"a spurious signal has no variables: {format_list(fault.request)}"
        if told is not None and name not in told:
            return f"no skill of a request emits `{name}`"
    return None


class SubstituteWorld(Wrapper):
    """A wrapper of a world that answers some requests itself.

    A subclass defines in `own` and `read` its own part of the saved state.
    """

    #: The struct that `save` writes; its first field is the state of the wrapped world.
    Saved: ClassVar[type[Any]]
    #: The word for the substituted parts in messages.
    has: ClassVar[str]

    @abstractmethod
    def own(self) -> tuple[Any, ...]:
        """Return the other fields of `Saved`."""

    @abstractmethod
    def read(self, saved: Any) -> Mapping[str, Any]:
        """Return the attributes from a saved state. Raises ValueError."""

    def answer(self, request: Fact, result: str) -> Reply:
        """End a request with a result after its usual duration.

        Raises:
            PortError: if the wrapped world returns an invalid time.
        """
        takes: Time = 0
        if isinstance(self.behind, Timed):
            takes = self.behind.usual_time(request)
            if type(takes) not in (int, float) or not 0 <= takes < math.inf:
                place = place_of(self.behind.usual_time)
                said = f"the usual time of {format_list(request)} is `{takes!a}`"
                raise PortError(f"{said}; see `usual_time`{place}")
        if takes:
            self.advance(number(self.now() + takes))
        return Reply(result)

    def _save(self) -> bytes:
        state: bytes = self.behind.save()
        if not isinstance(state, bytes):
            return state  # the interpreter reports the error
        return msgspec.json.encode(self.Saved(state, *self.own()))

    def _restore(self, state: bytes) -> None:
        with reading_state(f"a world with {self.has}"):
            saved = msgspec.json.decode(state, type=self.Saved)
            read = self.read(saved)
        self.behind.restore(saved.world)
        vars(self).update(read)


class HeldSignal(msgspec.Struct, frozen=True):
    """A signal that is still to come, with its time."""

    time: Time
    content: Fact
    #: The activations of the signal, if any.
    tickets: tuple[int, ...] = ()


class _Saved(msgspec.Struct, frozen=True):
    world: bytes
    rng: Stream
    held: tuple[HeldSignal, ...] = ()


class FaultyWorld(SubstituteWorld):
    """A wrapper of a world that makes some requests fail and changes some signals.

    Args:
        world: the wrapped world.
        faults: tried in this order for each request; the first matching fault applies.
        seed: the run's seed. Faults have their own random stream, with a draw for each
            matching fault of a probability below 1.
    """

    Saved = _Saved
    has = "faults"

    def __init__(
        self, world: World, faults: Sequence[InjectedFault], seed: int
    ) -> None:
        super().__init__(world)
        #: The faults, in the order in which they are tried.
        self.faults = tuple(faults)
        self._rng = random.Random(f"{seed}:faults")
        #: The signals that are still to come, soonest first.
        self._held: list[HeldSignal] = []

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        """Fail as a fault requires, or pass the request on."""
        fault = self._hit(request, [f for f in self.faults if not f.of_signal])
        if fault is not None:
            return self.answer(request, fault.result)
        return super().perform(ticket, request)

    def _hit(
        self, request: Fact, faults: Sequence[InjectedFault]
    ) -> InjectedFault | None:
        """Return the first fault that affects a request, or a signal, at this time."""
        now = self.now()
        for fault in faults:
            if fault.concerns(request, now) and self._hits(fault):
                return fault
        return None

    def _hits(self, fault: InjectedFault) -> bool:
        return fault.p >= 1 or self._rng.random() < fault.p

    def next_time(self) -> Time | None:
        """Return the time of the wrapped world's next message, or of a held signal."""
        times = (super().next_time(), self._held[0].time if self._held else None)
        return min((time for time in times if time is not None), default=None)

    def messages(self) -> Sequence[Message]:
        """Return the messages of the wrapped world, with faults applied to signals.

        The held signals that are due follow these messages.
        """
        sent = super().messages()
        if not (sent or self._held) or not isinstance(sent, tuple | list):
            return sent
        found: list[Message] = []
        faults = [f for f in self.faults if f.of_signal and f.result != SPURIOUS]
        for message in sent:
            fault = None
            if isinstance(message, Signal):
                fault = self._hit(message.content, faults)
            if fault is None:
                found.append(message)
            elif fault.result == DOUBLED:
                found += [message, message]
            elif fault.result == LATE:
                self._hold(fault, message.content, message.tickets)
        due = [held for held in self._held if held.time <= self.now()]
        self._held = self._held[len(due) :]
        return [*found, *(Signal(held.content, held.tickets) for held in due)]

    def _hold(
        self, fault: InjectedFault, content: Fact, tickets: tuple[int, ...]
    ) -> None:
        """Hold a signal for the delay of a fault."""
        time = number(self.now() + fault.by)
        self._held.append(HeldSignal(time, content, tickets))
        self._held.sort(key=lambda held: held.time)

    def _activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Switch skills on in the wrapped world; draw the spurious signals."""
        refused: Refused | None = self.behind.activate(ticket, skills, events)
        now = self.now()
        for fault in self.faults if refused is None else ():
            told = fault.result == SPURIOUS and fault.request[0] in events
            if told and fault.concerns(fault.request, now) and self._hits(fault):
                self._hold(fault, fault.request, (ticket,))
        return refused

    def _deactivate(self, ticket: int) -> None:
        """Switch skills off; drop held signals that belong only to this activation."""
        self.behind.deactivate(ticket)
        kept = []
        for held in self._held:
            left = tuple([one for one in held.tickets if one != ticket])
            if left or not held.tickets:
                kept.append(msgspec.structs.replace(held, tickets=left))
        self._held = kept

    def own(self) -> tuple[Stream, tuple[HeldSignal, ...]]:
        """Return the random stream and the held signals."""
        return stream_state(self._rng), tuple(self._held)

    def read(self, saved: _Saved) -> Mapping[str, Any]:
        """Return the random stream and the held signals of a saved state."""
        return {"_rng": stream_in(saved.rng), "_held": list(saved.held)}
