"""A network of skills to look at, as a graph."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from rapc.base.graph import Edge, Graph, Vertex
from rapc.worlds.skills.network import Arbitration, is_event
from rapc.worlds.skills.runtime import SkillRuntime


@runtime_checkable
class Networked(Protocol):
    """A world whose network of skills can be drawn."""

    def network(self) -> Graph:
        """Return the network that is active now; nothing changes by that."""


def draw(runtime: SkillRuntime) -> Graph:
    """Return the network that is active now, from sensors to actuators and events.

    A vertex is of the kind `sensor`, `skill`, `event`, `arbiter` or `actuator`; an edge
    is labelled with its channel. Where nothing is active there are neither.
    """
    network = runtime.network
    kinds = {channel.name: "sensor" for channel in network.sensors}
    for member in network.order:
        if isinstance(member, Arbitration):
            kinds[member.key] = "arbiter"
        else:
            kinds[member.key] = "event" if is_event(member) else "skill"
    for link in network.edges:
        kinds.setdefault(link.end, "actuator")
    drawn = tuple(Vertex(key, kind, _label(key, kind)) for key, kind in kinds.items())
    links = network.edges
    edges = tuple([Edge(one.start, one.end, one.channel, one.delayed) for one in links])
    return Graph("skills", drawn, edges)


def _label(key: str, kind: str) -> str:
    if kind == "event":
        return key.partition(" of ")[0]
    return key.removesuffix(" (actuator)")
