"""Skills besides moving: speaking, charging, calling the lift."""

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
"""The speed of speech, in letters a second."""

FULL = 99.0
"""The charge of a full battery, in per cent."""

NO_CONTACT = 2.0
"""Seconds without current after which the robot is not at a charger."""


class Since(msgspec.Struct):
    """The start time of a process."""

    start: float | None = None


class Spoken(Event):
    """The robot has spoken the words."""

    name = "spoken"
    inputs = (DONE,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple after the last letter, else None."""
        return () if ports[DONE] else None


class Speak(Skill):
    """Speak some words."""

    name = "speak"
    outputs = (VOICE, DONE)
    parameters = (Parameter("words", "text"),)
    events = (Spoken,)
    uses = ("voice",)
    State = Since
    state: Since

    def step(self, now: float, ports: Ports) -> None:
        """Start the speech at first, and compute its end."""
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
        """Return an empty tuple if the battery is full, else None."""
        return () if ports[BATTERY] >= FULL else None


class NotDocked(Event):
    """No current: the robot does not stand at a charger."""

    name = "not-docked"
    inputs = (DONE,)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple after some time without current, else None."""
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
        """Close the contacts, and check the current."""
        if self.state.start is None or ports[CURRENT]:
            self.state.start = now
        ports[CHARGE] = True
        ports[DONE] = now - self.state.start >= NO_CONTACT


class LiftHere(Event):
    """The lift stands open at the requested floor."""

    name = "lift-here"
    inputs = (LIFT,)
    carries = (Parameter("floor", "number"),)

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        """Return an empty tuple if the lift has come, else None."""
        floor = self.arguments["floor"]
        return (floor,) if ports[LIFT] == floor else None


class CallLift(Skill):
    """Call the lift to a floor by radio, and hold the lift there.

    The robot rides by calling the lift to another floor while it stands inside.
    """

    name = "call-lift"
    inputs = (LIFT,)
    outputs = (CALL,)
    parameters = (Parameter("floor", "number"),)
    events = (LiftHere,)
    uses = ("lift-radio",)

    def step(self, now: float, ports: Ports) -> None:
        """Keep calling."""
        ports[CALL] = int(self.arguments["floor"])
