"""A journey by hand: what RAPs will do, as a plain function over skills.

The controller knows the map's relations (which landmark is where from which, roughly)
and dead reckoning; of the truth it sees nothing.
"""

from __future__ import annotations

import math
from collections import deque

from rapc.worlds.hallway.facts import relation
from rapc.worlds.hallway.map import Map, Sign
from rapc.worlds.skills.catalogue import SkillRequest
from tests.hallway.driver import Driver, Outcome, to_landmark, watch

LATEST = 1500.0
"""After how many seconds a journey is given up."""


NEAR = 2.5
"""A doorway farther away by dead reckoning cannot have been passed, in metres."""

JUST_PASSED = 6.0
"""So long after a doorway the sonars may still tell of that one, in seconds."""


class Traveller:
    """A robot that goes from landmark to landmark, and what it believes.

    It begins in its place before a landmark.
    """

    def __init__(self, driver: Driver, space: str, landmark: str) -> None:
        self.driver = driver
        self.space = space
        self.at = driver.sim.sign_of(landmark, space)
        #: Whether it stands in its place before `at`, not just beyond the doorway.
        self.placed = True
        body = driver.sim.state.robot
        #: Where the robot was then, by dead reckoning.
        self.base = (body.reckoned_x, body.reckoned_y)
        #: The heading in the frame of dead reckoning when it faced `at`.
        self.facing = driver.sim.state.robot.reckoned_heading
        #: When each doorway was last found closed.
        self.closed: dict[str, float] = {}
        #: What went wrong on the way.
        self.trouble: list[str] = []
        #: When it last went through a doorway on purpose.
        self.since = -JUST_PASSED
        self._passages = driver.on(
            SkillRequest("detect-doorway"), events=("passed-doorway",)
        )

    def travel(self, landmark: str, space: str, within: float = LATEST) -> bool:
        """Go to a landmark in a space; return whether it believes to be there."""
        start = self.driver.sim.now
        while self.driver.sim.now - start < within:
            way = route(self.driver.sim.map, self.space, space, self._shut())
            if way is None:
                self.driver.tick(100)
                continue
            if not way:
                if self._go(self.driver.sim.sign_of(landmark, space)):
                    return True
                continue
            doorway, beyond = way[0]
            if not self._go(self.driver.sim.sign_of(doorway, self.space)):
                continue
            self._through(doorway, beyond)
        return False

    def _shut(self) -> set[str]:
        """The doorways that were found closed a short while ago."""
        now = self.driver.sim.now
        return {name for name, at in self.closed.items() if now - at < 60}

    def _go(self, sign: Sign) -> bool:
        """Go to a landmark of the present space."""
        driver, start = self.driver, self.at
        if sign is start and self.placed:
            return True
        if sign is not start:
            direction, distance = relation(start, sign)
            heading = math.remainder(self.facing + direction, math.tau)
            begun = len(driver.heard)
            moved = self._search(heading, distance, sign)
            if self._came_through(begun):
                return False
            if moved.event == "stuck":
                self.trouble.append(f"stuck before seeing {sign.landmark}")
        begun = len(driver.heard)
        events = ("at-landmark", "stuck", "lost-landmark")
        outcome = driver.until(to_landmark(sign), events=events)
        if self._came_through(begun):
            return False
        if outcome.event == "at-landmark":
            self._placed(sign, outcome)
            return True
        self.trouble.append(f"{outcome.event} on the way to {sign.landmark}")
        self._back_to_somewhere()
        return False

    def _came_through(self, begun: int) -> bool:
        """Whether the robot has come through a doorway since, without meaning to.

        It is taken to be the one of this space that leads the way it came.
        """
        passed = [
            told
            for at, told in self.driver.heard[begun:]
            if told.event == "passed-doorway" and at > self.since + JUST_PASSED
        ]
        if not passed:
            return False
        heading = passed[-1].arguments[2]
        assert isinstance(heading, float | int)
        leading = [
            sign
            for sign in self.driver.sim.signs
            if sign.space == self.space
            and sign.landmark in self.driver.sim.openings
            and abs(math.remainder(sign.normal + math.pi - heading, math.tau)) < 0.8
        ]
        if not leading:
            return False
        sign = min(leading, key=self._away)
        if self._away(sign) > NEAR:
            return False
        joins = self.driver.sim.openings[sign.landmark].doorway.joins
        (self.space,) = set(joins) - {self.space}
        self.trouble.append(f"came through {sign.landmark}")
        self._beyond(sign.landmark, heading)
        return True

    def _away(self, sign: Sign) -> float:
        """How far the robot is from a landmark of the space, by dead reckoning."""
        direction, distance = (0.0, 0.0)
        if sign is not self.at:
            direction, distance = relation(self.at, sign)
        x, y = self.base
        body, heading = self.driver.sim.state.robot, self.facing + direction
        return math.hypot(
            x + distance * math.cos(heading) - body.reckoned_x,
            y + distance * math.sin(heading) - body.reckoned_y,
        )

    def _beyond(self, doorway: str, heading: float) -> None:
        """The robot has just come into `space` by a doorway."""
        body = self.driver.sim.state.robot
        self.at = self.driver.sim.sign_of(doorway, self.space)
        self.facing, self.placed = math.remainder(heading + math.pi, math.tau), False
        self.base = (body.reckoned_x, body.reckoned_y)
        self.since = self.driver.sim.now

    def _search(self, heading: float, distance: float, sign: Sign) -> Outcome:
        """Move towards where a landmark should come into view, until it does."""
        driver = self.driver
        move = SkillRequest("move-in-direction", (heading, distance, 0.5))
        return driver.until(
            move, watch(sign), events=("movement-complete", "stuck", "landmark-visible")
        )

    def _back_to_somewhere(self) -> None:
        """Find any landmark of the space to begin from again."""
        for sign in sorted(
            (s for s in self.driver.sim.signs if s.space == self.space),
            key=lambda s: s is not self.at,
        ):
            events = ("at-landmark", "stuck", "lost-landmark")
            outcome = self.driver.until(to_landmark(sign), events=events, within=90)
            if outcome.event == "at-landmark":
                self._placed(sign, outcome)
                return

    def _through(self, doorway: str, beyond: str) -> None:
        """Go through the doorway that the robot faces."""
        driver = self.driver
        if self._lift_involved(beyond) and not self._call():
            self.trouble.append("the lift did not come")
            return
        events = ("movement-complete", "door-closed", "stuck")
        request = SkillRequest("move-thru-doorway", (self.facing, 0.3))
        outcome = driver.until(request, events=events, within=60)
        if outcome.event == "movement-complete":
            self.space = beyond
            self._beyond(doorway, self.facing)
            self._ride(doorway)
            return
        self.trouble.append(f"{outcome.event} at {doorway}")
        self.closed[doorway] = driver.sim.now
        self._go_again(self.at)

    def _go_again(self, sign: Sign) -> None:
        events = ("at-landmark", "stuck", "lost-landmark")
        outcome = self.driver.until(to_landmark(sign), events=events, within=90)
        if outcome.event == "at-landmark":
            self._placed(sign, outcome)
        else:
            self._back_to_somewhere()

    def _placed(self, sign: Sign, outcome: Outcome) -> None:
        """The robot stands in its place before a landmark."""
        facing = outcome.arguments[2]
        assert isinstance(facing, float)
        self.at, self.facing, self.placed = sign, facing, True
        body = self.driver.sim.state.robot
        self.base = (body.reckoned_x, body.reckoned_y)

    def _lift_involved(self, beyond: str) -> bool:
        return self.driver.sim.map.named_space(beyond).kind == "lift"

    def _call(self) -> bool:
        """Have the lift at the robot's floor, and hold it there for some time."""
        floor = self.at.floor
        outcome = self.driver.until(
            SkillRequest("call-lift", (floor,)), events=("lift-here",), within=60
        )
        return outcome.event == "lift-here"

    def _ride(self, doorway: str) -> None:
        """In the lift: ride to the other floor."""
        sim = self.driver.sim
        if sim.map.named_space(self.space).kind != "lift":
            return
        other = next(s for s in sim.signs if s.space == self.space and s is not self.at)
        outcome = self.driver.until(
            SkillRequest("call-lift", (other.floor,)), events=("lift-here",), within=60
        )
        if outcome.event == "lift-here":
            self.at = other
        else:
            self.trouble.append(f"the lift stayed at {doorway}")


def route(
    map: Map, start: str, goal: str, shut: set[str]
) -> list[tuple[str, str]] | None:
    """The doorways of a shortest way, each with the space beyond it; None: no way."""
    came: dict[str, tuple[str, str] | None] = {start: None}
    queue = deque([start])
    while queue:
        space = queue.popleft()
        for doorway in map.doorway:
            if space in doorway.joins and doorway.name not in shut:
                beyond = next(name for name in doorway.joins if name != space)
                if beyond not in came:
                    came[beyond] = (doorway.name, space)
                    queue.append(beyond)
    if goal not in came:
        return None
    way: list[tuple[str, str]] = []
    step = came[goal]
    while step is not None:
        way.append((step[0], goal))
        goal = step[1]
        step = came[goal]
    return way[::-1]
