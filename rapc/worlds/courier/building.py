"""The hospital: rooms along one corridor, and the distances between the rooms.

A position has two coordinates: along the corridor, and depth beside the corridor. The
corridor is at depth 0, every room at `DEPTH`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rapc.base.values import Fact

CORRIDOR = "corridor"
"""The robot's place between two rooms."""

BASE = "base"
"""The room with the dock."""

DEPTH = 2
"""The distance from the corridor to the robot's stop in a room."""

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
"""The coordinate along the corridor and the kind of each room."""

WARDS = tuple(room for room, (_, kind) in ROOMS.items() if kind == "ward")

SOLD: Mapping[str, tuple[str, ...]] = {
    "pharmacy": ("medicine",),
    "kitchen": ("meals",),
    "laundry": ("linen", "medicine"),
}
"""The goods of each store."""


def way_to_room(along: int, depth: int, room: str) -> int:
    """Return the distance from a position to a room that the robot is not in."""
    return depth + abs(ROOMS[room][0] - along) + DEPTH


def passed(along: int, depth: int, room: str, gone: int) -> tuple[int, int]:
    """Return the position after a part of the way to a room."""
    if gone <= depth:
        return along, depth - gone
    ahead = ROOMS[room][0] - along
    straight = min(gone - depth, abs(ahead))
    reached = along + (straight if ahead > 0 else -straight)
    return reached, gone - depth - straight


def building_facts() -> Iterator[Fact]:
    """Yield the facts about the building that the robot knows."""
    for room, (_, kind) in ROOMS.items():
        yield ("room", room, kind)
    for store, goods in SOLD.items():
        for one in goods:
            yield ("gives-out", store, one)
