"""Reports to the RAP system: position and battery."""

from __future__ import annotations

from rapc.base.values import Atom
from rapc.worlds.hallway.channels import BATTERY, POSE
from rapc.worlds.skills.declarations import Event, Parameter, Ports, Skill


class Position(Event):
    """Position of the robot by dead reckoning, every second.

    The event follows [S 4.2.1].
    """

    name = "position"
    inputs = (POSE,)
    carries = (
        Parameter("x", "number", "m"),
        Parameter("y", "number", "m"),
        Parameter("heading", "number", "rad"),
    )
    again = 1.0

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return the position, always."""
        pose = ports[POSE]
        return round(pose.x, 2), round(pose.y, 2), round(pose.heading, 3)


class ReportPosition(Skill):
    """Report the position by dead reckoning, every second."""

    name = "report-position"
    inputs = (POSE,)
    events = (Position,)

    def step(self, now: float, ports: Ports) -> None:
        """Do nothing: the event carries the report."""


class BatteryLow(Event):
    """The battery has gone down to a level."""

    name = "battery-low"
    inputs = (BATTERY,)
    carries = (Parameter("level", "number", "%"),)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple if the level is reached, else None."""
        level = ports[BATTERY]
        return (round(level, 1),) if level <= self.arguments["level"] else None


class WatchBattery(Skill):
    """Watch for the battery to go down to a level."""

    name = "watch-battery"
    inputs = (BATTERY,)
    parameters = (Parameter("level", "number", "%", low=0, high=100),)
    events = (BatteryLow,)

    def step(self, now: float, ports: Ports) -> None:
        """Do nothing: the event carries the report."""
