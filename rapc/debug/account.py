"""Account of the time of a run: actions, waits and suspensions, from its events.

The account needs no library: it works for recorded runs, and in the workers of
experiments. Each moment of a run counts for the request or the skills that began last
among those under way. A moment without them counts for the wait that ended the
interval: the wait of the first task that could go on. The same holds for the time of
each family.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import msgspec

from rapc import events
from rapc.base.values import Fact, format_list
from rapc.debug.log import ToldEvent
from rapc.events import Event
from rapc.runtime.task_request import read_task_request
from rapc.world import Time

K = TypeVar("K", bound=Hashable)

ACTING = "acting"
SENSING = "sensing"
WAITING = "waiting"
SUSPENDED = "suspended"

KINDS = (ACTING, SENSING, WAITING, SUSPENDED)
"""The kinds of time, in the order of tables."""


class Wait(msgspec.Struct, eq=False):
    """A wait of a task.

    `kind` is `monitor`, `window` (a time), `thing`, `signal`, `order` (preceding
    steps), `device` (a request under way), `suspended`, or `turn` (a task that could go
    on, and was not selected).
    """

    kind: str
    #: The monitor, time, thing, signal or request, as text.
    on: str
    start: Time
    #: The end of the wait; the present time while the task waits.
    stop: Time
    task: int
    goal: str
    family: int
    #: The task that holds the thing or has suspended the task.
    by: int | None = None


class Piece(NamedTuple):
    """A part of the time of a run, or of a family."""

    start: Time
    stop: Time
    #: The family and the task that the part counts for; None if no task is live.
    family: int | None
    task: int | None
    kind: str
    #: The name of the request or skill, or a text for the wait.
    what: str
    #: The wait in full; empty for a request.
    on: str = ""


class Spell(msgspec.Struct, eq=False):
    """An interval of a run: a request, the skills of an activation, or waiting."""

    start: Time
    #: The end of the interval; the present time while under way.
    stop: Time
    family: int | None
    task: int | None
    #: The request or the skills (more may be added); empty while all tasks wait.
    parts: list[Fact]
    #: The signals of the skills, in order.
    heard: list[Fact] = []
    #: The number of skills still enabled; 0 for a request.
    on: int = 0
    #: Whether the method does not wait for the skills.
    background: bool = False
    #: The wait as text; empty for requests and skills.
    waits: str = ""


class Family(msgspec.Struct, eq=False):
    """A top-level task with the time of its family."""

    task: int
    goal: str
    rap: str
    came: Time
    #: The time of its end; None while the task is live.
    ended: Time | None = None
    #: `succeeded`, `failed`, `removed`, or empty before the end.
    outcome: str = ""
    background: bool = False


class _Task(msgspec.Struct, eq=False):
    """A live task, with its wait or None."""

    rap: str
    goal: str
    family: int
    parent: int | None
    made: Time
    wait: Wait | None = None
    #: The time at which the last child ended; None before.
    child_ended: Time | None = None


class _Lane:
    """The time of a run or of a family, as pieces without gaps."""

    def __init__(self, since: Time) -> None:
        self.since = since
        self.pieces: list[Piece] = []
        #: The requests and activations under way, in the order of their start.
        self.under_way: dict[int, Piece] = {}

    def spend(self, now: Time, waited: Piece) -> None:
        """Count the time up to `now`: for the last request, or else as `waited`."""
        if now > self.since:
            mine = waited
            if self.under_way:
                mine = self.under_way[next(reversed(self.under_way))]
            last = self.pieces[-1] if self.pieces else None
            if last is not None and last[2:] == mine[2:] and last.stop == self.since:
                self.pieces[-1] = last._replace(stop=now)
            else:
                self.pieces.append(mine._replace(start=self.since, stop=now))
            self.since = now


_ENDS_OF_REQUESTS = (
    events.PrimitiveEnded,
    events.PrimitiveCancelled,
    events.RequestRefused,
)

_ENDS_OF_TASKS: Mapping[type[Event], str] = {
    events.TaskSucceeded: "succeeded",
    events.TaskFailed: "failed",
    events.TaskRemoved: "removed",
}


class Account:
    """The time of a run: a listener for `Interpreter.listen` with `Account.kinds`.

    Args:
        sensors: the names of the sensor primitives of the world.
    """

    kinds: tuple[type[Event], ...] = (
        *(events.RunStarted, events.TaskCreated, events.TaskSelected),
        *(events.TaskBlocked, events.TaskWoken, events.MethodSuspended),
        *_ENDS_OF_TASKS,
        *(events.PrimitiveRequested, *_ENDS_OF_REQUESTS),
        *(events.SkillEnabled, events.SkillDisabled, events.SignalReceived),
        events.RunEnded,
    )
    """The events that an account is made of."""

    def __init__(self, sensors: Collection[str] = ()) -> None:
        self._sensors = frozenset(sensors)
        #: The present time: that of the last event, or of `close`.
        self.now: Time = 0
        #: The end reason of the run; empty before the end.
        self.reason = ""
        self.families: dict[int, Family] = {}
        #: The waits that took time, in the order of their ends.
        self.waits: list[Wait] = []
        #: The requests and activations, ordered by start.
        self.spells: list[Spell] = []
        self._run = _Lane(0)
        self._of_family: dict[int, _Lane] = {}
        self._tasks: dict[int, _Task] = {}
        self._requests: list[Spell] = []
        #: The latest activation of each task.
        self._activations: dict[int, Spell] = {}
        #: The goals of the background tasks of the spec, as text.
        self._background: set[str] = set()
        #: Whether the time of unfinished waits is counted.
        self._closing = False
        #: The parent of each step, by task.
        self.parents: dict[int, int] = {}
        #: The task whose request was refused last.
        self._refused: int | None = None

    @property
    def of_run(self) -> Sequence[Piece]:
        """The time of the run up to the present time, without gaps."""
        return self._run.pieces

    @property
    def of_family(self) -> Mapping[int, Sequence[Piece]]:
        """The time of each family, from its arrival to its end."""
        return {task: lane.pieces for task, lane in self._of_family.items()}

    def __call__(self, event: Event) -> None:
        """Count an event object."""
        keys = {name: getattr(event, name) for name in event.__struct_fields__}
        self.take(ToldEvent(type(event), event.n, event.cycle, event.time, keys))

    def take(self, told: ToldEvent) -> None:
        """Count an event; events of other kinds than `Account.kinds` are ignored."""
        kind, keys, self.now = told.kind, told.keys, told.time
        number = keys.get("task")
        if kind is events.RunStarted:
            given = map(read_task_request, keys["spec"].tasks)
            self._background = {format_list(t.goal) for t in given if t.background}
        elif kind is events.RunEnded:
            self.reason = keys["reason"]
            for one in keys["results"]:
                if one.task in self.families:
                    self.families[one.task].background = one.background
        elif kind is events.TaskCreated:
            self._create(keys)
        elif kind is events.SignalReceived:
            if number in self._activations:
                self._activations[number].heard.append(keys["what"])
        elif kind in _ENDS_OF_REQUESTS:
            if kind is events.RequestRefused:
                self._refused = number
            self._end_request(number, keys["request"])
        elif kind is events.SkillDisabled:
            self._disable(number)
        elif number in self._tasks:
            if keys.get("cause") == "run-over":
                self._spend_all()
            self._take(kind, number, self._tasks[number], keys)

    def close(self, now: Time) -> None:
        """Count the time up to `now` for all that is under way.

        The time after the end of the last wait counts for the wait of the live task
        that was blocked last.
        """
        self.now = max(now, self.now)
        self._spend_all()
        for task in self._tasks.values():
            self._end_wait(task)
        for spell in self.spells:
            if spell in self._requests or spell.on:
                spell.stop = self.now

    def _spend_all(self) -> None:
        """Count the time up to now for the run and all live families."""
        self._closing = True
        last: dict[int | None, Wait] = {}
        for task in self._tasks.values():
            wait = task.wait
            if wait is not None:
                for key in (None, task.family):
                    if key not in last or wait.start >= last[key].start:
                        last[key] = wait
        for key, lane in ((None, self._run), *self._of_family.items()):
            if key is None or self.families[key].ended is None:
                number = last[key].task if key in last else None
                lane.spend(self.now, self._waited(number))

    # --- events -----------------------------------------------------------------------

    def _create(self, keys: Mapping[str, Any]) -> None:
        number, goal, family = keys["task"], keys["goal"], keys["family"]
        rap, text = goal.name, str(goal)
        task = _Task(rap, text, family, keys["parent"], self.now)
        if keys["parent"] is None:
            arrival = Piece(0, 0, family, number, WAITING, f"arrival of {rap}", text)
            self._run.spend(self.now, arrival)
            self._of_family[family] = _Lane(self.now)
            made = Family(number, text, rap, self.now)
            made.background = text in self._background
            self.families[family] = made
            task.wait = self._new_wait(number, task, "turn", "its selection")
        else:
            self.parents[number] = keys["parent"]
            task.wait = self._new_wait(number, task, "order", "preceding steps")
        self._tasks[number] = task

    def _take(
        self, kind: type[Event], number: int, task: _Task, keys: Mapping[str, Any]
    ) -> None:
        """Count an event of a live task."""
        if kind is events.PrimitiveRequested:
            self._begin(
                Spell(self.now, self.now, task.family, number, [keys["request"]])
            )
            return
        if kind is events.SkillEnabled:
            self._enable(number, task, keys)
            return
        self._spend(number, task)
        self._end_wait(task)
        if kind is events.TaskBlocked:
            task.wait = self._blocked(number, task, keys["on"], keys.get("holder"))
        elif kind is events.MethodSuspended:
            on, by = keys["for_"], keys["by"]
            task.wait = self._new_wait(number, task, "suspended", on, by)
        elif kind is events.TaskWoken:
            task.wait = self._new_wait(number, task, "turn", "its selection")
        elif kind in _ENDS_OF_TASKS:
            outcome = _ENDS_OF_TASKS[kind]
            self._end_task(
                number, task, "" if keys.get("cause") == "run-over" else outcome
            )
        if number == self._refused:
            self._refused = None

    def _blocked(self, number: int, task: _Task, on: str, by: int | None) -> Wait:
        """Return the wait of a task that is blocked."""
        if by is not None:
            kind = "device" if number == self._refused else "thing"
        elif on.startswith("(:"):
            kind = "signal"
        else:
            kind = "window" if on.startswith("time ") else "monitor"
        return self._new_wait(number, task, kind, on, by)

    def _new_wait(
        self, number: int, task: _Task, kind: str, on: str, by: int | None = None
    ) -> Wait:
        now, goal = self.now, task.goal
        return Wait(kind, on, now, now, number, goal, task.family, by)

    def _end_wait(self, task: _Task) -> None:
        """End the wait of a task, if any; a step may have waited for its window too."""
        wait, task.wait = task.wait, None
        if wait is None or wait.start == self.now:
            return
        ordered = self._order_until(task)
        if wait.kind == "order" and ordered < self.now:
            window = msgspec.structs.replace(
                wait, kind="window", on="its start time", start=ordered, stop=self.now
            )
            wait.stop = ordered
            self.waits += [wait, window] if ordered > wait.start else [window]
        else:
            wait.stop = self.now
            self.waits.append(wait)

    def _order_until(self, task: _Task) -> Time:
        """Return the time at which the steps before a step had ended."""
        parent = self._tasks.get(task.parent or 0)
        if self._closing and self._has_sibling(task):
            return self.now
        ended = None if parent is None else parent.child_ended
        return task.made if ended is None else max(ended, task.made)

    def _has_sibling(self, task: _Task) -> bool:
        others = (one for one in self._tasks.values() if one is not task)
        return any(one.parent == task.parent for one in others)

    def _end_task(self, number: int, task: _Task, outcome: str) -> None:
        del self._tasks[number]
        parent = self._tasks.get(task.parent or 0)
        if parent is not None:
            parent.child_ended = self.now
        family = self.families.get(number)
        if family is not None and outcome:
            family.ended, family.outcome = self.now, outcome

    # --- requests and skills ----------------------------------------------------------

    def _begin(self, spell: Spell) -> None:
        """Begin a request or an activation."""
        assert spell.task is not None
        task = self._tasks[spell.task]
        self._spend(spell.task, task)
        self.spells.append(spell)
        if not spell.on:
            self._requests.append(spell)
        if not spell.background:
            name = str(spell.parts[0][0])
            kind = SENSING if name in self._sensors else ACTING
            piece = Piece(0, 0, task.family, spell.task, kind, name)
            for lane in self._lanes(task):
                lane.under_way[id(spell)] = piece

    def _end_request(self, number: int | None, request: Fact) -> None:
        for spell in self._requests:
            if request in spell.parts and number in (None, spell.task):
                self._requests.remove(spell)
                self._finish(spell)
                return

    def _finish(self, spell: Spell) -> None:
        """End a request or an activation; its task may have ended before."""
        spell.stop = self.now
        nothing = self._waited(None)
        lanes = [self._run]
        if spell.family in self._of_family:
            lanes.append(self._of_family[spell.family])
        for lane in lanes:
            if id(spell) in lane.under_way:
                lane.spend(self.now, nothing)
                del lane.under_way[id(spell)]
        if spell.stop > spell.start and not spell.on and spell.task is not None:
            self._wait_for_device(spell)

    def _wait_for_device(self, spell: Spell) -> None:
        task = self._tasks.get(spell.task or 0)
        if task is not None:
            on = format_list(spell.parts[0])
            times = (spell.start, spell.stop, spell.task or 0)
            self.waits.append(Wait("device", on, *times, task.goal, task.family))

    def _enable(self, number: int, task: _Task, keys: Mapping[str, Any]) -> None:
        known = self._activations.get(number)
        if known is None or not known.on:
            background = bool(keys.get("background"))
            known = Spell(self.now, self.now, task.family, number, [keys["what"]])
            known.heard, known.on, known.background = [], 1, background
            self._activations[number] = known
            self._begin(known)
            return
        known.on += 1
        if keys["what"] not in known.parts:
            known.parts.append(keys["what"])

    def _disable(self, number: Any) -> None:
        known = self._activations[number]
        known.on -= 1
        if not known.on:
            self._finish(known)

    # --- the time of lanes ------------------------------------------------------------

    def _lanes(self, task: _Task) -> tuple[_Lane, ...]:
        family = self._of_family.get(task.family)
        return (self._run,) if family is None else (self._run, family)

    def _spend(self, number: int, task: _Task) -> None:
        """Count the time up to now; the wait of `task` has ended an idle interval."""
        waited = None
        for lane in self._lanes(task):
            if lane.since < self.now:
                waited = waited or self._waited(number)
                lane.spend(self.now, waited)

    def _waited(self, number: int | None) -> Piece:
        """Return the piece of an idle interval that the wait of a task has ended."""
        task = self._tasks.get(number or 0)
        if task is None:
            return Piece(0, 0, None, None, WAITING, "a task")
        wait = task.wait
        if wait is None:
            what, on = f"the turn of {task.rap}", task.goal
            return Piece(0, 0, task.family, number, WAITING, what, on)
        kind, on = wait.kind, wait.on
        if kind == "order" and self._order_until(task) < self.now:
            kind, on = "window", "its start time"
        family = self.families.get(self._family_of(wait.by))
        by = "a task that has ended" if family is None else family.rap
        whats = {
            "signal": f"signal {on[1:].rstrip(')').split(' ')[0]} for {task.rap}",
            "thing": f"{on} of {by}",
            "device": f"the request {on[1:].rstrip(')').split(' ')[0]} of {by}",
            SUSPENDED: f"by {by} for {on}",
        }
        what = whats.get(kind, f"{kind} of {task.rap}")
        kind = SUSPENDED if kind == SUSPENDED else WAITING
        return Piece(0, 0, task.family, number, kind, what, on)

    def _family_of(self, number: int | None) -> int:
        task = self._tasks.get(number or 0)
        return 0 if task is None else task.family


def account_of(
    told: Iterable[ToldEvent], now: Time, sensors: Collection[str] = ()
) -> Account:
    """Return the account of a run from its events, up to a time."""
    found = Account(sensors)
    for one in told:
        if one.time > now:
            break
        found.take(one)
    found.close(now)
    return found


# --- sums ---------------------------------------------------------------------------


def times(
    pieces: Iterable[Piece],
    key: Callable[[Piece], K],
    start: Time = 0,
    stop: Time | None = None,
) -> dict[K, Time]:
    """Return the time between two times by a key of the pieces, most first."""
    found: Counter[K] = Counter()
    for one in pieces:
        end = one.stop if stop is None else min(one.stop, stop)
        used = end - max(one.start, start)
        if used > 0:
            found[key(one)] += used  # type: ignore[assignment]
    return dict(found.most_common())
