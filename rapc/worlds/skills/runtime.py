"""Switching skills on and off, and stepping the active skills at a fixed rate.

An activation is a set of skills that were switched on together, and the events to
report to the activation [S 3]. A skill with equal arguments in several activations runs
once, until the last of the activations has ended; its events belong to all of them.

Not here: the members of an activation and the check of a new activation, see
`activations`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import msgspec

from rapc.base.code_places import place_of
from rapc.base.names import plural
from rapc.base.values import Atom
from rapc.errors import PortError
from rapc.world import Refused
from rapc.worlds.skills.activations import ActiveSkills, members_of, refusal
from rapc.worlds.skills.catalogue import Catalogue, SkillRequest
from rapc.worlds.skills.declarations import Channel, Event, Skill, SkillError
from rapc.worlds.skills.network import (
    Arbitration,
    Member,
    Network,
    late,
    wire,
)
from rapc.worlds.states import reading_state

T = TypeVar("T")

Sensors = Mapping[str, Callable[[], Any]]
"""The reader of each sensor, by the name of its channel."""


class EventTold(msgspec.Struct, frozen=True):
    """An event whose test passed in a tick."""

    event: str
    arguments: tuple[Atom, ...]
    #: The activations of the event, oldest first.
    tickets: tuple[int, ...]


class _Saved(msgspec.Struct):
    activations: list[ActiveSkills]
    #: The state of each skill and event, by key.
    states: dict[str, Any]
    #: The time of the last report of each event, by key and ticket; only for events
    #: whose test has passed since.
    told: dict[str, dict[int, float]]
    #: The values of the delayed channels, by slot.
    before: dict[str, Any]


class SkillRuntime:
    """The skills of a robot: the active skills, their states and their events."""

    def __init__(self, catalogue: Catalogue) -> None:
        self.catalogue = catalogue
        #: The active activations, oldest first.
        self.activations: dict[int, ActiveSkills] = {}
        self._members: dict[str, Member] = {}
        self._told: dict[str, dict[int, float]] = {}
        self.network = Network()
        self._before: dict[str, Any] = {}

    def activate(
        self, ticket: int, skills: Sequence[SkillRequest], events: Iterable[str]
    ) -> Refused | None:
        """Switch `skills` on from the next tick.

        Args:
            ticket: the number of the activation.
            skills: the skills to run.
            events: the names of the events to report.

        Returns:
            None, or the reason for a refusal; without `conflicts` the refusal is
            permanent.

        Raises:
            ValueError: if `ticket` is active already.
        """
        if ticket in self.activations:
            raise ValueError(f"the activation {ticket} is under way already")
        new = ActiveSkills(ticket, tuple(skills), tuple(dict.fromkeys(events)))
        refused = refusal(self.catalogue, self.activations.values(), new)
        if refused is None:
            self.activations[ticket] = new
            self._rebuild()
        return refused

    def deactivate(self, ticket: int) -> None:
        """Switch off skills that only `ticket` has; ignore unknown tickets."""
        if self.activations.pop(ticket, None) is not None:
            self._rebuild()

    def tick(self, now: float, sensors: Sensors) -> list[EventTold]:
        """Step every active skill once, and return the events whose test passed.

        Args:
            now: the time in seconds.
            sensors: the readers of the sensors; only sensors in use are read.
        """
        network, told = self.network, []
        values = network.values
        values.clear()
        values.update(self._before)
        for channel in network.sensors:
            values[channel.name] = _sensed(channel, sensors)
        for member in network.order.values():
            if isinstance(member, Arbitration):
                self._arbitrate(member, values)
            elif isinstance(member.node, Skill):
                member.node.step(now, member.ports)
            elif isinstance(member.node, Event):
                told += self._listen(now, member, member.node)
        self._before = {
            late(channel): values[channel.name]
            for channel in network.delayed
            if channel.name in values
        }
        return told

    def value(self, channel: Channel[T]) -> T | None:
        """Return the value of a channel in the last tick, or None."""
        value: T | None = self.network.values.get(channel.name)
        return value

    def active(self) -> tuple[str, ...]:
        """Return the keys of the active skills, in the order of activation."""
        return tuple(key for key, m in self._members.items() if m.host is None)

    def save(self) -> bytes:
        """Return the complete state of the runtime, as JSON."""
        states = {
            key: msgspec.to_builtins(member.node.state, str_keys=True)
            for key, member in self._members.items()
        }
        activations = list(self.activations.values())
        saved = _Saved(activations, states, self._told, self._before)
        return msgspec.json.encode(saved)

    def restore(self, saved: bytes) -> None:
        """Restore a state that `save` returned.

        Raises:
            ValueError: if the state is invalid or has other skills; the runtime is
                unchanged then.
        """
        other = SkillRuntime(self.catalogue)
        with reading_state("these skills"):
            state = msgspec.json.decode(saved, type=_Saved)
            for activation in state.activations:
                if refused := other.activate(
                    activation.ticket, activation.skills, activation.events
                ):
                    raise ValueError(refused.reason)
            other._take_states(state)
        self.__dict__.update(other.__dict__)

    def _take_states(self, saved: _Saved) -> None:
        for key, member in self._members.items():
            member.node.state = msgspec.convert(saved.states[key], member.node.State)
        self._told.update(saved.told)
        for channel in self.network.delayed:
            if late(channel) in saved.before:
                value = saved.before[late(channel)]
                self._before[late(channel)] = msgspec.convert(value, channel.type)

    def _rebuild(self) -> None:
        """Wire the active skills and events; remaining skills keep their state."""
        under_way, old = self.activations.values(), self._members
        self._members = members_of(self.catalogue, under_way, old)
        self._told = {
            key: {t: at for t, at in self._told.get(key, {}).items() if t in m.tickets}
            for key, m in self._members.items()
            if m.host is not None
        }
        self.network = wire(self.catalogue, list(self._members.values()))
        kept = {late(channel) for channel in self.network.delayed}
        self._before = {s: v for s, v in self._before.items() if s in kept}

    def _arbitrate(self, work: Arbitration, values: dict[str, Any]) -> None:
        given = [values[slot] for slot in work.slots if slot in values]
        if given:
            value, channel = work.arbiter.decide(given), work.arbiter.channel
            if not channel.fits(value):
                raise SkillError(
                    f"the class {type(work.arbiter).__name__} decides on {value!a:.60} "
                    f"for `{channel.name}`, which is {channel.kind}"
                )
            values[channel.name] = value

    def _listen(self, now: float, member: Member, event: Event) -> list[EventTold]:
        """Test an event, and report it to the activations that have no report yet."""
        said, told = event.test(now, member.ports), self._told[member.key]
        if said is None:
            told.clear()
            return []
        _check_carried(event, said)
        hearers = [
            ticket
            for ticket in member.tickets
            if ticket not in told
            or (event.again is not None and now - told[ticket] >= event.again - 1e-9)
        ]
        told.update(dict.fromkeys(hearers, now))
        return [EventTold(event.name, said, tuple(hearers))] if hearers else []


def _sensed(channel: Channel[Any], sensors: Sensors) -> Any:
    """Return the reading of a sensor; raise SkillError if the type is wrong."""
    read = sensors.get(channel.name)
    if not callable(read):
        told = "is given no function that reads it"
        if read is not None:
            told = f"is read by calling a function, not {read!a:.60}"
        raise SkillError(f"the sensor `{channel.name}` {told}")
    value = read()
    if not channel.fits(value):
        raise SkillError(
            f"the sensor `{channel.name}` is {value!a:.60}, and the channel "
            f"{channel.kind}"
        )
    return value


def _check_carried(event: Event, said: object) -> None:
    """Validate the arguments of an event; raise PortError."""
    wanted = len(event.carries)
    fault: str | None = None
    if not isinstance(said, tuple):
        fault = f"a tuple or None, not {said!a:.60}"
    elif len(said) != wanted:
        fault = f"{plural(wanted, 'value')}, as `carries` says, not {len(said)}"
    else:
        for carried, value in zip(event.carries, said, strict=True):
            if wrong := carried.fault(value):
                fault = f"{value!a:.60}: {wrong}"
                break
    if fault is not None:
        raise PortError(
            f"`test` of the class {type(event).__name__} returns {fault}"
            f"{place_of(event.test)}"
        )
