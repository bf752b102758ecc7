"""Time in the hallway: one tick after the other, a tenth of a second each.

In a tick people, doors and the lift live, the active skills read what the sensors say,
and the body does what the motors are told; then whatever touches is a collision. All
chance comes from streams made of one; the whole state can be saved and taken up again.
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
from rapc.worlds.hallway.doors import Lift
from rapc.worlds.hallway.map import Map, Opening, Sign, openings, signs
from rapc.worlds.hallway.people import Surroundings
from rapc.worlds.hallway.plan import door_box, floor_plans
from rapc.worlds.hallway.robot import TICK, Robot
from rapc.worlds.hallway.state import Collision, HallwaySettings, HallwayState, Push
from rapc.worlds.skills.catalogue import Catalogue
from rapc.worlds.skills.runtime import EventTold, SkillRuntime

STREAMS = ("wear", "motion", "sonar", "laser", "people", "doors", "lift")

STANDOFF = 1.0
"""How far from a landmark the robot stands when it is at it, in metres."""

DOCKED = 0.35
"""How far from its place at the charger the robot can still charge, in metres."""


class _Saved(msgspec.Struct):
    map: str
    settings: HallwaySettings
    state: HallwayState
    skills: msgspec.Raw
    streams: dict[str, Stream]


class Simulation:
    """A building, its people, and a robot whose skills can be switched on and off.

    Args:
        map: the building.
        catalogue: the robot's skills.
        rng: what all chance is made of.
        settings: what can be chosen.
    """

    def __init__(
        self, map: Map, catalogue: Catalogue, rng: Random, settings: HallwaySettings
    ) -> None:
        self.map = map
        self.settings = settings
        self.signs: Sequence[Sign] = signs(map)
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
        self._close_doors()

    @property
    def now(self) -> float:
        """The time in seconds."""
        return self.state.ticks / round(1 / TICK)

    def tick(self) -> list[EventTold]:
        """Let a tenth of a second pass; return what the robot tells of it, in order.

        A `bump` belongs to no activation.
        """
        state = self.state
        state.ticks += 1
        self._move_doors()
        self._move_lift()
        self._move_people()
        told = self.runtime.tick(self.now, self._sensors)
        state.called = self.runtime.value(CALL)
        self._speak()
        self._charge()
        bumped = self._move_robot()
        return [*told, EventTold("bump", (), ())] if bumped else told

    def push(self, x: float, y: float, seconds: float) -> None:
        """Let somebody push the robot, whatever its motors do.

        Args:
            x: how fast to the right, in metres a second.
            y: how fast upwards.
            seconds: for how long.
        """
        self.state.push = Push(x, y, self.now + seconds)

    def sign_of(self, landmark: str, space: str) -> Sign:
        """Return a landmark as it hangs in a space. Raises KeyError."""
        for sign in self.signs:
            if (sign.landmark, sign.space) == (landmark, space):
                return sign
        raise KeyError(landmark)

    def save(self) -> bytes:
        """Return the complete state, as JSON."""
        streams = {name: stream_state(rng) for name, rng in self._chance.items()}
        skills = msgspec.Raw(self.runtime.save())
        saved = _Saved(self._digest(), self.settings, self.state, skills, streams)
        return msgspec.json.encode(saved)

    def restore(self, saved: bytes) -> None:
        """Take up a state that `save` returned, in place of the present one.

        Raises:
            ValueError: if it is none, or that of another map or other settings;
                nothing has changed then.
        """
        try:
            read = msgspec.json.decode(saved, type=_Saved)
            streams = {name: stream_in(read.streams[name]) for name in STREAMS}
        except (msgspec.DecodeError, KeyError, ValueError) as error:
            raise ValueError(f"no state of a hallway: {error}") from error
        if (read.map, read.settings) != (self._digest(), self.settings):
            raise ValueError("the state is that of a hallway with other options")
        self.runtime.restore(bytes(read.skills))
        self.state, self._chance = read.state, streams
        self._close_doors()

    def _digest(self) -> str:
        return hashlib.sha256(msgspec.json.encode(self.map)).hexdigest()

    def _first_state(self) -> HallwayState:
        start = next(mark for mark in self.map.landmark if mark.name == self.map.start)
        sign = self.sign_of(start.name, start.space)
        x, y = sign.front(STANDOFF)
        heading = math.remainder(sign.normal + math.pi, 2 * math.pi)
        body = Robot(
            x,
            y,
            heading,
            sign.floor,
            reckoned_x=x,
            reckoned_y=y,
            reckoned_heading=heading,
        )
        chance, settings = self._chance, self.settings
        gaps = self.openings.values()
        return HallwayState(
            body,
            robot.worn(chance["wear"], settings.drift),
            people.everybody(self.map)[: settings.people],
            doors.doors(gaps, settings.doors, chance["doors"]),
            doors.lift(self.map, settings.lift, chance["lift"]),
            sign.space,
        )

    def _sonar(self) -> tuple[float, ...]:
        body = self.state.robot
        return robot.sonar(
            body, self.plans[body.floor], self._circles(), self._chance["sonar"]
        )

    def _tags(self) -> tuple[Tag, ...]:
        body = self.state.robot
        return robot.laser(
            body,
            self.plans[body.floor],
            self.signs,
            self._circles(),
            self._chance["laser"],
        )

    def _pose(self) -> Pose:
        return robot.pose(self.state.robot)

    def _battery(self) -> float:
        return self.state.robot.battery

    def _current(self) -> bool:
        return self.state.robot.charging

    def _lift_floor(self) -> int:
        cabin = self.state.lift
        return cabin.floor if cabin is not None and cabin.towards is None else -1

    def _circles(self) -> list[robot.Circle]:
        floor = self.state.robot.floor
        return [
            (walker.x, walker.y, people.GIRTH)
            for walker in self.state.walkers
            if walker.floor == floor
        ]

    def _spots(self) -> list[doors.Spot]:
        body = self.state.robot
        walkers = [(w.floor, w.x, w.y) for w in self.state.walkers]
        return [(body.floor, body.x, body.y), *walkers]

    def _move_people(self) -> None:
        body, rng = self.state.robot, self._chance["people"]
        for walker in self.state.walkers:
            here = (body.x, body.y, RADIUS) if body.floor == walker.floor else None
            people.walk(walker, self._around, here, rng, TICK)

    def _move_doors(self) -> None:
        moved, rng = False, self._chance["doors"]
        for door in self.state.doors:
            if door.changes is not None and self.now >= door.changes:
                gap, every = self.openings[door.doorway], self.settings.doors
                moved |= doors.swing(door, gap, self.now, self._spots(), every, rng)
        if moved:
            self._close_doors()

    def _move_lift(self) -> None:
        cabin, state = self.state.lift, self.state
        if cabin is None:
            return
        inside = state.space == self._cabin
        if cabin.towards is not None:
            if doors.arrive(cabin, self.now):
                if inside:
                    state.robot.floor = cabin.floor
                self._close_doors()
            return
        called = state.called
        if called is not None:
            cabin.free_from = self.now + doors.DWELL
            if called != cabin.floor and called in self.plans:
                self._send(cabin, called)
        elif cabin.wanted is not None and self.now >= cabin.wanted:
            rng = self._chance["lift"]
            if self.now >= cabin.free_from and not inside:
                other = rng.choice([f for f in sorted(self.plans) if f != cabin.floor])
                self._send(cabin, other)
            cabin.wanted = self.now + rng.expovariate(1 / self.settings.lift)

    def _send(self, cabin: Lift, floor: int) -> None:
        """Let the cabin go, unless somebody stands in its door."""
        gaps = [g for g in self.openings.values() if self._cabin in g.doorway.joins]
        if not any(doors.occupied(gap, self._spots()) for gap in gaps):
            doors.send(cabin, floor, self.now)
            self._close_doors()

    @property
    def _cabin(self) -> str:
        return next(space.name for space in self.map.space if space.kind == "lift")

    def shut(self) -> frozenset[str]:
        """Return the doorways whose doors are closed now, the lift's among them."""
        closed = {door.doorway for door in self.state.doors if door.closed}
        cabin = self.state.lift
        if cabin is not None:
            closed |= {
                name
                for name, gap in self.openings.items()
                if self._cabin in gap.doorway.joins
                and (cabin.towards is not None or gap.floor != cabin.floor)
            }
        return frozenset(closed)

    def _close_doors(self) -> None:
        """Let the plans have the doors that are closed now."""
        closed = sorted(self.shut())
        for floor, plan in self.plans.items():
            gaps = (self.openings[name] for name in closed)
            plan.close([door_box(gap) for gap in gaps if gap.floor == floor])

    def _speak(self) -> None:
        text = self.runtime.value(VOICE)
        if text:
            self.state.said.append((self.now, text))

    def _charge(self) -> None:
        state, body = self.state, self.state.robot
        body.charging = bool(self.runtime.value(CHARGE)) and any(
            mark.charger and self._docked(self.sign_of(mark.name, mark.space))
            for mark in self.map.landmark
        )
        robot.drain(state.robot, self.settings.usage)

    def _docked(self, sign: Sign) -> bool:
        body = self.state.robot
        x, y = sign.front(STANDOFF)
        away = math.hypot(body.x - x, body.y - y)
        return body.floor == sign.floor and away <= DOCKED

    def _move_robot(self) -> bool:
        """Move the body by a tick; return whether it has come to touch something."""
        body = self.state.robot
        drive = self.runtime.value(DRIVE) if body.battery > 0 else None
        robot.set_speeds(body, drive)
        turned = body.turn * TICK
        vx, vy, pushed = self._velocity(body.heading + turned / 2)
        x, y = body.x + vx * TICK, body.y + vy * TICK
        far, away_x, away_y, what = self._touch(x, y)
        towards = -(vx * away_x + vy * away_y)
        bumped = False
        if far < RADIUS and towards > 0:
            bumped = not body.touching
            self._collide(bumped, towards, "push" if pushed else what)
            x, y = body.x, body.y
        body.touching = far < RADIUS
        robot.move(body, x, y, turned, self.state.wear, self._chance["motion"])
        self._find_space()
        return bumped

    def _velocity(self, heading: float) -> tuple[float, float, bool]:
        """Return the body's speeds to the right and up, and whether it is pushed."""
        state = self.state
        if state.push is not None and self.now > state.push.until:
            state.push = None
        if state.push is not None:
            return state.push.x, state.push.y, True
        speed = state.robot.speed
        return speed * math.cos(heading), speed * math.sin(heading), False

    def _collide(self, new: bool, speed: float, what: str) -> None:
        body = self.state.robot
        body.speed = 0.0
        if new:
            self.state.collisions.append(
                Collision(self.now, speed, body.x, body.y, what)
            )

    def _touch(self, x: float, y: float) -> tuple[float, float, float, str]:
        """The nearest thing: its distance, the way from it to the robot, its kind."""
        far, px, py = self.plans[self.state.robot.floor].nearest(x, y, RADIUS + 0.05)
        what = "wall"
        for cx, cy, radius in self._circles():
            away = math.hypot(cx - x, cy - y) - radius
            if away < far:
                far, px, py, what = away, cx, cy, "person"
        gone = math.hypot(x - px, y - py) or 1.0
        return far, (x - px) / gone, (y - py) / gone, what

    def _find_space(self) -> None:
        """Note the space under the robot; in a doorway it is the one before."""
        body = self.state.robot
        for space in self.map.space:
            left, bottom, right, top = space.box
            if (
                left <= body.x <= right
                and bottom <= body.y <= top
                and body.floor in space.floors
            ):
                self.state.space = space.name
