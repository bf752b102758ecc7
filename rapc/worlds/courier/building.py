"""The hospital: rooms along one corridor, and how far it is between them.

A place is how far along the corridor it is, and how deep beside it: the corridor itself
is at depth 0, every room at `DEPTH`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rapc.base.values import Fact

CORRIDOR = "corridor"
"""Where the robot is between two rooms."""

BASE = "base"
"""The room with the dock."""

DEPTH = 2
"""From the corridor to where the robot stops in a room."""

ROOMS: Mapping[str, tuple[int, str]] = {
    "base": (0, "base"),
    "pharmacy": (6, "store"),
    "ward-1": (8, "ward"),
    "kitchen": (14, "store"),
    "ward-2": (16, "ward"),
    "laundry": (20, "store"),
    "ward-3": (24, "ward"),
    "ward-4": (30, "ward"),
}
"""How far along the corridor each room is, and what kind of room it is."""

WARDS = tuple(room for room, (_, kind) in ROOMS.items() if kind == "ward")

SOLD: Mapping[str, tuple[str, ...]] = {
    "pharmacy": ("medicine",),
    "kitchen": ("meals",),
    "laundry": ("linen", "medicine"),
}
"""What each store gives out."""


def way_to_room(along: int, depth: int, room: str) -> int:
    """Return how long the way is from a place to a room that it is not in."""
    return depth + abs(ROOMS[room][0] - along) + DEPTH


def passed(along: int, depth: int, room: str, gone: int) -> tuple[int, int]:
    """The place on the way to a room after so much of it."""
    if gone <= depth:
        return along, depth - gone
    ahead = ROOMS[room][0] - along
    straight = min(gone - depth, abs(ahead))
    reached = along + (straight if ahead > 0 else -straight)
    return reached, gone - depth - straight


def building_facts() -> Iterator[Fact]:
    """Yield what the robot knows of the building."""
    for room, (_, kind) in ROOMS.items():
        yield ("room", room, kind)
    for store, goods in SOLD.items():
        for one in goods:
            yield ("gives-out", store, one)
