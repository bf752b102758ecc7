"""The building as a picture: its spaces, and the robot's floor true to scale.

The picture names the facts of memory that hold the robot's beliefs. Some facts come
from the world at the start (`rapc.worlds.hallway.facts`). stdlib/hallway declares the
fact `found-closed`; in a library without this fact no door is believed closed. The page
docs/libraries/hallway.md names the same facts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from rapc.base.pictures import (
    DIRECTIONS,
    Area,
    Door,
    Gauge,
    Mark,
    Picture,
    Plan,
    Point,
    Reckoning,
    Spot,
    Stand,
)
from rapc.worlds.hallway import channels
from rapc.worlds.hallway.channels import SONAR
from rapc.worlds.hallway.map import Space, middle
from rapc.worlds.hallway.plan import outlines
from rapc.worlds.hallway.planner import REMEMBERED
from rapc.worlds.hallway.simulation import STANDOFF, Simulation

STEP = 6.0
"""The length of a step of the picture, in metres."""

READ = 3.0
"""The time that spoken words stay in the picture, in seconds."""

_SPACE = ("current-space", "robot")
"""The fact, without its value, that holds the robot's space in memory."""


def picture(simulation: Simulation) -> Picture:
    """Return the picture of the robot's floor; closed doorways are left out."""
    state, map = simulation.state, simulation.map
    body, shut = state.robot, simulation.shut()
    spaces = [space for space in map.space if body.floor in space.floors]
    names = {space.name for space in spaces}
    roads = [
        gap.doorway.joins
        for gap in simulation.openings.values()
        if gap.doorway.name not in shut and names.issuperset(gap.doorway.joins)
    ]
    point = DIRECTIONS[(2 - round(body.heading / (math.pi / 4))) % len(DIRECTIONS)]
    return Picture(
        state.space,
        tuple(_spots(simulation, spaces)),
        tuple((one, other) for one, other in roads),
        heading=point,
        gauges=(Gauge("in", state.space, _SPACE),),
        plan=floor_plan(simulation, body.floor),
        said=_said(simulation),
    )


def _said(simulation: Simulation) -> str:
    """Return the robot's last words, while the words can still be read."""
    said = simulation.state.said
    if not said or simulation.now - said[-1][0] > READ:
        return ""
    return said[-1][1]


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


def floor_plan(simulation: Simulation, floor: int) -> Plan:
    """Return a floor in its present state, true to scale."""
    state, map = simulation.state, simulation.map
    body, spaces = state.robot, [s for s in map.space if floor in s.floors]
    gaps = [gap for gap in simulation.openings.values() if gap.floor == floor]
    upright, level = outlines([s.box for s in spaces] + [gap.box for gap in gaps])
    walls = [((x, low), (x, high)) for x, low, high in upright]
    walls += [((low, y), (high, y)) for y, low, high in level]
    here = body.floor == floor
    return Plan(
        tuple(Area(space.name, space.box) for space in spaces),
        tuple(walls),
        tuple(box.box for box in map.obstacle if box.floor == floor),
        tuple(_doors(simulation, floor)),
        tuple(_marks(simulation, floor)),
        tuple((w.x, w.y) for w in state.walkers if w.floor == floor),
        (body.x, body.y, body.heading) if here else None,
        _echoes(simulation) if here else (),
        _reckoning(simulation, floor),
    )


def _marks(simulation: Simulation, floor: int) -> Iterator[Mark]:
    """Yield the landmarks, each with its fact in memory."""
    for sign in simulation.signs:
        if sign.floor == floor:
            known = ("location-data", sign.landmark, None, None, None, None)
            yield Mark(sign.landmark, (sign.x, sign.y), known)


def _doors(simulation: Simulation, floor: int) -> Iterator[Door]:
    shut = simulation.shut()
    for name, gap in simulation.openings.items():
        if gap.floor == floor:
            fact = ("found-closed", name)
            yield Door(name, middle(gap.box), name in shut, fact, REMEMBERED)


def _reckoning(simulation: Simulation, floor: int) -> Reckoning:
    stands = []
    for sign in simulation.signs:
        if sign.floor == floor:
            facing = math.remainder(sign.normal + math.pi, math.tau)
            pose = (*sign.front(STANDOFF), facing)
            stands.append(Stand(sign.landmark, sign.space, pose))
    return Reckoning(("orientation", "robot"), ("base",), _SPACE, tuple(stands))


def _echoes(simulation: Simulation) -> tuple[Point, ...]:
    """Return the sources of the last tick's echoes; empty if no skill listens."""
    body, ranges = simulation.state.robot, simulation.runtime.value(SONAR)
    if ranges is None:
        return ()
    cos, sin = math.cos(body.heading), math.sin(body.heading)
    return tuple(
        (body.x + far * (cos * dx - sin * dy), body.y + far * (sin * dx + cos * dy))
        for far, (dx, dy) in zip(ranges, channels.DIRECTIONS, strict=True)
    )
