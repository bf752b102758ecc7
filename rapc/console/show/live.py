"""The view of a run in progress: a listener that draws frames.

The view draws a frame after each request. In a world with a plan, the view draws a
frame for each second of world time, when no task may run. On a terminal, frames replace
each other on a separate screen, slowly enough to follow; the last frame stays after
the run. Elsewhere the view writes only the last frame, or every n-th frame as well if
requested.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from typing import TextIO

from rich.console import Console, Group
from rich.live import Live
from rich.text import Text

from rapc.base.values import format_list
from rapc.console.findings import write_lines
from rapc.console.show.frame import Activity, draw_frame
from rapc.events import (
    Event,
    PrimitiveEnded,
    SkillDisabled,
    SkillEnabled,
)
from rapc.runtime.interpreter import Interpreter
from rapc.world import Picture, Time

PACE = 0.1
"""The interval between frames on a terminal, in seconds."""

_REQUESTS = 2
"""The number of latest requests in a frame."""


class LiveView:
    """A view of a run; a context manager, and a listener for `Interpreter.listen`.

    Args:
        interpreter: the run to show.
        picture: returns the present truth.
        stream: the output; frames follow each other only on a terminal.
        size: returns columns and rows of a frame, for each frame; 0 rows: no limit.
        color: whether to colour the frames.
        every: the interval of written frames on other streams; 0: only the last frame.
        pace: the shortest time from one frame to the next, in seconds.
    """

    def __init__(
        self,
        interpreter: Interpreter,
        picture: Callable[[], Picture],
        stream: TextIO,
        size: Callable[[], tuple[int, int]],
        *,
        color: bool,
        every: int = 0,
        pace: float = PACE,
    ) -> None:
        self._interpreter = interpreter
        self._picture = picture
        self._stream = stream
        self._size = size
        self._color = color
        self._pace = pace
        self._every = every
        self._frames = 0
        self._planned = picture().plan is not None
        self._due: Time = 0
        self._family = ""
        blank = [] if self._planned else [""] * _REQUESTS
        self._requests: deque[str] = deque(blank, _REQUESTS)
        #: The number of activations of each skill, in the order of the first
        #: activation.
        self._skills: dict[str, int] = {}
        self._last: list[Text] = []
        self._live: Live | None = None
        self._next = 0.0

    def __enter__(self) -> LiveView:
        self._interpreter.call_at_end(self._look_back)
        if self._planned:
            self._interpreter.call_when_waiting(self._look)
        if self._stream.isatty():
            console = Console(file=self._stream, highlight=False)
            self._live = Live(console=console, screen=True, auto_refresh=False)
            self._live.start()
        return self

    def __exit__(self, kind: type[BaseException] | None, *more: object) -> None:
        if self._live is not None:
            self._live.stop()
        if kind is None:
            write_lines(self._last, self._stream, color=self._color)

    def __call__(self, event: Event) -> None:
        """Process an event; draw a frame if a request has ended."""
        if isinstance(event, PrimitiveEnded):
            self._requests.append(f"{format_list(event.request)} - {event.result}")
            self._find_family(event.task)
            if not self._planned:
                self._draw()
        elif isinstance(event, SkillEnabled):
            skill = format_list(event.what)
            self._skills[skill] = self._skills.get(skill, 0) + 1
            self._find_family(event.task)
        elif isinstance(event, SkillDisabled):
            self._switch_off(format_list(event.what))

    def _switch_off(self, skill: str) -> None:
        """Remove an activation of a skill."""
        self._skills[skill] = self._skills.get(skill, 0) - 1
        if self._skills[skill] <= 0:
            del self._skills[skill]

    def _look(self) -> None:
        """Draw a frame if a new second has begun."""
        now = self._interpreter.now
        if now >= self._due:
            self._due = math.floor(now) + 1
            self._draw()

    def _look_back(self) -> None:
        """Keep the last frame, with all skills that are still active."""
        self._last = self._frame()

    def _find_family(self, task: int | None) -> None:
        """Return the top-level task that is the ancestor of a task."""
        entries = {entry.task: entry for entry in self._interpreter.agenda()}
        found = entries.get(task) if task is not None else None
        top = entries.get(found.family) if found is not None else None
        if top is not None:
            self._family = f"[{top.task}] {top.goal}"

    def _draw(self) -> None:
        """Replace the last frame, when its time has come.

        Without a terminal, write the frame if it is due.
        """
        self._frames += 1
        if self._live is None:
            if self._every and self._frames % self._every == 0:
                write_lines([*self._frame(), Text()], self._stream, color=self._color)
            return
        frame = Group(*self._frame())
        time.sleep(max(self._next - time.monotonic(), 0))
        self._next = time.monotonic() + self._pace
        self._live.update(frame, refresh=True)

    def _frame(self) -> list[Text]:
        newest = reversed(self._skills)
        doings = Activity(
            self._interpreter.now,
            self._family,
            tuple(self._requests),
            tuple(dict.fromkeys(s.split()[0].strip("(:)") for s in newest)),
        )
        width, height = self._size()
        picture = self._picture()
        memory = self._interpreter.memory
        lines = draw_frame(picture, memory, doings, width, height)
        return lines if self._color else [Text(line.plain) for line in lines]
