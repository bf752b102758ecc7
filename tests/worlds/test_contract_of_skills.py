"""The contract of worlds with skills: each way to break it is found."""

from __future__ import annotations

import random
import re
from collections.abc import Iterable, Sequence
from typing import Any

import pytest

from rapc.base.values import Atom
from rapc.testing.contract.trials import SKILLS, try_world
from rapc.world import Fact, Kit, Offer, Refused, Signal, World
from rapc.worlds.skills.catalogue import Catalogue
from rapc.worlds.skills.declarations import Ports, Skill
from rapc.worlds.skills.runtime import EventTold, SkillRuntime
from rapc.worlds.skills.world import SkillWorld, offer
from tests.worlds.broken_worlds import Good
from tests.worlds.skills.tank import (
    FLOW,
    LEVEL,
    SMOOTH,
    Aim,
    Fill,
    LimitFlow,
    LowestLimit,
    Reached,
    Smooth,
)
from tests.worlds.skills.test_world import Water


class Humming(Good):
    """A world with skills that hum with every step of time as long as they are on."""

    kit = Kit(Offer(skills={":hum": 1, ":rest": 0}, events={":hummed": 0}))

    def __init__(self, rng: Any, options: Any) -> None:
        super().__init__(rng, options)
        self.on: list[int] = []
        self.sent: Any = []

    def activate(
        self, ticket: int, skills: Sequence[Fact], events: Sequence[str]
    ) -> Any:
        if len(skills) > 1 and self.on:
            return Refused((self.on[0],))
        self.on.append(ticket)
        return None

    def deactivate(self, ticket: int) -> None:
        self.on = [one for one in self.on if one != ticket]

    def advance(self, to: Any) -> None:
        if to > self.time and self.on:
            self.sent = [Signal((":hummed",), tuple(self.on))]
        super().advance(to)

    def messages(self) -> Any:
        sent, self.sent = self.sent, []
        return sent


def goes_on(self: Any, ticket: int) -> None:
    """Switch nothing off."""


def says_yes(self: Any, ticket: int, skills: Any, events: Any) -> Any:
    return True


def refuses_beside_none(self: Any, ticket: int, skills: Any, events: Any) -> Any:
    return Refused((99,))


def hums_otherwise(self: Any, to: Any) -> None:
    self.sent = [Signal((":hissed",), tuple(self.on))]
    Good.advance(self, to)


def forgets_the_unknown(self: Any, ticket: int) -> None:
    self.on.remove(ticket)


BROKEN: dict[str, tuple[dict[str, Any], str]] = {
    "never off": ({"deactivate": goes_on}, "for an activation that is not on; see"),
    "no answer": ({"activate": says_yes}, "the answer to an activation .* is `True`"),
    "a refusal": (
        {"activate": refuses_beside_none},
        "because of an activation that is not",
    ),
    "a signal": ({"advance": hums_otherwise}, "`:hissed`|which it does not offer"),
    "an unknown ticket": ({"deactivate": forgets_the_unknown}, "skills.py:.*ValueErr"),
    "no skills": ({"activate": None}, "has no `activate`"),
}


def found(world: type[World]) -> str:
    """What is wrong with the skills of a world."""
    make: Any = world
    trials = try_world(lambda seed: make(random.Random(seed), {}))
    [skills] = [trial for trial in trials if trial.part == SKILLS]
    assert not skills.left_out
    return "; ".join(skills.faults)


def test_nothing_is_wrong_with_the_humming_one() -> None:
    assert found(Humming) == ""


@pytest.mark.parametrize("case", BROKEN)
def test_errors_of_skills_are_reported(case: str) -> None:
    parts, said = BROKEN[case]
    told = found(type("Bad", (Humming,), parts))
    assert re.search(said, told), told


class Forgetful(Smooth):
    """Take the waves off, and remember outside of what is saved how often."""

    def step(self, now: float, ports: Ports) -> None:
        self.times = getattr(self, "times", 0) + 1
        super().step(now, ports)
        self.state.value = self.times


class Wordy(Smooth):
    """Write words where numbers belong."""

    def step(self, now: float, ports: Ports) -> None:
        said: Any = "high"
        ports[SMOOTH] = said


class Bare(Reached):
    """Carry nothing, though a level is declared."""

    def test(self, now: float, ports: Ports) -> tuple[Atom, ...] | None:
        return ()


class Aimless(Aim):
    """Tell of the goal without the level."""

    events = (Bare,)


def tank(*skills: type[Skill]) -> type[World]:
    """Return the world of a tank with these skills."""
    own = Catalogue([*skills, Fill, LimitFlow], [LEVEL], [FLOW], [LowestLimit()])

    class Tank(SkillWorld):
        """A tank."""

        name = "tank"
        kit = Kit(offer(own))

        def __init__(self, rng: Any, options: Any) -> None:
            super().__init__(SkillRuntime(own), Water())

        def tick(self) -> Iterable[EventTold]:
            told = self.runtime.tick(self.time, {"level": lambda: self.state.level})
            self.state.level += (self.runtime.value(FLOW) or 0.0) / 10
            return told

    return Tank


def test_nothing_is_wrong_with_the_tank() -> None:
    assert found(tank(Smooth, Aim)) == ""


@pytest.mark.parametrize(
    ("skills", "said"),
    [
        (
            (Forgetful, Aim),
            "continues differently from the saved world, with skills on",
        ),
        ((Wordy, Aim), r"skills.py:\d+: SkillError: `smooth` \(Wordy\) writes 'high'"),
        ((Smooth, Aimless), "`test` of the class Bare returns 1 value, as `carries`"),
    ],
)
def test_errors_of_tank_skills_are_found(
    skills: tuple[type[Skill], ...], said: str
) -> None:
    told = found(tank(*skills))
    assert re.search(said, told), told
