"""A network of skills to look at: as data, as Graphviz dot, as a Mermaid flowchart."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import msgspec

from rapc.worlds.skills.network import Arbitration, Link, is_event
from rapc.worlds.skills.runtime import SkillRuntime


class Box(msgspec.Struct, frozen=True):
    """An end of edges in a drawing."""

    key: str
    #: One of `sensor`, `skill`, `event`, `arbiter`, `actuator`.
    kind: str
    label: str


class Drawing(msgspec.Struct, frozen=True):
    """The network that is active at a moment, from sensors to actuators and events.

    Where nothing is active there are neither boxes nor edges.
    """

    boxes: tuple[Box, ...]
    edges: tuple[Link, ...]


_NOTHING = "no skill is on"
"""What a drawing says of a moment at which nothing is active."""

_DOT_FONTS = (
    'node [fontname="Helvetica,Arial,sans-serif", margin="0.2,0.06"]',
    'edge [fontname="Helvetica,Arial,sans-serif", fontsize=11]',
)
_DOT_SHAPES = {
    "sensor": "shape=plaintext",
    "skill": "shape=box, style=rounded",
    "event": "shape=box, peripheries=2",
    "arbiter": "shape=diamond",
    "actuator": "shape=plaintext",
}
_MERMAID_SHAPES = {
    "sensor": ("([", "])"),
    "skill": ("(", ")"),
    "event": ("[[", "]]"),
    "arbiter": ("{", "}"),
    "actuator": ("([", "])"),
}


@runtime_checkable
class Networked(Protocol):
    """A world whose network of skills can be drawn."""

    def network(self) -> Drawing:
        """Return the network that is active now; nothing changes by that."""


def draw(runtime: SkillRuntime) -> Drawing:
    """Return the network that is active now."""
    network = runtime.network
    boxes = {channel.name: "sensor" for channel in network.sensors}
    for member in network.order:
        if isinstance(member, Arbitration):
            boxes[member.key] = "arbiter"
        else:
            boxes[member.key] = "event" if is_event(member) else "skill"
    for edge in network.edges:
        boxes.setdefault(edge.end, "actuator")
    made = tuple(Box(key, kind, _label(key, kind)) for key, kind in boxes.items())
    return Drawing(made, tuple(network.edges))


def to_dot(drawing: Drawing) -> str:
    """Return a drawing as a directed graph for Graphviz."""
    lines = ["digraph skills {", "  rankdir=LR;", *map("  {};".format, _DOT_FONTS)]
    if not drawing.boxes:
        lines.append(f"  label={_quoted(_NOTHING)};")
    for box in drawing.boxes:
        shape = _DOT_SHAPES[box.kind]
        lines.append(f"  {_quoted(box.key)} [label={_quoted(box.label)}, {shape}];")
    for edge in drawing.edges:
        style = ", style=dashed" if edge.delayed else ""
        lines.append(
            f"  {_quoted(edge.start)} -> {_quoted(edge.end)} "
            f"[label={_quoted(edge.channel)}{style}];"
        )
    return "\n".join([*lines, "}", ""])


def to_mermaid(drawing: Drawing) -> str:
    """Return a drawing as a Mermaid flowchart."""
    names = {box.key: f"n{number}" for number, box in enumerate(drawing.boxes, 1)}
    lines = ["flowchart LR"]
    if not drawing.boxes:
        lines.append(f'  n0["{_NOTHING}"]')
    for box in drawing.boxes:
        left, right = _MERMAID_SHAPES[box.kind]
        label = box.label.replace('"', "#quot;")
        lines.append(f'  {names[box.key]}{left}"{label}"{right}')
    for edge in drawing.edges:
        arrow = "-.->" if edge.delayed else "-->"
        lines.append(f"  {names[edge.start]} {arrow}|{edge.channel}| {names[edge.end]}")
    return "\n".join([*lines, ""])


def to_json(drawing: Drawing) -> str:
    """Return a drawing as JSON: boxes, and edges between their keys."""
    written = msgspec.json.encode(drawing)
    return msgspec.json.format(written, indent=2).decode() + "\n"


def _label(key: str, kind: str) -> str:
    if kind == "event":
        return key.partition(" of ")[0]
    return key.removesuffix(" (actuator)")


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'
