"""The wiring of the skills that are active at a moment.

`wire` connects every input to what writes its channel: a sensor, the one active skill
that has it as output, or the arbiter between several. Skills run in an order in which
each comes after those it reads; a delayed input asks for no order, since it reads what
was written a tick ago.

    sonar (sensor) -> detect-obstacles -> follow-trajectory -> drive (actuator)
                   -> track-hallway    ->

The order is that of activation wherever wiring leaves it open, so that two runs with
the same activations step their skills alike.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import msgspec

from rapc.worlds.skills.catalogue import Catalogue
from rapc.worlds.skills.declarations import (
    Arbiter,
    Channel,
    Event,
    NetworkNode,
    Ports,
    Skill,
    as_input,
)


class WiringError(ValueError):
    """Skills that cannot run together."""

    def __init__(self, reason: str, skills: Sequence[str] = ()) -> None:
        super().__init__(reason)
        #: Keys of the skills that stand in each other's way, if that is the reason.
        self.skills = tuple(skills)


class Member:
    """A skill or an event in a network."""

    __slots__ = ("host", "key", "node", "ports")

    def __init__(self, key: str, node: NetworkNode, host: str | None = None) -> None:
        #: Name and arguments: equal for what runs once.
        self.key = key
        self.node = node
        #: The key of an event's skill; None for a skill.
        self.host = host
        self.ports: Ports


class Link(msgspec.Struct, frozen=True, order=True):
    """A channel on its way from one end to another, ends by key."""

    start: str
    end: str
    channel: str
    delayed: bool = False


class Network:
    """Members that have been wired, in the order in which they run.

    `values` is what the channels hold: the world puts in what its sensors say.
    """

    __slots__ = ("arbiters", "delayed", "edges", "order", "sensors", "values")

    def __init__(self) -> None:
        #: What the channels hold in this tick, by slot.
        self.values: dict[str, Any] = {}
        #: Skills and events, and arbiters as the slots they read and the one they
        #: write, in the order in which they run.
        self.order: list[Member | Arbitration] = []
        #: Who writes a channel that has an arbiter, by the channel's name.
        self.arbiters: dict[str, tuple[str, ...]] = {}
        self.edges: list[Link] = []
        #: The sensors that anything reads.
        self.sensors: list[Channel[Any]] = []
        #: Channels whose value is kept for the next tick.
        self.delayed: list[Channel[Any]] = []


class Arbitration:
    """The work of an arbiter in a network: many slots into one."""

    __slots__ = ("arbiter", "slots")

    def __init__(self, arbiter: Arbiter, slots: tuple[str, ...]) -> None:
        self.arbiter = arbiter
        self.slots = slots

    @property
    def key(self) -> str:
        """Return the name under which the arbiter stands in edges."""
        return f"arbiter of {self.arbiter.channel.name}"


def late(channel: Channel[Any]) -> str:
    """Return the slot that holds a channel's value of the tick before."""
    return f"{channel.name} before"


def wire(catalogue: Catalogue, members: Sequence[Member]) -> Network:
    """Return the network of `members`; their ports lead into it from now on.

    Raises:
        WiringError: if an input has no writer, a channel several without an arbiter,
            or skills read each other in a circle without a delay.
    """
    wiring = _Wiring(catalogue, members)
    for member in members:
        wiring.connect(member)
    wiring.finish()
    return wiring.network


class _Wiring:
    """One call of `wire`."""

    def __init__(self, catalogue: Catalogue, members: Sequence[Member]) -> None:
        self.catalogue = catalogue
        self.members = members
        self.network = Network()
        self.sensors = {channel.name for channel in catalogue.sensors}
        self.writers = self._find_writers()
        #: What each member has to come after.
        self.before: dict[str, list[str]] = {member.key: [] for member in members}

    def _find_writers(self) -> Mapping[Channel[Any], list[str]]:
        """The keys of the skills that write each shared channel, if allowed."""
        writers: dict[Channel[Any], list[str]] = {}
        for member in self.members:
            for channel in _outputs(member.node):
                if not channel.own:
                    writers.setdefault(channel, []).append(member.key)
        for channel, keys in writers.items():
            if len(keys) > 1 and channel not in self.catalogue.arbiters:
                both = " and ".join(f"`{key}`" for key in keys[:2])
                raise WiringError(f"{both} both write `{channel.name}`", keys)
        return writers

    def connect(self, member: Member) -> None:
        """Give `member` its ports, and note its edges."""
        reads: dict[Channel[Any], str] = {}
        for reads_ in member.node.inputs:
            wanted = as_input(reads_)
            slot, start = self._source(member, wanted.channel)
            if start is None and not (wanted.optional or wanted.delayed):
                raise WiringError(
                    f"`{member.key}` reads `{wanted.channel.name}`, which no skill "
                    "that comes on with it writes"
                )
            reads[wanted.channel] = late(wanted.channel) if wanted.delayed else slot
            if start is None:
                continue
            self.network.edges.append(
                Link(start, member.key, wanted.channel.name, wanted.delayed)
            )
            if wanted.delayed:
                if wanted.channel not in self.network.delayed:
                    self.network.delayed.append(wanted.channel)
            elif start not in self.sensors:
                self.before[member.key].append(start)
        writes = {
            channel: self._slot(member, channel) for channel in _outputs(member.node)
        }
        node = f"`{member.key}` ({type(member.node).__name__})"
        member.ports = Ports(node, self.network.values, reads, writes)

    def _slot(self, member: Member, channel: Channel[Any]) -> str:
        """Return where a skill writes one of its outputs."""
        if channel.own or channel in self.catalogue.arbiters:
            return f"{channel.name} of {member.key}"
        return channel.name

    def _source(self, member: Member, channel: Channel[Any]) -> tuple[str, str | None]:
        """The slot that a member reads for a channel, and who writes it, if any."""
        if channel.own:
            return f"{channel.name} of {member.host}", member.host
        if channel.name in self.sensors:
            if channel not in self.network.sensors:
                self.network.sensors.append(channel)
            return channel.name, channel.name
        keys = self.writers.get(channel)
        if not keys:
            return channel.name, None
        if channel in self.catalogue.arbiters:
            return channel.name, f"arbiter of {channel.name}"
        return channel.name, keys[0]

    def finish(self) -> None:
        """Put arbiters in, order everything, and connect the actuators."""
        arbitrations = {}
        for channel, arbiter in self.catalogue.arbiters.items():
            keys = self.writers.get(channel)
            if keys:
                slots = tuple(f"{channel.name} of {key}" for key in keys)
                made = Arbitration(arbiter, slots)
                arbitrations[made.key] = made
                self.before[made.key] = list(keys)
                self.network.arbiters[channel.name] = tuple(keys)
                self.network.edges += (Link(k, made.key, channel.name) for k in keys)
        by_key: dict[str, Member | Arbitration] = {m.key: m for m in self.members}
        by_key |= arbitrations
        self.network.order = [by_key[key] for key in _ordered(self.before)]
        for channel in self.catalogue.actuators:
            keys = self.writers.get(channel)
            if keys:
                judged = channel in self.catalogue.arbiters
                start = f"arbiter of {channel.name}" if judged else keys[0]
                self.network.edges.append(
                    Link(start, f"{channel.name} (actuator)", channel.name)
                )


def _outputs(node: NetworkNode) -> Sequence[Channel[Any]]:
    return node.outputs if isinstance(node, Skill) else ()


def _ordered(before: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """The keys, each after those it has to come after; else in their own order."""
    left = dict(before)
    while left:
        ready = next((k for k, b in left.items() if not any(x in left for x in b)), "")
        if not ready:
            circle = _circle(left)
            told = " reads ".join(f"`{key}`" for key in [*circle, circle[0]])
            raise WiringError(f"{told}, without a delay", circle)
        del left[ready]
        yield ready


def _circle(before: Mapping[str, Sequence[str]]) -> list[str]:
    """One circle among keys of which each has to come after another one here."""
    walk = [next(iter(before))]
    while True:
        following = next(key for key in before[walk[-1]] if key in before)
        if following in walk:
            return walk[walk.index(following) :]
        walk.append(following)


def is_event(member: Member) -> bool:
    """Return whether a member is an event, not a skill."""
    return isinstance(member.node, Event)
