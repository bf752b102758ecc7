"""Scripted controllers: skills switched on and off by hand, without any RAP."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from random import Random

import msgspec

from rapc.base.values import Atom
from rapc.worlds.hallway.map import Map, Sign
from rapc.worlds.hallway.map_text import named_map
from rapc.worlds.hallway.simulation import STANDOFF, Simulation
from rapc.worlds.hallway.skills.all import catalogue
from rapc.worlds.hallway.state import HallwaySettings
from rapc.worlds.skills.catalogue import SkillRequest
from rapc.worlds.skills.runtime import EventTold

STILL = HallwaySettings(doors=0, people=0, lift=0, drift=0, usage=0)
"""Nothing moves but the robot, which reckons well."""

NORTH, EAST, SOUTH, WEST = math.pi / 2, 0.0, -math.pi / 2, math.pi
"""Headings, in radians."""


class Outcome(msgspec.Struct):
    """What came of an activation."""

    event: str
    arguments: tuple[Atom, ...]
    seconds: float


class Driver:
    """A robot in a simulation, and the activations that drive it."""

    def __init__(
        self, seed: int = 0, settings: HallwaySettings = STILL, map: Map | None = None
    ) -> None:
        self.sim = Simulation(
            map or named_map("default"),
            catalogue(settings.sonar),
            Random(seed),
            settings,
        )
        self.ticket = 0
        #: Everything told, with its time.
        self.heard: list[tuple[float, EventTold]] = []

    def on(self, *requests: SkillRequest, events: Iterable[str] = ()) -> int:
        """Switch skills on; return the ticket."""
        self.ticket += 1
        refused = self.sim.runtime.activate(self.ticket, requests, events)
        assert refused is None, refused
        return self.ticket

    def off(self, ticket: int) -> None:
        """Switch an activation off."""
        self.sim.runtime.deactivate(ticket)

    def tick(self, ticks: int = 1) -> list[EventTold]:
        """Let ticks pass; return what was told in the last one."""
        told: list[EventTold] = []
        for _ in range(ticks):
            told = self.sim.tick()
            self.heard += ((self.sim.now, one) for one in told)
        return told

    def until(
        self, *requests: SkillRequest, events: Collection[str], within: float = 300
    ) -> Outcome:
        """Keep skills on until one of the events is told, then off.

        The outcome is `timeout` if none is told within so many seconds.
        """
        ticket, start = self.on(*requests, events=events), self.sim.now
        outcome = Outcome("timeout", (), within)
        while self.sim.now - start < within:
            for told in self.tick():
                if ticket in told.tickets and told.event in events:
                    seconds = self.sim.now - start
                    self.off(ticket)
                    return Outcome(told.event, told.arguments, seconds)
        self.off(ticket)
        return outcome

    def place(self, x: float, y: float, heading: float, floor: int = 1) -> None:
        """Put the robot somewhere, and let it know."""
        body = self.sim.state.robot
        body.x, body.y, body.heading, body.floor = x, y, heading, floor
        body.reckoned_x, body.reckoned_y, body.reckoned_heading = x, y, heading
        body.speed = body.turn = 0.0
        self.sim.state.space = next(
            space.name
            for space in self.sim.map.space
            if floor in space.floors
            and space.box[0] <= x <= space.box[2]
            and space.box[1] <= y <= space.box[3]
        )

    def place_at(self, landmark: str, space: str) -> Sign:
        """Put the robot in its place before a landmark; return the landmark."""
        sign = self.sim.sign_of(landmark, space)
        x, y = sign.front(STANDOFF)
        self.place(x, y, math.remainder(sign.normal + math.pi, math.tau), sign.floor)
        return sign

    def fastest_collision(self) -> float:
        """How fast the robot ever ran into anything by itself."""
        return max(
            (c.speed for c in self.sim.state.collisions if c.what != "push"),
            default=0.0,
        )

    def off_place(self, sign: Sign) -> float:
        """How far the robot is from its place before a landmark, in metres."""
        x, y = sign.front(STANDOFF)
        body = self.sim.state.robot
        return math.hypot(body.x - x, body.y - y)


def to_landmark(
    sign: Sign, standoff: float = STANDOFF, speed: float = 0.5
) -> SkillRequest:
    """The skill that goes to a landmark."""
    left, right = sign.tags
    arguments = (sign.landmark, left, right, sign.apart, standoff, speed)
    return SkillRequest("move-to-landmark", arguments)


def watch(sign: Sign) -> SkillRequest:
    """The skill that watches for a landmark."""
    left, right = sign.tags
    arguments = (sign.landmark, left, right, sign.apart)
    return SkillRequest("watch-for-landmark", arguments)


FOLLOW_HALL = (
    SkillRequest("detect-obstacles"),
    SkillRequest("track-hallway"),
    SkillRequest("follow-trajectory"),
)
