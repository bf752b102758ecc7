"""The movement of the robot's body in a tick: drives, pushes and collisions.

Not here: the slip of the wheels and dead reckoning, see `robot`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from random import Random

from rapc.worlds.hallway import robot
from rapc.worlds.hallway.channels import RADIUS, Drive
from rapc.worlds.hallway.map import Space
from rapc.worlds.hallway.people import GIRTH
from rapc.worlds.hallway.plan import FloorPlan
from rapc.worlds.hallway.robot import TICK, Circle
from rapc.worlds.hallway.state import Collision, HallwayState


def move_robot(
    state: HallwayState,
    drive: Drive | None,
    plan: FloorPlan,
    now: float,
    rng: Random,
    wheels: bool = False,
) -> bool:
    """Move the body by a tick; return whether a new collision happened.

    Args:
        state: the state of the hallway; its robot is moved, and a collision is noted.
        drive: the speeds for the wheels; None without orders.
        plan: the robot's floor.
        now: the time in seconds.
        rng: the stream of the wheels' slip.
        wheels: whether dead reckoning measures only the wheels. Blocked wheels slip
            then, and a movement to the side is not measured.
    """
    body = state.robot
    robot.set_speeds(body, drive if body.battery > 0 else None)
    turned = body.turn * TICK
    vx, vy, pushed = _velocity(state, body.heading + turned / 2, now)
    x, y = body.x + vx * TICK, body.y + vy * TICK
    far, away_x, away_y, what = _touch(x, y, plan, people_around(state))
    towards = -(vx * away_x + vy * away_y)
    bumped, rolled = False, None
    if wheels:
        middle = body.heading + turned / 2
        rolled = (vx * math.cos(middle) + vy * math.sin(middle)) * TICK
    if far < RADIUS and towards > 0:
        bumped = not body.touching
        if not wheels:
            body.speed = 0.0
        elif pushed:
            rolled = 0.0
        if bumped:
            hit = "push" if pushed else what
            state.collisions.append(Collision(now, towards, body.x, body.y, hit))
        x, y = body.x, body.y
    body.touching = far < RADIUS
    robot.move(body, x, y, turned, state.wear, rng, rolled)
    return bumped


def people_around(state: HallwayState) -> list[Circle]:
    """Return the people on the robot's floor."""
    floor = state.robot.floor
    return [(one.x, one.y, GIRTH) for one in state.walkers if one.floor == floor]


def space_under(state: HallwayState, spaces: Sequence[Space]) -> str:
    """Return the space under the robot; in a doorway, the preceding space."""
    body, found = state.robot, state.space
    for space in spaces:
        left, bottom, right, top = space.box
        inside = left <= body.x <= right and bottom <= body.y <= top
        if inside and body.floor in space.floors:
            found = space.name
    return found


def _velocity(
    state: HallwayState, heading: float, now: float
) -> tuple[float, float, bool]:
    """Return the body's speeds to the right and up, and whether the body is pushed."""
    if state.push is not None and now <= state.push.until:
        return state.push.x, state.push.y, True
    state.push = None
    speed = state.robot.speed
    return speed * math.cos(heading), speed * math.sin(heading), False


def _touch(
    x: float, y: float, plan: FloorPlan, people: Sequence[Circle]
) -> tuple[float, float, float, str]:
    """Return the distance and direction of the nearest obstacle, and its kind."""
    far, px, py = plan.nearest(x, y, RADIUS + 0.05)
    what = "wall"
    for cx, cy, radius in people:
        away = math.hypot(cx - x, cy - y) - radius
        if away < far:
            far, px, py, what = away, cx, cy, "person"
    gone = math.hypot(x - px, y - py) or 1.0
    return far, (x - px) / gone, (y - py) / gone, what
