"""The hallway as a world: its offer, and the simulation behind the port."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from random import Random
from typing import ClassVar

import msgspec

from rapc.base.values import Atom, Fact, Number, Text, number, typed
from rapc.world import Callables, Kit, Option, Picture
from rapc.worlds.hallway import facts, planner
from rapc.worlds.hallway.geometry import (
    far_from,
    heading_to,
    new_x,
    new_y,
    turn_between,
)
from rapc.worlds.hallway.map import Map
from rapc.worlds.hallway.map_text import named_map, read_map
from rapc.worlds.hallway.picture import picture
from rapc.worlds.hallway.random_map import random_map
from rapc.worlds.hallway.robot import SONAR_MODELS, TICK
from rapc.worlds.hallway.simulation import Simulation
from rapc.worlds.hallway.skills.all import catalogue
from rapc.worlds.hallway.state import ODOMETRIES, HallwaySettings
from rapc.worlds.maps import MapError
from rapc.worlds.skills.declarations import Compound, Skill
from rapc.worlds.skills.runtime import EventTold
from rapc.worlds.skills.world import SkillWorld, offer

BUMP = ":bump"

OPTIONS = (
    Option(
        "map", "text", Text("default"), "", "a map of rapc's by name, or one in TOML"
    ),
    Option("random-map", "integer", -1, "", "the seed of a map made at random; -1: no"),
    Option("start", "text", Text(""), "", "the landmark it begins at; else the map's"),
    Option("doors", "number", 120, "s", "how long a door stays open on average; 0: on"),
    Option("people", "integer", 99, "", "how many of the map's people there are"),
    Option("lift", "number", 90, "s", "between calls of the lift by others; 0: none"),
    Option("drift", "number", 1, "", "how much dead reckoning drifts; 1 is usual"),
    Option("usage", "number", 1, "", "how fast the battery is used up; 1 is usual"),
    Option("sonar", "symbol", "ideal", "", "ideal, slant-50, slant-30 or cone"),
    Option("odometry", "symbol", "body", "", "what it measures: body or wheels"),
    Option(
        "careless",
        "number",
        0,
        "",
        "the share of ways on which people do not look",
    ),
)


_OF_THE_PLANE = (turn_between, far_from, new_x, new_y, heading_to)
FUNCTIONS: Callables = {f.__name__.replace("_", "-"): f for f in _OF_THE_PLANE}


class Figures(msgspec.Struct, frozen=True):
    """Ground-truth figures for experiments and tests, hidden from the robot."""

    #: The true space and floor of the robot.
    space: str
    floor: int
    #: The distance driven, in metres.
    distance: Number
    #: Collisions that the robot could avoid, and the highest speed, in metres a second.
    collisions: int
    fastest: Number
    #: The error of dead reckoning, in metres.
    drift: Number
    battery: Number


class HallwayWorld(SkillWorld):
    """A robot in a building, driven by networks of skills.

    The world follows [S].

    Raises:
        ValueError: for an option out of range, or an invalid map.
    """

    name = "hallway"
    ticks_a_unit = round(1 / TICK)
    kit = Kit(
        offer(catalogue(), {BUMP: 0}),
        options=OPTIONS,
        functions=FUNCTIONS,
        solvers={"travel-to-distant-space": planner.plan},
    )

    #: Skills of a subclass: further ones, and others in place of those of their names.
    skills: ClassVar[Sequence[type[Skill] | Compound]] = ()

    def __init_subclass__(cls) -> None:
        """Offer the skills of the subclass."""
        super().__init_subclass__()
        made = catalogue().extended(cls.skills)
        cls.kit = msgspec.structs.replace(cls.kit, offer=offer(made, {BUMP: 0}))

    def __init__(self, rng: Random, options: Mapping[str, Atom | bool]) -> None:
        given = {o.name: o.default for o in OPTIONS} | dict(options)
        self._map = _read_map(given)
        values = {name: given[name] for name in HallwaySettings.__struct_fields__}
        for name, value in values.items():
            if isinstance(value, int | float) and value < 0:
                raise ValueError(f"`{name}` must not be below 0")
        for name, known in (("sonar", SONAR_MODELS), ("odometry", ODOMETRIES)):
            if values[name] not in known:
                listed = ", ".join(f"`{one}`" for one in known)
                raise ValueError(
                    f"unknown `{name}` `{values[name]}`; expected one of {listed}"
                )
        settings = msgspec.convert(values, HallwaySettings)
        if settings.careless > 1:
            raise ValueError("`careless` must not be above 1")
        skills = catalogue(settings.sonar).extended(self.skills)
        self.simulation = Simulation(self._map, skills, rng, settings)
        super().__init__(self.simulation.runtime)

    def facts(self) -> Iterable[Fact]:
        """Return the facts of the map that the robot knows at the start."""
        return facts.map_facts(self._map)

    def tick(self) -> Iterable[EventTold]:
        """Advance the time by a tenth of a second."""
        return self.simulation.tick()

    def ended(self) -> str | None:
        """The reason for the end of the run: an empty battery; None before."""
        left = self.simulation.state.robot.battery
        return "the battery is empty" if left <= 0 else None

    def figures(self) -> Figures:
        """Return the ground-truth figures."""
        state = self.simulation.state
        body, own = state.robot, [c for c in state.collisions if c.what != "push"]
        off = math.hypot(body.x - body.reckoned_x, body.y - body.reckoned_y)
        fastest = max((one.speed for one in own), default=0.0)
        driven, fastest = number(round(body.distance, 2)), number(round(fastest, 3))
        drift, battery = number(round(off, 2)), number(round(body.battery, 1))
        place = state.space, body.floor
        return Figures(*place, driven, len(own), fastest, drift, battery)

    def truth(self) -> Mapping[str, list[Fact]]:
        """Return the robot's space; in a doorway, both spaces of the doorway."""
        found = ("current-space", "robot")
        return {found[0]: [(*found, space) for space in self.simulation.spaces()]}

    @property
    def said(self) -> Sequence[tuple[float, str]]:
        """Return the robot's spoken words so far, each with its time."""
        return tuple(self.simulation.state.said)

    def picture(self) -> Picture:
        """Return the robot's floor in its present state, for `--show`."""
        return picture(self.simulation)

    def save_rest(self) -> bytes:
        """Return the simulation with its skills, as JSON."""
        return self.simulation.save()

    def restore_rest(self, rest: bytes) -> None:
        """Restore a saved simulation.

        Raises:
            ValueError: if the data are invalid or from a hallway with other options.
        """
        self.simulation.restore(rest)


def _read_map(given: Mapping[str, Atom | bool]) -> Map:
    """Return the map of the options, with the start of the options."""
    text, seed, start = given["map"], given["random-map"], given["start"]
    if isinstance(seed, int) and seed >= 0:
        map = random_map(seed)
    else:
        try:
            map = _map_of(typed(text))
        except MapError as error:
            raise ValueError(f"`map`: {error}") from error
    if not (landmark := typed(start)):
        return map
    if landmark not in [mark.name for mark in map.landmark]:
        raise ValueError(f"`start`: no landmark on a wall: `{landmark}`")
    return msgspec.structs.replace(map, start=landmark)


def _map_of(text: str) -> Map:
    """Return the map of a name, or of a TOML text; the two cannot be confused."""
    return read_map(text) if "=" in text or "\n" in text else named_map(text)
