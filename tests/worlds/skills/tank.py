"""A small world for networks: a tank whose level skills hold by a valve."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec

from rapc.base.values import Atom
from rapc.worlds.skills.catalogue import Catalogue
from rapc.worlds.skills.declarations import (
    Arbiter,
    Channel,
    Compound,
    Event,
    Input,
    Parameter,
    Ports,
    Skill,
)
from rapc.worlds.skills.runtime import SkillRuntime

LEVEL = Channel("level", float, "m", "how high the water stands")
SMOOTH = Channel("smooth-level", float, "m", "the level without its waves")
GOAL = Channel("goal", float, "m", "the level wanted")
FLOW = Channel("flow", float, "m/s", "what the valve lets in")
LIMIT = Channel("limit", float, "m/s", "the most that may flow")
GAP = Channel("gap", float, "m", "how much is wanted", own=True)


class Sum(msgspec.Struct):
    """What a smoothing skill remembers."""

    value: float | None = None


class Smooth(Skill):
    """Take the waves off the level."""

    name = "smooth"
    inputs = (LEVEL,)
    outputs = (SMOOTH,)
    State = Sum
    state: Sum

    def step(self, now: float, ports: Ports) -> None:
        level, before = ports[LEVEL], self.state.value
        self.state.value = level if before is None else before + (level - before) / 2
        ports[SMOOTH] = self.state.value


class Reached(Event):
    """The level is near the goal."""

    name = "reached"
    inputs = (GAP, SMOOTH)
    carries = (Parameter("level", "number", "m"),)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        level, gap = ports[SMOOTH], ports[GAP]
        return (round(level, 2),) if abs(gap) < 0.1 else None


class Aim(Skill):
    """Say which level is wanted."""

    name = "aim"
    inputs = (SMOOTH,)
    outputs = (GOAL, GAP)
    parameters = (Parameter("height", "number", "m", low=0, high=10),)
    events = (Reached,)

    def step(self, now: float, ports: Ports) -> None:
        height = float(self.arguments["height"])
        ports[GOAL] = height
        ports[GAP] = height - ports[SMOOTH]


class Fill(Skill):
    """Open the valve as far as the goal asks for."""

    name = "fill"
    inputs = (SMOOTH, GOAL, Input(LIMIT, optional=True))
    outputs = (FLOW,)
    uses = ("valve",)

    def step(self, now: float, ports: Ports) -> None:
        limit = ports.get(LIMIT)
        most = 1.0 if limit is None else limit
        ports[FLOW] = max(-most, min(most, ports[GOAL] - ports[SMOOTH]))


class LimitFlow(Skill):
    """Let no more than this through the valve."""

    name = "limit-flow"
    outputs = (LIMIT,)
    parameters = (Parameter("most", "number", "m/s"),)

    def step(self, now: float, ports: Ports) -> None:
        ports[LIMIT] = float(self.arguments["most"])


class High(Event):
    """The water stands above a mark, told again every two seconds."""

    name = "high"
    inputs = (LEVEL,)
    again = 2.0

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        return () if ports[LEVEL] > float(self.arguments["mark"]) else None


class Watch(Skill):
    """Watch for a mark."""

    name = "watch"
    inputs = (LEVEL,)
    parameters = (Parameter("mark", "number", "m"),)
    events = (High,)

    def step(self, now: float, ports: Ports) -> None:
        assert ports[LEVEL] >= 0


class LowestLimit(Arbiter):
    """The lowest limit holds."""

    channel = LIMIT

    def decide(self, values: list[Any]) -> Any:
        return min(values)


HOLD = Compound("hold", (Smooth, Aim, Fill), Aim.parameters, "Hold a level.")


def catalogue() -> Catalogue:
    """The skills of the tank."""
    skills = (Smooth, Aim, Fill, LimitFlow, Watch, HOLD)
    return Catalogue(skills, (LEVEL,), (FLOW,), (LowestLimit(),))


class Tank:
    """The water, and the skills that see to it; ten ticks are a second."""

    def __init__(self) -> None:
        self.level, self.ticks = 0.0, 0
        self.runtime = SkillRuntime(catalogue())
        self.sensors: dict[str, Callable[[], Any]] = {"level": lambda: self.level}
        self.heard: list[tuple[float, str, tuple[int, ...]]] = []

    def run(self, ticks: int) -> None:
        """Let so many ticks pass."""
        for _ in range(ticks):
            self.ticks += 1
            now = self.ticks / 10
            for told in self.runtime.tick(now, self.sensors):
                self.heard.append((now, told.event, told.tickets))
            self.level += (self.runtime.value(FLOW) or 0.0) / 10
