"""Somebody comes towards the robot through the doorway that it is going through."""

from __future__ import annotations

import math
from random import Random

import pytest

from rapc.worlds.hallway.map import Opening
from rapc.worlds.hallway.state import HallwaySettings
from rapc.worlds.skills.catalogue import SkillRequest
from tests.effort import first
from tests.hallway.driver import Driver

ONE_PERSON = HallwaySettings(doors=0, people=1, lift=0, drift=1, usage=0)

EVENTS = ("movement-complete", "door-closed", "stuck")

BLOCK = 10
"""So many meetings make a case."""


class Meeting:
    """The robot before a doorway, and somebody in it or behind it, drawn by a seed.

    The robot tries three times to go through, each time from where it stopped.
    """

    def __init__(self, seed: int) -> None:
        self.driver = driver = Driver(seed, ONE_PERSON)
        rng = Random(f"meeting {seed}")
        gaps = driver.sim.openings.values()
        gap = rng.choice(
            [g for g in gaps if g.floor == 1 and "lift" not in g.doorway.joins]
        )
        space, self.beyond = rng.sample(gap.doorway.joins, 2)
        sign = driver.sim.sign_of(gap.doorway.name, space)
        self.ahead = sign.normal + math.pi
        x, y = sign.front(rng.choice((0.3, 0.5, 1.0)))
        driver.place(x, y, self.ahead + rng.uniform(-0.2, 0.2))
        self.skew = rng.uniform(-0.2, 0.2)
        body = driver.sim.state.robot
        body.reckoned_heading += self.skew
        body.reckoned_x += rng.uniform(-3, 3)
        self._comes(gap, space, rng.uniform(0.1, 2.0))

    def _comes(self, gap: Opening, space: str, behind: float) -> None:
        """Let somebody come from so far behind the middle of a doorway."""
        left, bottom, right, top = gap.box
        (walker,) = self.driver.sim.state.walkers
        walker.space, walker.towards, walker.floor = self.beyond, space, 1
        cos, sin = math.cos(self.ahead), math.sin(self.ahead)
        middle = (left + right) / 2, (bottom + top) / 2
        walker.x, walker.y = middle[0] + behind * cos, middle[1] + behind * sin
        walker.way = [
            (middle[0] + far * cos, middle[1] + far * sin)
            for far in (0.7, -0.7)
            if far < behind
        ]

    def attempts(self) -> list[str]:
        """Return what the robot tells of each time that it tries to go through."""
        told: list[str] = []
        heading = round(self.ahead + self.skew, 3)
        request = SkillRequest("move-thru-doorway", (heading, 0.3))
        while len(told) < 3 and "movement-complete" not in told:
            told.append(self.driver.until(request, events=EVENTS, within=60).event)
        return told

    @property
    def through(self) -> bool:
        """Whether the robot is in the space behind the doorway."""
        return self.driver.sim.state.space == self.beyond


@pytest.mark.parametrize("block", first(1, range(30)))
def test_who_meets_somebody_in_a_doorway_is_through_if_it_says_so(block: int) -> None:
    through = 0
    for seed in range(BLOCK * block, BLOCK * (block + 1)):
        meeting = Meeting(seed)
        told = meeting.attempts()
        assert "timeout" not in told, seed
        if "movement-complete" in told:
            assert meeting.through, (seed, told)
            through += 1
        assert meeting.driver.fastest_collision() <= 0.1, seed
    assert 0 < through < BLOCK
