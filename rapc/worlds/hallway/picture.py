"""What is true in the hallway at a moment, as data to be drawn."""

from __future__ import annotations

import math

import msgspec

from rapc.worlds.hallway.channels import DIRECTIONS, SONAR
from rapc.worlds.hallway.map import Box
from rapc.worlds.hallway.plan import door_box
from rapc.worlds.hallway.simulation import Simulation

Point = tuple[float, float]


class Scene(msgspec.Struct, frozen=True):
    """One floor of the building, seen from above, in metres; y points up."""

    floor: int
    #: Spaces by name.
    spaces: tuple[tuple[str, Box], ...]
    #: Gaps in the walls between them.
    gaps: tuple[Box, ...]
    #: Doors that are closed, flat.
    closed: tuple[Box, ...]
    obstacles: tuple[Box, ...]
    #: Landmarks by name, and where they hang.
    landmarks: tuple[tuple[str, Point], ...]
    people: tuple[Point, ...]
    #: Where the robot is, if it is on this floor, and its heading.
    robot: tuple[float, float, float] | None
    #: Where its dead reckoning takes it to be.
    reckoned: tuple[float, float, float] | None
    #: Where the last echoes of its sonars came from; none while nothing listens.
    echoes: tuple[Point, ...]


def scene(simulation: Simulation, floor: int | None = None) -> Scene:
    """Return what is true on a floor, the robot's own if none is given."""
    state, map = simulation.state, simulation.map
    body = state.robot
    floor = body.floor if floor is None else floor
    here = body.floor == floor
    gaps = [gap for gap in simulation.openings.values() if gap.floor == floor]
    shut = simulation.shut()
    return Scene(
        floor,
        tuple((s.name, s.box) for s in map.space if floor in s.floors),
        tuple(gap.box for gap in gaps),
        tuple(door_box(gap) for gap in gaps if gap.doorway.name in shut),
        tuple(box.box for box in map.obstacle if box.floor == floor),
        tuple((s.landmark, (s.x, s.y)) for s in simulation.signs if s.floor == floor),
        tuple((w.x, w.y) for w in state.walkers if w.floor == floor),
        (body.x, body.y, body.heading) if here else None,
        (body.reckoned_x, body.reckoned_y, body.reckoned_heading) if here else None,
        _echoes(simulation) if here else (),
    )


def _echoes(simulation: Simulation) -> tuple[Point, ...]:
    """Return where the echoes of the last tick came from, in the building."""
    body, ranges = simulation.state.robot, simulation.runtime.value(SONAR)
    if ranges is None:
        return ()
    cos, sin = math.cos(body.heading), math.sin(body.heading)
    return tuple(
        (
            body.x + far * (cos * dx - sin * dy),
            body.y + far * (sin * dx + cos * dy),
        )
        for far, (dx, dy) in zip(ranges, DIRECTIONS, strict=True)
    )
