"""The wiring of the active skills.

`wire` connects every input to the writer of its channel: a sensor, the only active
skill with this output, or the arbiter of several skills. Each skill runs after the
skills that it reads. A delayed input requires no order, because it reads the value of
the preceding tick.

    sonar (sensor) -> detect-obstacles -> follow-trajectory -> drive (actuator)
                   -> track-hallway    ->

Where the wiring leaves the order open, skills run in the order of activation. So two
runs with the same activations step their skills in the same order.

A catalogue wires its classes on trial, so no other code checks a wiring.
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
        #: Keys of the skills in conflict, if a conflict is the reason.
        self.skills = tuple(skills)


class Periphery:
    """The surroundings of a network of skills."""

    #: Channels that the world writes.
    sensors: Sequence[Channel[Any]]
    #: Channels that the world reads.
    actuators: Sequence[Channel[Any]]
    #: Arbiters of channels that several skills may write.
    arbiters: Mapping[Channel[Any], Arbiter]


@dataclass(slots=True)
class Member:
    """A skill or an event in a network; on trial a class of skills."""

    #: Name and arguments; members with equal keys run once.
    key: str
    node: Any
    #: The key of an event's skill; None for a skill.
    host: str | None = None
    #: The activations with the skill, or with the event, oldest first.
    tickets: list[int] = field(default_factory=list)
    ports: Ports = field(init=False)

    @property
    def label(self) -> str:
        """Name of the skill or the event for messages."""
        return label_of(self.node) if isinstance(self.node, type) else f"`{self.key}`"

    @property
    def outputs(self) -> Sequence[Channel[Any]]:
        """Output channels of a skill; an event has no outputs."""
        return getattr(self.node, "outputs", ())


@dataclass(slots=True)
class Arbitration:
    """An arbiter in a network, which merges several slots."""

    arbiter: Arbiter
    slots: tuple[str, ...]


@dataclass(slots=True)
class Network:
    """Wired members, in the order in which they run.

    `values` has the values of the channels: the world enters the readings of its
    sensors.
    """

    #: The values of the channels in this tick, by slot.
    values: dict[str, Any] = field(default_factory=dict)
    #: Skills, events and arbiters by key, in the order in which they run.
    order: dict[str, Member | Arbitration] = field(default_factory=dict)
    edges: list[Edge] = field(default_factory=list)
    #: The sensors that a member reads.
    sensors: list[Channel[Any]] = field(default_factory=list)
    #: Channels whose value is kept for the next tick.
    delayed: list[Channel[Any]] = field(default_factory=list)

    def graph(self) -> Graph:
        """Return the network as a graph, from sensors to actuators and events.

        A vertex is of the kind `sensor`, `skill`, `event`, `arbiter` or `actuator`; an
        edge is labelled with its channel. Without active skills the graph is empty.
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
    """Return the slot of a channel's value in the preceding tick."""
    return f"{channel.name} before"


def wire(
    around: Periphery, members: Sequence[Member], *, trial: bool = False
) -> Network:
    """Return the network of `members`; wiring also sets their ports.

    Args:
        around: the sensors, actuators and arbiters.
        members: the skills and events.
        trial: whether further skills may be switched on and write missing inputs.

    Raises:
        WiringError: if an input has no writer, a channel has several writers without an
            arbiter, or skills form a circle without a delay.
    """
    wiring = _Wiring(around, members, trial)
    for member in members:
        wiring.connect(member)
    wiring.finish()
    return wiring.network


class _Wiring:
    """A call of `wire`."""

    def __init__(
        self, around: Periphery, members: Sequence[Member], trial: bool
    ) -> None:
        self.around = around
        self.trial = trial
        self.network = Network()
        self.sensors = {channel.name for channel in around.sensors}
        self.members: dict[str, Member | Arbitration] = {m.key: m for m in members}
        self.writers = self._find_writers(members)
        #: The writers that each member must follow in the order.
        self.before: dict[str, list[str]] = {member.key: [] for member in members}

    def _find_writers(self, members: Sequence[Member]) -> dict[Channel[Any], list[str]]:
        """Return the writers of each shared channel, after a check for arbiters."""
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
        """Return the name of a member or an arbiter for messages."""
        member = self.members[key]
        return member.label if isinstance(member, Member) else f"`{key}`"

    def connect(self, member: Member) -> None:
        """Set the ports of `member`, and note its edges."""
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
        """Return the slot of a skill's output."""
        if channel.own or channel in self.around.arbiters:
            return f"{channel.name} of {member.key}"
        return channel.name

    def _source(self, member: Member, channel: Channel[Any]) -> tuple[str, str | None]:
        """Return the slot that a member reads for a channel, and the writer."""
        if channel.own:
            return f"{channel.name} of {member.host}", member.host
        if channel.name in self.sensors:
            if channel not in self.network.sensors:
                self.network.sensors.append(channel)
            return channel.name, channel.name
        return channel.name, self._writer(channel)

    def _writer(self, channel: Channel[Any]) -> str | None:
        """Return the key of the skill or arbiter that writes a channel."""
        keys = self.writers.get(channel)
        if keys and channel in self.around.arbiters:
            return f"arbiter of {channel.name}"
        return keys[0] if keys else None

    def finish(self) -> None:
        """Add arbiters, sort all members, and connect the actuators."""
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
        """Yield the keys, each after its predecessors, else in their own order."""
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
    """Return a circle among keys that all have a predecessor here."""
    walk = [next(iter(before))]
    while True:
        following = next(key for key in before[walk[-1]] if key in before)
        if following in walk:
            return walk[walk.index(following) :]
        walk.append(following)
