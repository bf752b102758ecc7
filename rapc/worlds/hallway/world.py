"""The hallway as a world: the port on one side, the simulation on the other.

It has skills and no primitives: everything is an activation, and everything it says is
a signal. It cannot say when the next signal comes; `advance` stops at the first.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from random import Random
from typing import NoReturn

import msgspec

from rapc.base.values import Atom, Fact, Number, Text, number
from rapc.world import (
    NOT_KNOWN,
    Callables,
    Kit,
    Offer,
    Option,
    Picture,
    Refused,
    Signal,
    Time,
    World,
)
from rapc.worlds.hallway import facts, planner
from rapc.worlds.hallway.geometry import (
    far_from,
    heading_to,
    new_x,
    new_y,
    turn_between,
)
from rapc.worlds.hallway.map import Map, MapError
from rapc.worlds.hallway.map_text import named_map, read_map
from rapc.worlds.hallway.picture import picture
from rapc.worlds.hallway.random_map import random_map
from rapc.worlds.hallway.robot import TICK
from rapc.worlds.hallway.simulation import HallwaySettings, Simulation
from rapc.worlds.hallway.skills.all import catalogue
from rapc.worlds.skills.catalogue import Catalogue, Request
from rapc.worlds.skills.drawing import Drawing, draw
from rapc.worlds.skills.runtime import Told

PER_SECOND = round(1 / TICK)

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
)


FUNCTIONS: Callables = {
    "turn-between": turn_between,
    "far-from": far_from,
    "new-x": new_x,
    "new-y": new_y,
    "heading-to": heading_to,
}


class Figures(msgspec.Struct, frozen=True):
    """What was true so far, for experiments and tests, never for the robot."""

    #: The space and the floor that the robot is in, in truth.
    space: str
    floor: int
    #: Driven, in metres.
    distance: Number
    #: Collisions the robot could help, and the fastest one's speed in metres a second.
    collisions: int
    fastest: Number
    #: How far dead reckoning is off, in metres.
    drift: Number
    battery: Number


class _Saved(msgspec.Struct):
    now: Number
    sent: list[tuple[str, tuple[Atom, ...], tuple[int, ...]]]
    simulation: msgspec.Raw


def offer(skills: Catalogue) -> Offer:
    """Return what a catalogue offers to libraries, names with their colons."""
    told = {f":{n}": len(event.carries) for n, event in skills.events.items()}
    return Offer(
        skills={f":{n}": len(e.parameters) for n, e in skills.entries.items()},
        events=told | {BUMP: 0},
    )


class HallwayWorld(World):
    """A robot in a building, driven by networks of skills [S].

    Raises:
        ValueError: for an option out of range, or a map that makes no sense.
    """

    name = "hallway"
    kit = Kit(
        offer(catalogue()),
        options=OPTIONS,
        functions=FUNCTIONS,
        solvers={"travel-to-distant-space": planner.plan},
    )

    def __init__(self, rng: Random, options: Mapping[str, Atom | bool]) -> None:
        given = {o.name: o.default for o in OPTIONS} | dict(options)
        self._map = _read_map(given)
        numbers = {}
        for name in ("doors", "people", "lift", "drift", "usage"):
            value = given[name]
            if not isinstance(value, int | float) or value < 0:
                raise ValueError(f"`{name}` must not be below 0")
            numbers[name] = value
        settings = msgspec.convert(numbers, HallwaySettings)
        self.simulation = Simulation(self._map, catalogue(), rng, settings)
        self._now: Number = 0
        self._sent: list[Told] = []

    def facts(self) -> Iterable[Fact]:
        """Return the map, as far as the robot has been told of it."""
        return facts.facts(self._map)

    def now(self) -> Time:
        """Return the time in seconds."""
        return self._now

    def perform(self, ticket: int, request: Fact) -> NoReturn:
        """Refuse: there are no primitives here.

        Raises:
            ValueError: always.
        """
        raise ValueError(f"the hallway has no primitive `{request[0]}`")

    def activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Refused | None:
        """Switch skills on; they run from the next tick.

        Args:
            ticket: the number of the activation from now on.
            skills: what is to run: names with their colons, then arguments.
            events: names of the events to be told, with their colons.

        Returns:
            None, or why not: what it would be in conflict with, by ticket, if that is
            the reason.
        """
        wanted = [Request(str(s[0]).removeprefix(":"), tuple(s[1:])) for s in skills]
        names = [event.removeprefix(":") for event in events]
        return self.simulation.runtime.activate(ticket, wanted, names)

    def deactivate(self, ticket: int) -> None:
        """Switch off what only this activation has."""
        self.simulation.runtime.deactivate(ticket)

    def cancel(self, ticket: int) -> None:
        """Give up an activation: the same as to deactivate it."""
        self.deactivate(ticket)

    def next_time(self) -> Time:
        """Return the present if something has been sent; else it is not known."""
        return self._now if self._sent else NOT_KNOWN

    def advance(self, to: Time) -> None:
        """Let time pass up to `to`, or to the first thing there is to send."""
        simulation = self.simulation
        while not self._sent and simulation.state.ticks + 1 <= to * PER_SECOND + 1e-6:
            self._sent += simulation.tick()
            self._now = max(self._now, number(simulation.now))
        if not self._sent:
            self._now = max(self._now, to)

    def messages(self) -> Sequence[Signal]:
        """Return the signals since the last call, in the order they arose."""
        sent, self._sent = self._sent, []
        return [
            Signal((f":{told.event}", *map(_plain, told.arguments)), told.tickets)
            for told in sent
        ]

    def ended(self) -> str | None:
        """Return why the run is over: an empty battery, nothing else."""
        return "the battery is empty" if self._battery <= 0 else None

    @property
    def _battery(self) -> float:
        return self.simulation.state.robot.battery

    def figures(self) -> Figures:
        """Return what was true so far."""
        state = self.simulation.state
        body, own = state.robot, [c for c in state.collisions if c.what != "push"]
        off = math.hypot(body.x - body.reckoned_x, body.y - body.reckoned_y)
        return Figures(
            state.space,
            body.floor,
            number(round(body.distance, 2)),
            len(own),
            number(round(max((c.speed for c in own), default=0.0), 3)),
            number(round(off, 2)),
            number(round(body.battery, 1)),
        )

    def network(self) -> Drawing:
        """Return the network of skills that is active now, to be drawn."""
        return draw(self.simulation.runtime)

    def picture(self) -> Picture:
        """Return the robot's floor as it is now, for `--show`."""
        return picture(self.simulation)

    def save(self) -> bytes:
        """Return the complete state, as JSON."""
        sent = [(t.event, t.arguments, t.tickets) for t in self._sent]
        simulation = msgspec.Raw(self.simulation.save())
        return msgspec.json.encode(_Saved(self._now, sent, simulation))

    def restore(self, state: bytes) -> None:
        """Take up a saved state, in place.

        Raises:
            ValueError: if it is none, or one of a hallway with other options.
        """
        try:
            saved = msgspec.json.decode(state, type=_Saved)
        except msgspec.DecodeError as error:
            raise ValueError(f"no state of a hallway: {error}") from error
        self.simulation.restore(bytes(saved.simulation))
        self._now = saved.now
        self._sent = [Told(*told) for told in saved.sent]


def _read_map(given: Mapping[str, Atom | bool]) -> Map:
    """Return the map that the options ask for, with the start they ask for."""
    text, seed, start = given["map"], given["random-map"], given["start"]
    if isinstance(seed, int) and seed >= 0:
        map = random_map(seed)
    else:
        try:
            map = _map_of(text.value if isinstance(text, Text) else str(text))
        except MapError as error:
            raise ValueError(f"`map`: {error}") from error
    if not isinstance(start, Text) or not start.value:
        return map
    if start.value not in [mark.name for mark in map.landmark]:
        raise ValueError(f"`start`: no landmark on a wall: `{start.value}`")
    return msgspec.structs.replace(map, start=start.value)


def _map_of(text: str) -> Map:
    """Return the map of a name, or of a text, which no name looks like."""
    return read_map(text) if "=" in text or "\n" in text else named_map(text)


def _plain(value: Atom) -> Atom:
    return number(value) if isinstance(value, int | float) else value
