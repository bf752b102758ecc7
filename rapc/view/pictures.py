"""Pictures of a run for views: recorded in its trace, or taken while it runs again."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import msgspec

from rapc.base import pictures
from rapc.base.messages import Time
from rapc.base.values import format_list, number
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.errors import LoadError
from rapc.events import (
    DataReceived,
    Event,
    FactAsserted,
    FactErased,
    Pictured,
    PrimitiveCancelled,
    PrimitiveEnded,
    PrimitiveRequested,
    RunEnded,
    SignalReceived,
    SkillDisabled,
    SkillEnabled,
    TaskSelected,
)
from rapc.view.scene import Beliefs, Scene, scene_of
from rapc.world import Drawable

Change = tuple[int, dict[str, Any]]
"""The serial number of an event, and the change of the picture since the last."""

PATH = 20
"""The number of pictures before a picture that give the path of the robot."""

_MOMENTS = (TaskSelected, PrimitiveEnded, DataReceived, SignalReceived, RunEnded)
"""The events at which the picture is taken."""

_ACTS = (PrimitiveRequested, PrimitiveCancelled, SkillEnabled, SkillDisabled)
"""The events after which the picture may change without time and other events."""


class Pictures:
    """The pictures of a run, taken as the run goes on if its trace has none.

    Args:
        history: the run; if it has gone on already, it is repeated to its present
            moment.
    """

    def __init__(self, history: History) -> None:
        self._history = history
        #: The changes, in the order of their events.
        self.changes: list[Change] = []
        self._last: Any = {}
        #: The time at which the picture is as it was at the last event.
        self._settled: Time | None = None
        if not history.is_run or history.spec.settings.get("pictures"):
            return
        run = history.run
        if isinstance(run.port, Drawable):
            here = history.moment
            if here > history.beginning:
                history.goto(history.beginning)
            self._take(run.port, max(history.serial - 1, 0))
            run.listen(self._hear, *_MOMENTS, *_ACTS)
            if here > history.beginning:
                history.goto(here)

    def _hear(self, event: Event) -> None:
        if isinstance(event, _ACTS):
            self._settled = None
            return
        if isinstance(event, TaskSelected) and event.time == self._settled:
            return
        port = self._history.run.port
        if event.n > self.changes[-1][0] and isinstance(port, Drawable):
            self._take(port, event.n)
            self._settled = event.time

    def _take(self, port: Drawable, serial: int) -> None:
        text = msgspec.json.encode(pictures.plain(port.picture()))
        after = msgspec.json.decode(text)
        if after != self._last:
            self.changes.append((serial, pictures.change(self._last, after)))
            self._last = after


def valid(picture: Mapping[str, Any]) -> dict[str, Any]:
    """Return a picture of a trace, with all keys. Raises LoadError if it is invalid."""
    try:
        return pictures.plain(pictures.from_plain(picture))
    except ValueError as error:
        raise LoadError(f"the trace has an invalid picture: {error}") from error


def scene_at(
    events: Iterable[ToldEvent], taken: Sequence[Change], cycle: int | None
) -> Scene | None:
    """Return the drawing of the end of a cycle of a run; see `Viewed.scene_at`.

    Args:
        events: the events of the run.
        taken: the changes of the picture that the trace does not have.
        cycle: the cycle; None for the end of the run.
    """
    facts: dict[str, float] = {}
    recorded: list[Change] = []
    serial, now = -1, number(0)
    for one in events:
        if cycle is not None and one.cycle > cycle:
            break
        serial, now = one.serial, one.time
        if one.kind is FactAsserted:
            facts[format_list(one.keys["fact"])] = one.time
        elif one.kind is FactErased:
            facts.pop(format_list(one.keys["fact"]), None)
        elif one.kind is Pictured:
            recorded.append((serial, one.keys["changed"]))
    changes = recorded or taken
    last = bisect_right(changes, serial, key=lambda change: change[0])
    picture: dict[str, Any] = {}
    found = []
    for _, change in changes[:last]:
        picture = pictures.changed(picture, change)
        found.append(picture)
    shown = [valid(one) for one in found[-PATH - 1 :]]
    present = shown.pop() if shown else None
    return scene_of(present, Beliefs(facts, now), shown)
