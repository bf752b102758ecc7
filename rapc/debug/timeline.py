"""What the time of a run went by with: requests, skills that were on, and waiting.

Gathered from the events of the run up to now.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence

import msgspec

from rapc import events
from rapc.base.values import Fact, format_list
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.world import Time

_ENDS = (
    events.PrimitiveEnded,
    events.PrimitiveCancelled,
    events.RequestRefused,
)


class Spell(msgspec.Struct, frozen=True):
    """A stretch of time with what was under way: spells may overlap."""

    start: Time
    stop: Time
    family: int | None
    task: int | None
    #: The request, or the skills of an activation; empty where all waited.
    doing: str
    #: The signals that arose under an activation, in the order in which they came.
    heard: tuple[Fact, ...] = ()


class _Doing(msgspec.Struct):
    """A request, or the skills of an activation, under way since `start`."""

    start: Time
    task: int
    #: One request, or the skills; an activation may get further ones.
    parts: list[Fact]
    #: How many of the skills are still on; 0 for a request.
    on: int = 0
    stop: Time | None = None
    heard: list[Fact] = []


def timeline(
    history: History, start: Time = 0, stop: Time | None = None
) -> list[Spell]:
    """Return what was under way between two times, by the time at which it began.

    Where nothing was there is a spell of waiting, so that all time is accounted for.

    Args:
        history: the history.
        start: spells that were over by then are left out.
        stop: spells that began then or later are left out; None for none.
    """
    families: dict[int, int] = {}
    reading = _Reading()
    kinds = (*_ENDS, events.TaskCreated, events.PrimitiveRequested)
    skills = (events.SkillEnabled, events.SkillDisabled, events.SignalReceived)
    for told in history.scan(*kinds, *skills):
        if told.kind is events.TaskCreated:
            families[told.keys["task"]] = told.keys["family"]
        else:
            reading.take(told)
    found = [
        Spell(
            one.start,
            history.now if one.stop is None else one.stop,
            families.get(one.task),
            one.task,
            " ".join(map(format_list, one.parts)),
            tuple(one.heard),
        )
        for one in reading.all
    ]
    found = [one for one in found if one.stop > one.start]
    return [
        one
        for one in _with_waiting(found, history.now)
        if one.stop > start and (stop is None or one.start < stop)
    ]


class _Reading:
    """Gathers from events what was under way and when."""

    def __init__(self) -> None:
        self.all: list[_Doing] = []
        self._requests: list[_Doing] = []
        #: The activation of each task that came on last.
        self._skills: dict[int, _Doing] = {}

    def take(self, told: ToldEvent) -> None:
        """Take one event in."""
        keys = told.keys
        if told.kind is events.PrimitiveRequested:
            doing = _Doing(told.time, keys["task"], [keys["request"]])
            self.all.append(doing)
            self._requests.append(doing)
        elif told.kind in _ENDS:
            self._end(keys["task"], keys["request"], told.time)
        elif told.kind is events.SkillEnabled:
            self._enable(keys["task"], keys["what"], told.time)
        elif keys["task"] in self._skills:
            doing = self._skills[keys["task"]]
            if told.kind is events.SignalReceived:
                doing.heard.append(keys["what"])
                return
            doing.on -= 1
            if not doing.on:
                doing.stop = told.time

    def _end(self, task: int | None, request: Fact, time: Time) -> None:
        for at, doing in enumerate(self._requests):
            if request in doing.parts and task in (None, doing.task):
                doing.stop = time
                del self._requests[at]
                return

    def _enable(self, task: int, skill: Fact, time: Time) -> None:
        doing = self._skills.get(task)
        if doing is None or not doing.on:
            doing = self._skills[task] = _Doing(time, task, [])
            self.all.append(doing)
        doing.on += 1
        if skill not in doing.parts:
            doing.parts.append(skill)


def _with_waiting(spells: Sequence[Spell], now: Time) -> Iterator[Spell]:
    """Yield spells by their beginning, with those of waiting between them."""
    reached: Time = 0
    for one in spells:
        if one.start > reached:
            yield Spell(reached, one.start, None, None, "")
        yield one
        reached = max(reached, one.stop)
    if now > reached:
        yield Spell(reached, now, None, None, "")


def time_by_family(
    spells: Iterable[Spell], start: Time = 0, stop: Time | None = None
) -> dict[int | None, Time]:
    """Return how much of the time between two times each family used, most first.

    A moment counts for whatever of all that was under way had begun last; for None
    where all waited.
    """
    marks: list[tuple[Time, int, bool]] = []
    listed = list(spells)
    for at, one in enumerate(listed):
        begin, end = max(one.start, start), one.stop if stop is None else stop
        end = min(one.stop, end)
        if end > begin:
            marks += [(begin, at, True), (end, at, False)]
    found: Counter[int | None] = Counter()
    under_way: list[int] = []
    last: Time = start
    for time, at, begins in sorted(marks):
        if under_way and time > last:
            used = time - last
            found[listed[max(under_way)].family] += used  # type: ignore[assignment]
        last = time
        if begins:
            under_way.append(at)
        else:
            under_way.remove(at)
    return dict(found.most_common())
