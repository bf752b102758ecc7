"""Time in the hallway, in ticks of a tenth of a second.

In a tick, people, doors and the lift move, the active skills read the sensors, and the
body follows the motors' orders; then contacts are recorded as collisions. All random
streams come from one stream, and the complete state can be saved and restored. Doors
and lift move in `doors`, the body in `driving`, people in `people`.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from random import Random
from typing import Any

import msgspec

from rapc.base.chance import Stream, stream_in, stream_state
from rapc.worlds.hallway import doors, people, robot
from rapc.worlds.hallway.channels import (
    BATTERY,
    CALL,
    CHARGE,
    CURRENT,
    DRIVE,
    LIFT,
    POSE,
    RADIUS,
    SONAR,
    TAGS,
    VOICE,
    Pose,
    Tag,
)
from rapc.worlds.hallway.doors import Entrances
from rapc.worlds.hallway.driving import move_robot, people_around, space_under
from rapc.worlds.hallway.map import Map, Opening, Sign, openings, signs
from rapc.worlds.hallway.people import Surroundings
from rapc.worlds.hallway.plan import floor_plans
from rapc.worlds.hallway.robot import TICK, Robot
from rapc.worlds.hallway.state import (
    Collision,
    HallwaySettings,
    HallwayState,
    Push,
)
from rapc.worlds.skills.catalogue import Catalogue
from rapc.worlds.skills.runtime import EventTold, SkillRuntime
from rapc.worlds.states import reading_state

STREAMS = ("wear", "motion", "sonar", "laser", "people", "doors", "lift")

STANDOFF = 1.0
"""The distance between a landmark and a robot at that landmark, in metres."""

DOORWAY = 0.9
"""The reach of a doorway from its middle, in metres: the robot is in both spaces."""

DOCKED = 0.35
"""The maximum distance from the place at the charger for charging, in metres."""


class _Saved(msgspec.Struct):
    map: str
    settings: HallwaySettings
    state: HallwayState
    skills: msgspec.Raw
    streams: dict[str, Stream]


class Simulation:
    """A building, its people, and a robot whose skills are enabled and disabled.

    Args:
        map: the building.
        catalogue: the robot's skills.
        rng: the stream of random numbers.
        settings: the options of the run.
    """

    def __init__(
        self, map: Map, catalogue: Catalogue, rng: Random, settings: HallwaySettings
    ) -> None:
        self.map = map
        self.settings = settings
        self.signs: Sequence[Sign] = signs(map)
        self._signs = {(sign.landmark, sign.space): sign for sign in self.signs}
        self.plans = floor_plans(map)
        self.openings: Mapping[str, Opening] = {
            gap.doorway.name: gap for gap in openings(map)
        }
        self.runtime = SkillRuntime(catalogue)
        root = rng.getrandbits(64)
        self._chance = {name: Random(f"{root}:{name}") for name in STREAMS}
        self.state = self._first_state()
        self._around = Surroundings(map, self.plans, tuple(self.openings.values()))
        # Methods, no lambdas: a copy of the simulation must read its own state.
        self._sensors: dict[str, Callable[[], Any]] = {
            SONAR.name: self._sonar,
            POSE.name: self._pose,
            TAGS.name: self._tags,
            BATTERY.name: self._battery,
            CURRENT.name: self._current,
            LIFT.name: self._lift_floor,
        }
        self._entrances = Entrances(map, self.plans, self.openings, settings)
        self._entrances.close(self.state)

    @property
    def now(self) -> float:
        """The time in seconds."""
        return self.state.ticks / round(1 / TICK)

    def tick(self) -> list[EventTold]:
        """Advance the time by a tick; return the robot's events, in order.

        A `bump` belongs to no activation.
        """
        state = self.state
        state.ticks += 1
        self._entrances.move_doors(state, self.now, self._chance["doors"])
        self._entrances.move_lift(state, self.now, self._chance["lift"])
        pushed = self._move_people()
        told = self.runtime.tick(self.now, self._sensors)
        state.called = self.runtime.value(CALL)
        if text := self.runtime.value(VOICE):
            state.said.append((self.now, text))
        self._charge()
        drive, plan = self.runtime.value(DRIVE), self.plans[state.robot.floor]
        wheels, rng = self.settings.odometry == "wheels", self._chance["motion"]
        bumped = move_robot(state, drive, plan, self.now, rng, wheels)
        state.space = space_under(state, self.map.space)
        return [*told, EventTold("bump", (), ())] if bumped or pushed else told

    def spaces(self) -> list[str]:
        """Return the robot's space, and the spaces joined by a doorway around it."""
        body = self.state.robot
        near = [
            space
            for gap in self.openings.values()
            if gap.floor == body.floor
            and abs(body.x - (gap.box[0] + gap.box[2]) / 2) < DOORWAY
            and abs(body.y - (gap.box[1] + gap.box[3]) / 2) < DOORWAY
            for space in gap.doorway.joins
        ]
        return list(dict.fromkeys([self.state.space, *near]))

    def push(self, x: float, y: float, seconds: float) -> None:
        """Push the robot, whatever its motors do.

        Args:
            x: the speed to the right, in metres a second.
            y: the speed upwards.
            seconds: the duration.
        """
        self.state.push = Push(x, y, self.now + seconds)

    def sign_of(self, landmark: str, space: str) -> Sign:
        """Return a landmark's tags in a space. Raises KeyError."""
        return self._signs[landmark, space]

    def save(self) -> bytes:
        """Return the complete state, as JSON."""
        streams = {name: stream_state(rng) for name, rng in self._chance.items()}
        skills = msgspec.Raw(self.runtime.save())
        saved = _Saved(self._digest(), self.settings, self.state, skills, streams)
        return msgspec.json.encode(saved)

    def restore(self, saved: bytes) -> None:
        """Restore a state that `save` returned.

        Raises:
            ValueError: if the state is invalid, or from another map or other settings;
            the
                simulation is unchanged then.
        """
        with reading_state("a hallway"):
            read = msgspec.json.decode(saved, type=_Saved)
            streams = {name: stream_in(read.streams[name]) for name in STREAMS}
        if (read.map, read.settings) != (self._digest(), self.settings):
            raise ValueError("the state is that of a hallway with other options")
        with reading_state("a hallway"):
            self._check(read.state)
        self.runtime.restore(bytes(read.skills))
        self.state, self._chance = read.state, streams
        self._entrances.close(self.state)

    def _check(self, state: HallwayState) -> None:
        """Validate that all places of a state are on this map; raise ValueError."""
        spaces = {space.name for space in self.map.space}
        people, lift, mine = state.walkers, state.lift, self.state
        floors = {state.robot.floor, *(walker.floor for walker in people)}
        if lift is not None:
            floors |= {lift.floor, lift.floor if lift.towards is None else lift.towards}
        known = (
            floors <= self.plans.keys()
            and spaces.issuperset(walker.space for walker in people)
            and {*spaces, ""}.issuperset(walker.towards for walker in people)
            and len(people) == len(mine.walkers)
            and [one.doorway for one in state.doors] == [d.doorway for d in mine.doors]
            and (lift is None) == (mine.lift is None)
        )
        if not known:
            raise ValueError("a place is unknown")

    def _digest(self) -> str:
        return hashlib.sha256(msgspec.json.encode(self.map)).hexdigest()

    def _first_state(self) -> HallwayState:
        start = next(mark for mark in self.map.landmark if mark.name == self.map.start)
        sign = self.sign_of(start.name, start.space)
        x, y = sign.front(STANDOFF)
        heading = math.remainder(sign.normal + math.pi, 2 * math.pi)
        chance, settings = self._chance, self.settings
        gaps = self.openings.values()
        return HallwayState(
            Robot(x, y, heading, sign.floor, 0.0, 0.0, x, y, heading),
            robot.worn(chance["wear"], settings.drift),
            people.everybody(self.map)[: settings.people],
            doors.doors(gaps, settings.doors, chance["doors"]),
            doors.lift(self.map, settings.lift, chance["lift"]),
            sign.space,
        )

    def _sonar(self) -> tuple[float, ...]:
        body, around = self.state.robot, people_around(self.state)
        plan, rng = self.plans[body.floor], self._chance["sonar"]
        model = robot.SONAR_MODELS[self.settings.sonar]
        return robot.sonar(body, plan, around, rng, model)

    def _tags(self) -> tuple[Tag, ...]:
        body, around = self.state.robot, people_around(self.state)
        plan, rng = self.plans[body.floor], self._chance["laser"]
        return robot.laser(body, plan, self.signs, around, rng)

    def _pose(self) -> Pose:
        return robot.pose(self.state.robot)

    def _battery(self) -> float:
        return self.state.robot.battery

    def _current(self) -> bool:
        return self.state.robot.charging

    def _lift_floor(self) -> int:
        cabin = self.state.lift
        return cabin.floor if cabin is not None and cabin.towards is None else -1

    def _move_people(self) -> bool:
        """Move the people; return whether a person runs into the robot."""
        body, rng, pushed = self.state.robot, self._chance["people"], False
        careless = self.settings.careless
        for walker in self.state.walkers:
            here = (body.x, body.y, RADIUS) if body.floor == walker.floor else None
            if people.walk(walker, self._around, here, rng, TICK, careless):
                pushed = True
                x, y = body.x - walker.x, body.y - walker.y
                pace = walker.speed / math.hypot(x, y)
                self.push(pace * x, pace * y, people.SHOVE)
                hit = Collision(self.now, walker.speed, body.x, body.y, "push")
                self.state.collisions.append(hit)
        return pushed

    def shut(self) -> frozenset[str]:
        """Return the doorways with a closed door, the lift's included."""
        return self._entrances.shut(self.state)

    def _charge(self) -> None:
        body = self.state.robot
        chargers = [mark for mark in self.map.landmark if mark.charger]
        body.charging = bool(self.runtime.value(CHARGE)) and any(
            self._docked(self.sign_of(mark.name, mark.space)) for mark in chargers
        )
        robot.drain(body, self.settings.usage)

    def _docked(self, sign: Sign) -> bool:
        body = self.state.robot
        x, y = sign.front(STANDOFF)
        away = math.hypot(body.x - x, body.y - y)
        return body.floor == sign.floor and away <= DOCKED
