"""The wiring of the skills that are active at a moment.

`wire` connects every input to what writes its channel: a sensor, the one active skill
that has it as output, or the arbiter between several. Skills run in an order in which
each comes after those it reads; a delayed input asks for no order, since it reads what
was written a tick ago.

    sonar (sensor) -> detect-obstacles -> follow-trajectory -> drive (actuator)
                   -> track-hallway    ->

The order is that of activation wherever wiring leaves it open, so that two runs with
the same activations step their skills alike.

A catalogue wires its classes on trial, so nothing else checks a wiring.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rapc.base.graph import Edge, Graph, Vertex
from rapc.worlds.skills.declarations import (
    Arbiter,
    Channel,
    Event,
    Ports,
    as_input,
    label_of,
)


class WiringError(ValueError):
    """Skills that cannot run together."""

    def __init__(self, reason: str, skills: Sequence[str] = ()) -> None:
        super().__init__(reason)
        #: Keys of the skills that stand in each other's way, if that is the reason.
        self.skills = tuple(skills)


class Periphery:
    """What a network of skills is wired to."""

    #: Channels that the world writes.
    sensors: Sequence[Channel[Any]]
    #: Channels that the world reads.
    actuators: Sequence[Channel[Any]]
    #: Who decides on a channel that several skills may write.
    arbiters: Mapping[Channel[Any], Arbiter]


@dataclass(slots=True)
class Member:
    """A skill or an event in a network; on trial a class of skills."""

    #: Name and arguments: equal for what runs once.
    key: str
    node: Any
    #: The key of an event's skill; None for a skill.
    host: str | None = None
    #: The activations that have the skill, or are told the event, oldest first.
    tickets: list[int] = field(default_factory=list)
    ports: Ports = field(init=False)

    @property
    def label(self) -> str:
        """Return how messages name the skill or the event."""
        return label_of(self.node) if isinstance(self.node, type) else f"`{self.key}`"

    @property
    def outputs(self) -> Sequence[Channel[Any]]:
        """Return the channels that a skill writes; an event writes none."""
        return getattr(self.node, "outputs", ())


@dataclass(slots=True)
class Arbitration:
    """The work of an arbiter in a network: many slots into one."""

    arbiter: Arbiter
    slots: tuple[str, ...]


@dataclass(slots=True)
class Network:
    """Members that have been wired, in the order in which they run.

    `values` is what the channels hold: the world puts in what its sensors say.
    """

    #: What the channels hold in this tick, by slot.
    values: dict[str, Any] = field(default_factory=dict)
    #: Skills, events and arbiters by key, in the order in which they run.
    order: dict[str, Member | Arbitration] = field(default_factory=dict)
    edges: list[Edge] = field(default_factory=list)
    #: The sensors that anything reads.
    sensors: list[Channel[Any]] = field(default_factory=list)
    #: Channels whose value is kept for the next tick.
    delayed: list[Channel[Any]] = field(default_factory=list)

    def graph(self) -> Graph:
        """Return the network to be drawn, from sensors to actuators and events.

        A vertex is of the kind `sensor`, `skill`, `event`, `arbiter` or `actuator`; an
        edge is labelled with its channel. Where nothing is active there are neither.
        """
        kinds = {channel.name: "sensor" for channel in self.sensors}
        for key, member in self.order.items():
            kinds[key] = "skill"
            if isinstance(member, Arbitration):
                kinds[key] = "arbiter"
            elif isinstance(member.node, Event):
                kinds[key] = "event"
        for edge in self.edges:
            kinds.setdefault(edge.target, "actuator")
        vertices = [Vertex(key, kind, _label(key, kind)) for key, kind in kinds.items()]
        return Graph("skills", tuple(vertices), tuple(self.edges))


def _label(key: str, kind: str) -> str:
    if kind == "event":
        return key.partition(" of ")[0]
    return key.removesuffix(" (actuator)")


def late(channel: Channel[Any]) -> str:
    """Return the slot that holds a channel's value of the tick before."""
    return f"{channel.name} before"


def wire(
    around: Periphery, members: Sequence[Member], *, trial: bool = False
) -> Network:
    """Return the network of `members`; their ports lead into it from now on.

    Args:
        around: the sensors, actuators and arbiters.
        members: the skills and events.
        trial: whether other skills may still come on and write what is read.

    Raises:
        WiringError: if an input has no writer, a channel several without an arbiter,
            or skills read each other in a circle without a delay.
    """
    wiring = _Wiring(around, members, trial)
    for member in members:
        wiring.connect(member)
    wiring.finish()
    return wiring.network


class _Wiring:
    """One call of `wire`."""

    def __init__(
        self, around: Periphery, members: Sequence[Member], trial: bool
    ) -> None:
        self.around = around
        self.trial = trial
        self.network = Network()
        self.sensors = {channel.name for channel in around.sensors}
        self.members: dict[str, Member | Arbitration] = {m.key: m for m in members}
        self.writers = self._find_writers(members)
        #: What each member has to come after.
        self.before: dict[str, list[str]] = {member.key: [] for member in members}

    def _find_writers(self, members: Sequence[Member]) -> dict[Channel[Any], list[str]]:
        """Return the keys of the skills that write each shared channel, if allowed."""
        writers: dict[Channel[Any], list[str]] = {}
        for member in members:
            for channel in member.outputs:
                if not channel.own:
                    writers.setdefault(channel, []).append(member.key)
        together = ", which come on together," if self.trial else ""
        for channel, keys in writers.items():
            if len(keys) > 1 and channel not in self.around.arbiters:
                both = " and ".join(map(self._named, keys[:2]))
                told = f"{both}{together} both write `{channel.name}`"
                raise WiringError(told, keys)
        return writers

    def _named(self, key: str) -> str:
        """Return how messages name a member or an arbiter."""
        member = self.members[key]
        return member.label if isinstance(member, Member) else f"`{key}`"

    def connect(self, member: Member) -> None:
        """Give `member` its ports, and note its edges."""
        network, reads = self.network, {}
        for wanted in map(as_input, member.node.inputs):
            channel = wanted.channel
            slot, start = self._source(member, channel)
            needed = not (wanted.optional or wanted.delayed or self.trial)
            if start is None and needed:
                raise WiringError(
                    f"{member.label} reads `{channel.name}`, which no skill "
                    "that comes on with it writes"
                )
            reads[channel] = late(channel) if wanted.delayed else slot
            if start is None:
                continue
            network.edges.append(Edge(start, member.key, channel.name, wanted.delayed))
            if wanted.delayed and channel not in network.delayed:
                network.delayed.append(channel)
            if not wanted.delayed and start not in self.sensors:
                self.before[member.key].append(start)
        writes = {channel: self._slot(member, channel) for channel in member.outputs}
        node = f"`{member.key}` ({type(member.node).__name__})"
        member.ports = Ports(node, network.values, reads, writes)

    def _slot(self, member: Member, channel: Channel[Any]) -> str:
        """Return where a skill writes one of its outputs."""
        if channel.own or channel in self.around.arbiters:
            return f"{channel.name} of {member.key}"
        return channel.name

    def _source(self, member: Member, channel: Channel[Any]) -> tuple[str, str | None]:
        """Return the slot that a member reads for a channel, and who writes it."""
        if channel.own:
            return f"{channel.name} of {member.host}", member.host
        if channel.name in self.sensors:
            if channel not in self.network.sensors:
                self.network.sensors.append(channel)
            return channel.name, channel.name
        return channel.name, self._writer(channel)

    def _writer(self, channel: Channel[Any]) -> str | None:
        """Return the key of the skill, or the arbiter, that writes a channel."""
        keys = self.writers.get(channel)
        if keys and channel in self.around.arbiters:
            return f"arbiter of {channel.name}"
        return keys[0] if keys else None

    def finish(self) -> None:
        """Put arbiters in, order everything, and connect the actuators."""
        network = self.network
        for channel, arbiter in self.around.arbiters.items():
            if keys := self.writers.get(channel):
                key = f"arbiter of {channel.name}"
                slots = tuple(f"{channel.name} of {writer}" for writer in keys)
                self.members[key] = Arbitration(arbiter, slots)
                self.before[key] = keys
                network.edges += (Edge(writer, key, channel.name) for writer in keys)
        network.order = {key: self.members[key] for key in self._ordered()}
        for channel in self.around.actuators:
            if writer := self._writer(channel):
                end = f"{channel.name} (actuator)"
                network.edges.append(Edge(writer, end, channel.name))

    def _ordered(self) -> Iterator[str]:
        """Yield the keys, each after those it comes after; else in their own order."""
        left = dict(self.before)
        while left:
            ready = next((k for k, b in left.items() if left.keys().isdisjoint(b)), "")
            if not ready:
                circle = _circle(left)
                told = " reads ".join(map(self._named, [*circle, circle[0]]))
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
