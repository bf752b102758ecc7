"""When the robot was wrong about the space that it was in, and through what.

Only who looks on knows: memory holds what the rules of the library made of signals,
the simulation where the robot is.
"""

from __future__ import annotations

from pathlib import Path

import msgspec

from rapc import events
from rapc.base.values import Number, format_list
from rapc.runtime.interpreter import Interpreter
from rapc.worlds.hallway import HallwayWorld

LASTS = 5
"""Memory follows the robot through a doorway by so many seconds at most."""


AROUND = 0.9
"""A doorway reaches so far from its middle, in metres."""


class Stray(msgspec.Struct):
    """A time for which the robot was wrong about the space that it was in."""

    start: Number
    believed: str
    truth: str
    #: Where the robot was then, in metres.
    place: tuple[float, float]
    #: What it was doing: the skill that came on last.
    doing: str
    #: What went before: the rule that changed memory, or that nothing did.
    cause: str
    #: None if it lasted to the end of the run.
    end: Number | None = None

    def __str__(self) -> str:
        until = "the end" if self.end is None else f"{self.end:.0f} s"
        x, y = self.place
        return (
            f"{self.start:.0f} s to {until}: believed {self.believed}, "
            f"was in {self.truth} ({x:.1f} {y:.1f}): {self.cause}; {self.doing}"
        )


class Strays:
    """All strays of a run: a listener that looks at both spaces at every signal.

    While the robot stands in a doorway it may be taken to be on either side.
    """

    kinds = (
        events.RuleRun,
        events.FactAsserted,
        events.SignalReceived,
        events.SkillEnabled,
    )

    def __init__(self, run: Interpreter, world: HallwayWorld) -> None:
        self._run, self._world = run, world
        #: All that lasted, in the order of time.
        self.found: list[Stray] = []
        self._open: Stray | None = None
        self._rule = self._moved_by = self._doing = ""
        run.listen(self, *self.kinds)

    def __call__(self, event: events.Event) -> None:
        """Take one event into account."""
        if isinstance(event, events.RuleRun):
            what = event.what if isinstance(event.what, str) else event.what[0]
            self._rule = f"{what} at {Path(event.at).name}"
        elif isinstance(event, events.SkillEnabled):
            self._doing = format_list(event.what)
        elif isinstance(event, events.FactAsserted):
            if event.fact[0] == "current-space":
                self._moved_by = self._rule
        elif isinstance(event, events.SignalReceived):
            self._compare(event.time)

    def _compare(self, now: Number) -> None:
        if self._in_a_doorway():
            return
        believed, truth = self._believed(), self._world.figures().space
        last = self._open
        if last is not None and (believed, truth) != (last.believed, last.truth):
            last.end, self._open, last = now, None, None
        if believed != truth and last is None:
            why = self._moved_by or "nothing told of the doorway"
            body = self._world.simulation.state.robot
            place = (body.x, body.y)
            last = self._open = Stray(now, believed, truth, place, self._doing, why)
        if last is not None and last not in self.found and now - last.start >= LASTS:
            self.found.append(last)
        if believed == truth:
            self._moved_by = ""

    def _in_a_doorway(self) -> bool:
        body = self._world.simulation.state.robot
        return any(
            abs(body.x - (gap.box[0] + gap.box[2]) / 2) < AROUND
            and abs(body.y - (gap.box[1] + gap.box[3]) / 2) < AROUND
            for gap in self._world.simulation.openings.values()
            if gap.floor == body.floor
        )

    def _believed(self) -> str:
        ((*_, space),) = self._run.memory.query("current-space", "robot", None)
        return str(space)
