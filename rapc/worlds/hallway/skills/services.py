"""What the robot does besides moving: speaking, charging, calling the lift."""

from __future__ import annotations

import msgspec

from rapc.base.values import Atom, Text
from rapc.worlds.hallway.channels import (
    BATTERY,
    CALL,
    CHARGE,
    CURRENT,
    DONE,
    LIFT,
    VOICE,
)
from rapc.worlds.skills.declarations import Event, Parameter, Ports, Skill

LETTERS = 15
"""Letters that the robot speaks in a second."""

FULL = 99.0
"""The battery is charged, in per cent."""

NO_CONTACT = 2.0
"""Seconds without current after which the robot is not at a charger."""


class Since(msgspec.Struct):
    """When something began."""

    start: float | None = None


class Spoken(Event):
    """The robot has said what it was to say."""

    name = "spoken"
    inputs = (DONE,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Whether the last letter is out."""
        return () if ports[DONE] else None


class Speak(Skill):
    """Say something."""

    name = "speak"
    outputs = (VOICE, DONE)
    parameters = (Parameter("words", "text"),)
    events = (Spoken,)
    uses = ("voice",)
    State = Since
    state: Since

    def step(self, now: float, ports: Ports) -> None:
        """Hand the words over at first, and see when they must be out."""
        words: Text = self.arguments["words"]
        if self.state.start is None:
            self.state.start = now
            ports[VOICE] = words.value
        takes = len(words.value) / LETTERS
        ports[DONE] = now - self.state.start >= takes


class Charged(Event):
    """The battery is full."""

    name = "charged"
    inputs = (BATTERY,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Whether nothing more goes in."""
        return () if ports[BATTERY] >= FULL else None


class NotDocked(Event):
    """There is no current: the robot is not where it can charge."""

    name = "not-docked"
    inputs = (DONE,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Whether the contacts have been without current for some time."""
        return () if ports[DONE] else None


class Charge(Skill):
    """Charge the battery, standing before a charger."""

    name = "charge"
    inputs = (CURRENT, BATTERY)
    outputs = (CHARGE, DONE)
    events = (Charged, NotDocked)
    uses = ("wheels",)
    State = Since
    state: Since

    def step(self, now: float, ports: Ports) -> None:
        """Close the contacts, and see whether there is a current."""
        if self.state.start is None or ports[CURRENT]:
            self.state.start = now
        ports[CHARGE] = True
        ports[DONE] = now - self.state.start >= NO_CONTACT


class LiftHere(Event):
    """The lift stands open at the floor it was called to."""

    name = "lift-here"
    inputs = (LIFT,)
    carries = (Parameter("floor", "number"),)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Whether it has come."""
        floor = self.arguments["floor"]
        return (floor,) if ports[LIFT] == floor else None


class CallLift(Skill):
    """Call the lift to a floor by radio, and hold it there.

    The robot rides by calling the lift to another floor while it stands inside.
    """

    name = "call-lift"
    inputs = (LIFT,)
    outputs = (CALL,)
    parameters = (Parameter("floor", "number"),)
    events = (LiftHere,)
    uses = ("lift-radio",)

    def step(self, now: float, ports: Ports) -> None:
        """Go on calling."""
        ports[CALL] = int(self.arguments["floor"])
