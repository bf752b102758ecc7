"""The building as a picture for a terminal: spaces, doorways, people, the robot."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rapc.world import Gauge, Picture, Spot
from rapc.worlds.hallway.map import Space
from rapc.worlds.hallway.simulation import Simulation

STEP = 6.0
"""How many metres are a step of the picture."""

POINTS = (
    "east",
    "northeast",
    "north",
    "northwest",
    "west",
    "southwest",
    "south",
    "southeast",
)
"""The points of the compass, counter-clockwise as headings go."""


def sketch(simulation: Simulation) -> Picture:
    """Return the floor that the robot is on; doorways that are closed are left out."""
    state, map = simulation.state, simulation.map
    body, shut = state.robot, simulation.shut()
    spaces = [space for space in map.space if body.floor in space.floors]
    names = {space.name for space in spaces}
    roads = [
        gap.doorway.joins
        for gap in simulation.openings.values()
        if gap.doorway.name not in shut and names.issuperset(gap.doorway.joins)
    ]
    point = POINTS[round(body.heading / (math.pi / 4)) % len(POINTS)]
    believed = ("current-space", "robot")
    return Picture(
        state.space,
        tuple(_spots(simulation, spaces)),
        tuple((one, other) for one, other in roads),
        heading=point,
        gauges=(Gauge("in", state.space, believed),),
    )


def _spots(simulation: Simulation, spaces: list[Space]) -> Iterator[Spot]:
    floor = simulation.state.robot.floor
    walkers = [each for each in simulation.state.walkers if each.floor == floor]
    west = min(space.box[0] for space in spaces)
    north = max(space.box[3] for space in spaces)
    for space in spaces:
        left, bottom, right, top = space.box
        inside = sum(left <= w.x <= right and bottom <= w.y <= top for w in walkers)
        across, down = (left + right) / 2 - west, north - (bottom + top) / 2
        said = {0: "", 1: "somebody"}.get(inside, f"{inside} people")
        yield Spot(space.name, at=(across / STEP, down / STEP), note=said)
