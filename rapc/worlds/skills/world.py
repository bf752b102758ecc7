"""A world of skills only: an adapter between the port and a runtime of skills.

An author writes a catalogue, and the method `tick` for the effects of a tick.

    class Kettle(SkillWorld):
        name = "kettle"
        kit = Kit(offer(CATALOGUE))

        def __init__(self, rng: Random, options: Mapping[str, Atom | bool]) -> None:
            super().__init__(SkillRuntime(CATALOGUE), Water(15.0), rng)

        def tick(self) -> Iterable[Told]:
            told = self.runtime.tick(self.time, {"heat": lambda: self.state.degrees})
            self.state.degrees += self.runtime.value(POWER) or 0
            return told
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from random import Random
from typing import Any, ClassVar, NoReturn

import msgspec

from rapc.base.chance import Stream, stream_in, stream_state
from rapc.base.code_places import place_of, place_of_error, said_by
from rapc.base.graph import Graph
from rapc.base.values import Atom, Fact, Number, number
from rapc.errors import PortError
from rapc.world import NOT_KNOWN, Offer, Refused, Signal, Time, World
from rapc.worlds.skills.catalogue import Catalogue, SkillRequest
from rapc.worlds.skills.runtime import EventTold, SkillRuntime
from rapc.worlds.states import reading_state


class _Saved(msgspec.Struct):
    now: Number
    ticks: int
    sent: list[tuple[str, tuple[Atom, ...], tuple[int, ...]]]
    rest: msgspec.Raw


class _Rest(msgspec.Struct, omit_defaults=True):
    skills: msgspec.Raw
    state: msgspec.Raw
    chance: Stream | None = None


def offer(skills: Catalogue, events: Mapping[str, int] | None = None) -> Offer:
    """Return the offer of a world to libraries; names have their colons.

    Args:
        skills: the skills with their events.
        events: further events without a skill, with the number of arguments.
    """
    told = {f":{name}": len(event.carries) for name, event in skills.events.items()}
    return Offer(
        skills={f":{n}": len(e.parameters) for n, e in skills.entries.items()},
        events={**told, **(events or {})},
    )


class SkillWorld(World):
    """A world with skills and without primitives, which advances in equal ticks.

    Each activation comes from the interpreter, and each message of the world is a
    signal. The time of the next signal is not known; `advance` stops at the first
    signal.

    Args:
        runtime: the skills.
        state: the other changing state, a msgspec struct, saved with the skills.
        rng: the random stream of the world, saved with the skills as `self.rng`.
    """

    #: The number of ticks in a time unit.
    ticks_a_unit: ClassVar[int] = 10

    def __init__(
        self,
        runtime: SkillRuntime,
        state: msgspec.Struct | None = None,
        rng: Random | None = None,
    ) -> None:
        self.runtime = runtime
        self.state: Any = state
        if rng is not None:
            #: The source of all chance, saved with the skills.
            self.rng = rng
        #: The number of ticks, the present tick included.
        self.ticks = 0
        self._now: Number = 0
        self._sent: list[EventTold] = []

    def __getattr__(self, name: str) -> NoReturn:
        """Raise a PortError if `SkillWorld.__init__` was not called."""
        kind = type(self)
        if name in {"runtime", "state", "ticks", "_now", "_sent"}:
            raise PortError(
                f"`__init__` of the class {kind.__name__} does not call that of "
                f"SkillWorld{place_of(kind.__init__)}"
            )
        raise AttributeError(f"`{kind.__name__}` has no attribute `{name}`")

    @abstractmethod
    def tick(self) -> Iterable[EventTold]:
        """Advance by a tick: read sensors, step the skills, apply the actuators.

        Returns:
            The events in order: the result of `runtime.tick`, and events without an
            activation.
        """

    @property
    def time(self) -> float:
        """The time in seconds at the end of the present tick."""
        return self.ticks / self.ticks_a_unit

    def now(self) -> Time:
        """Return the time of the clock."""
        return self._now

    def perform(self, ticket: int, request: Fact) -> NoReturn:
        """Refuse the request: the world has no primitives.

        Raises:
            ValueError: always.
        """
        raise ValueError(f"the world `{self.name}` has no primitive `{request[0]}`")

    def activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Switch skills on from the next tick.

        Args:
            ticket: the number of the activation.
            skills: the skills to run: names with their colons, then arguments.
            events: names of the events to report, with their colons.

        Returns:
            None, or the reason for a refusal: conflicting tickets, if a conflict is the
            reason.
        """
        wanted = [
            SkillRequest(str(s[0]).removeprefix(":"), tuple(s[1:])) for s in skills
        ]
        names = [event.removeprefix(":") for event in events]
        return self.runtime.activate(ticket, wanted, names)

    def deactivate(self, ticket: int) -> None:
        """Switch off the skills that only this activation has."""
        self.runtime.deactivate(ticket)

    def cancel(self, ticket: int) -> None:
        """Cancel an activation: the same as `deactivate`."""
        self.deactivate(ticket)

    def next_time(self) -> Time:
        """Return the present if signals wait to be sent, else `NOT_KNOWN`."""
        return self._now if self._sent else NOT_KNOWN

    def advance(self, to: Time) -> None:
        """Advance the clock to `to`, or to the first signal."""
        while not self._sent and self.ticks + 1 <= to * self.ticks_a_unit + 1e-6:
            self.ticks += 1
            self._sent += self._told()
            self._now = max(self._now, number(self.time))
        if not self._sent:
            self._now = max(self._now, to)

    def _told(self) -> Iterable[EventTold]:
        """Advance by a tick; validate and return its events.

        Raises:
            PortError: if a skill of a world of rapc fails in code outside rapc.
        """
        try:
            given = self.tick()
        except Exception as error:  # any exception of the code of a skill
            place = place_of_error(error).strip(" ()")
            if isinstance(error, PortError) or not place:
                raise
            said = f"the world `{self.name}` failed at {place}: {said_by(error)}"
            raise PortError(said) from error
        told = tuple(given) if isinstance(given, Iterable) else (given,)
        for one in told:
            if not isinstance(one, EventTold):
                raise PortError(
                    f"`tick` of the world `{self.name}` must return events, "
                    f"not {one!a:.60}{place_of(self.tick)}"
                )
        return told

    def messages(self) -> Sequence[Signal]:
        """Return the signals since the preceding call, in order of time."""
        sent, self._sent = self._sent, []
        return [
            Signal((f":{told.event}", *map(_plain, told.arguments)), told.tickets)
            for told in sent
        ]

    def network(self) -> Graph:
        """Return the network of the active skills as a graph."""
        return self.runtime.network.graph()

    def save(self) -> bytes:
        """Return the complete state, as JSON."""
        sent = [(t.event, t.arguments, t.tickets) for t in self._sent]
        rest = msgspec.Raw(self.save_rest())
        return msgspec.json.encode(_Saved(self._now, self.ticks, sent, rest))

    def restore(self, state: bytes) -> None:
        """Restore a saved state.

        Raises:
            ValueError: if the state is invalid or from a world with other options.
        """
        with reading_state(f"the world `{self.name}`"):
            saved = msgspec.json.decode(state, type=_Saved)
            if abs(saved.now * self.ticks_a_unit - saved.ticks) > 1:
                raise ValueError(f"{saved.ticks} ticks until {saved.now}")
        self.restore_rest(bytes(saved.rest))
        self._now, self.ticks = saved.now, saved.ticks
        self._sent = [EventTold(*told) for told in saved.sent]

    def save_rest(self) -> bytes:
        """Return the skills and the other state without the clock, as JSON.

        A subclass that overrides this method must override `restore_rest`.
        """
        skills = msgspec.Raw(self.runtime.save())
        # Decode once: whole numbers become floats here as after a restore.
        read = msgspec.json.decode(
            msgspec.json.encode(self.state), type=type(self.state)
        )
        state = msgspec.Raw(msgspec.json.encode(read))
        chance = stream_state(self.rng) if "rng" in self.__dict__ else None
        return msgspec.json.encode(_Rest(skills, state, chance))

    def restore_rest(self, rest: bytes) -> None:
        """Restore data of `save_rest`; after an error the world is unchanged.

        Raises:
            ValueError: if the data are not from this world.
        """
        with reading_state(f"the world `{self.name}`"):
            saved = msgspec.json.decode(rest, type=_Rest)
            state = msgspec.json.decode(saved.state, type=type(self.state))
            rng = None if saved.chance is None else stream_in(saved.chance)
            if (rng is None) == ("rng" in self.__dict__):
                raise ValueError("the random stream is missing or unexpected")
        self.runtime.restore(bytes(saved.skills))
        self.state = state
        if rng is not None:
            self.rng = rng


def _plain(value: Atom) -> Atom:
    return number(value) if isinstance(value, int | float) else value
