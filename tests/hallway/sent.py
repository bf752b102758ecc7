"""Journeys of the hallway library in the simulated building, and what came of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from random import Random

import msgspec

import rapc
from rapc import events
from rapc.base.values import Atom, Number, Text
from rapc.runtime.events.recorder import Listener
from rapc.runtime.interpreter import Interpreter
from rapc.worlds.hallway import HallwayWorld
from rapc.worlds.hallway.map import Map
from rapc.worlds.hallway.map_text import named_map
from rapc.worlds.hallway.simulation import STANDOFF
from rapc.worlds.hallway.world import Figures
from rapc.worlds.registry import build_world
from tests.hallway.strays import Stray, Strays

STDLIB = Path(__file__).parents[2] / "stdlib" / "hallway"

HONEST: Mapping[str, Atom] = {
    "odometry": "wheels",
    "sonar": "slant-50",
    "careless": 0.2,
}
"""The options of the honest body."""

LATEST = 3000
"""When a journey is given up, in seconds."""


class Journey(msgspec.Struct, frozen=True):
    """A journey, and what came of it."""

    start: str
    goal: str
    succeeded: bool
    #: When the run was over.
    time: Number
    #: The space that the goal hangs in, the one that memory has at the end.
    space: str
    believed: str
    #: The truth at the end.
    truth: Figures
    #: How far the robot is from its place before the goal, in metres.
    away: float
    #: When it was wrong about the space that it was in.
    strays: Sequence[Stray] = ()
    #: The contacts that the robot could not avoid: people ran into it.
    pushes: int = 0
    #: Why the journey failed, if it did.
    because: events.Cause | None = None

    @property
    def arrived(self) -> bool:
        """Whether the robot is where it was to go, and believes so."""
        return self.succeeded and self.truth.space == self.space == self.believed


@cache
def library() -> rapc.CheckedLibrary:
    """Return the hallway library, loaded once."""
    return rapc.load(STDLIB)


def begin(
    seed: int,
    *tasks: str,
    agenda: str = "standing-by",
    options: Mapping[str, Atom | bool] | None = None,
    listeners: Sequence[Listener] = (),
) -> tuple[Interpreter, HallwayWorld]:
    """Return a run that has not begun yet, and its world."""
    world = build_world(HallwayWorld, seed, options or {})
    assert isinstance(world, HallwayWorld)
    run = library().start(
        world, agenda=agenda, tasks=tasks, seed=seed, listeners=listeners
    )
    return run, world


def travel(
    seed: int, map: Map | None = None, options: Mapping[str, Atom | bool] | None = None
) -> Journey:
    """Send the robot from one landmark to another, both drawn by the seed.

    Args:
        seed: the seed of the run, and of what is drawn.
        map: the map that the options ask for, if not the default one.
        options: options of the world.
    """
    map = map or named_map("default")
    start, goal = Random(seed).sample(map.landmark, 2)
    given = {**(options or {}), "start": Text(start.name)}
    run, world = begin(seed, f"(go-to {goal.name}) :at 1", options=given)
    strays = Strays(run, world)
    run.listen(lambda _: None, events.TaskFailed)
    run.run(until=LATEST)
    sent = next(task for task in run.results() if not task.background)
    ((*_, believed),) = run.memory.query("current-space", "robot", None)
    succeeded = sent.outcome == "succeeded"
    return Journey(
        start.name,
        goal.name,
        succeeded,
        run.now,
        goal.space,
        str(believed),
        world.figures(),
        away(world, goal.name, goal.space),
        strays.found,
        sum(c.what == "push" for c in world.simulation.state.collisions),
        sent.because,
    )


def away(world: HallwayWorld, landmark: str, space: str) -> float:
    """Return how far the robot is from its place before a landmark, in metres."""
    sign, body = world.simulation.sign_of(landmark, space), world.simulation.state.robot
    if sign.floor != body.floor:
        return math.inf
    x, y = sign.front(STANDOFF)
    return math.hypot(body.x - x, body.y - y)
