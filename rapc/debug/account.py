"""Account of the time of a run: actions, waits and suspensions, from its events.

The account needs no library: it works for recorded runs, and in the workers of
experiments. A family is a top-level task with its descendants. The run and each family
have a lane: their time, divided into pieces.

While requests or skills are under way, the time counts for those that began last.
Other time is idle and counts for a wait:

- In the lane of a family, for the wait that ended the idle interval: the wait of the
  first task that could go on.
- In the lane of the run, for a wait that does not depend on other tasks. The first of
  these groups that has such a wait decides, with its latest wait: families that hold
  things for which other families wait, foreground tasks, background tasks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

import msgspec

from rapc import events
from rapc.base.values import Fact, format_list
from rapc.debug.log import ToldEvent
from rapc.events import Event, Goal
from rapc.runtime.task_request import read_task_request
from rapc.world import Time

K = TypeVar("K", bound=Hashable)

ACTING = "acting"
SENSING = "sensing"
WAITING = "waiting"
SUSPENDED = "suspended"

KINDS = (ACTING, SENSING, WAITING, SUSPENDED)
"""The kinds of time, in the order of tables; `Wait.kind` is a finer division."""

_INDEPENDENT = ("monitor", "window", "signal")
"""The kinds of waits that do not depend on other tasks."""


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
    #: The family and the task for which the time counts; None if no task is live.
    family: int | None
    task: int | None
    kind: str
    #: The name of the request or skill, or a text for the wait.
    what: str
    #: The wait in full; empty for a request.
    on: str = ""


class Spell(msgspec.Struct, eq=False):
    """An interval of a run: a request, the skills of an activation, or waiting.

    An account has the spells of requests and activations, which may overlap. Waiting is
    added by `rapc.debug.questions.times.spells`.
    """

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
    #: The result of a request; empty while it is under way, and for skills.
    result: str = ""


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


class _OpenWait(NamedTuple):
    """A wait that has not ended; see `Wait`."""

    kind: str
    on: str
    by: int | None
    start: Time


class _Task(msgspec.Struct, eq=False):
    """A live task, with its wait or None."""

    number: int
    goal: Goal
    family: int
    parent: int | None
    made: Time
    wait: _OpenWait | None
    #: The time at which the last child ended; None before.
    child_ended: Time | None = None


class _Lane:
    """The time of a run or of a family, as pieces without gaps."""

    def __init__(self, since: Time) -> None:
        #: The time up to which the pieces reach.
        self.since = since
        self.pieces: list[Piece] = []
        #: The requests and activations under way, in the order of their start.
        self.under_way: dict[int, Piece] = {}

    def spend(self, now: Time, idle: Piece) -> None:
        """Count the time up to `now`: for the last request, or else as `idle`."""
        if self.since >= now:
            return
        piece = idle
        if self.under_way:
            piece = self.under_way[next(reversed(self.under_way))]
        last = self.pieces[-1] if self.pieces else None
        if last is not None and last[2:] == piece[2:] and last.stop == self.since:
            self.pieces[-1] = last._replace(stop=now)
        else:
            self.pieces.append(piece._replace(start=self.since, stop=now))
        self.since = now


_ENDS_OF_REQUESTS: Mapping[type[Event], str] = {
    events.PrimitiveEnded: "",
    events.PrimitiveCancelled: "cancelled",
    events.RequestRefused: "refused",
}
"""The ends of requests, each with its result if the event has none."""

_ENDS_OF_TASKS: Mapping[type[Event], str] = {
    events.TaskSucceeded: "succeeded",
    events.TaskFailed: "failed",
    events.TaskRemoved: "removed",
}

_OF_TASKS: tuple[type[Event], ...] = (
    *(events.TaskSelected, events.TaskBlocked, events.TaskWoken),
    *(events.MethodEnded, events.MethodSuspended),
    *(events.PrimitiveRequested, events.SkillEnabled),
    *_ENDS_OF_TASKS,
)
"""The events of a live task."""


class Account:
    """The time of a run: a listener for `Interpreter.listen` with `Account.kinds`.

    Args:
        sensors: the names of the sensor primitives of the world.
    """

    kinds: tuple[type[Event], ...] = (
        *(events.RunStarted, events.TaskCreated),
        *(*_OF_TASKS, *_ENDS_OF_REQUESTS),
        *(events.SkillDisabled, events.SignalReceived, events.RunEnded),
    )
    """The events that an account is made of."""

    def __init__(self, sensors: Collection[str] = ()) -> None:
        self._sensors = frozenset(sensors)
        #: The present time: that of the last event, or of `close`.
        self.now: Time = 0
        #: The end reason of the run; empty before the end.
        self.reason = ""
        self.families: dict[int, Family] = {}
        #: How often tasks failed, by the family, the RAP and the result.
        self.failures: Counter[tuple[int, str, str]] = Counter()
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
        #: Whether `_spend_all` has counted waits that have not ended.
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

    def __call__(self, event: Any) -> None:
        """Count an event; events of other kinds than `Account.kinds` are ignored."""
        kind, self.now = type(event), event.time
        number: Any = getattr(event, "task", None)
        if kind is events.TaskCreated:
            self._create(event)
        elif kind in _OF_TASKS:
            task = self._tasks.get(number)
            if task is not None:
                self._take(task, event)
        elif kind is events.SignalReceived:
            if number in self._activations:
                self._activations[number].heard.append(event.what)
        elif kind in _ENDS_OF_REQUESTS:
            if kind is events.RequestRefused:
                self._refused = number
            result = _ENDS_OF_REQUESTS[kind] or event.result
            self._end_request(number, event.request, result)
        elif kind is events.SkillDisabled:
            self._disable(number)
        elif kind is events.RunStarted:
            given = map(read_task_request, event.spec.tasks)
            self._background = {format_list(t.goal) for t in given if t.background}
        elif kind is events.RunEnded:
            self.reason = event.reason
            for one in event.results:
                if one.task in self.families:
                    self.families[one.task].background = one.background

    def close(self, now: Time) -> None:
        """Count the time up to `now` for all that is under way.

        The time after the end of the last wait counts for the wait of the live task
        that was blocked last.
        """
        self.now = max(now, self.now)
        self._spend_all()
        for task in self._tasks.values():
            self._end_wait(task)
        active = (one for one in self._activations.values() if one.on)
        for spell in (*self._requests, *active):
            spell.stop = self.now

    def _spend_all(self) -> None:
        """Count the time up to now for the run and all live families."""
        self._closing = True
        last: dict[int | None, tuple[Time, _Task]] = {}
        for one in self._tasks.values():
            if one.wait is not None:
                for key in (None, one.family):
                    if key not in last or one.wait.start >= last[key][0]:
                        last[key] = one.wait.start, one
        for key, lane in ((None, self._run), *self._of_family.items()):
            if key is None or self.families[key].ended is None:
                task = last[key][1] if key in last else None
                lane.spend(self.now, self._idle_for(task))

    # --- events -----------------------------------------------------------------------

    def _create(self, event: events.TaskCreated) -> None:
        number, goal, family = event.task, event.goal, event.family
        wait = _OpenWait("order", "preceding steps", None, self.now)
        if event.parent is None:
            rap, text = goal.name, str(goal)
            arrival = Piece(0, 0, family, number, WAITING, f"arrival of {rap}", text)
            if self._run.since < self.now:
                self._run.spend(self.now, self._idle_in_run(arrival, arrival=True))
            self._of_family[family] = _Lane(self.now)
            made = Family(number, text, rap, self.now)
            made.background = text in self._background
            self.families[family] = made
            wait = self._turn()
        else:
            self.parents[number] = event.parent
        self._tasks[number] = _Task(number, goal, family, event.parent, self.now, wait)

    def _turn(self) -> _OpenWait:
        return _OpenWait("turn", "its selection", None, self.now)

    def _take(self, task: _Task, event: Any) -> None:
        """Count an event of a live task."""
        kind = type(event)
        if kind is events.PrimitiveRequested:
            parts = [event.request]
            spell = Spell(self.now, self.now, task.family, task.number, parts)
            self._begin(spell, task)
            return
        if kind is events.SkillEnabled:
            self._enable(task, event)
            return
        if kind is events.TaskRemoved and event.cause == "run-over":
            self._spend_all()
        self._spend(task)
        self._end_wait(task)
        if kind is events.TaskBlocked:
            wait = self._kind_of_wait(task, event.on, event.holder)
            task.wait = _OpenWait(wait, event.on, event.holder, self.now)
        elif kind is events.MethodSuspended:
            task.wait = _OpenWait(SUSPENDED, event.for_, event.by, self.now)
        elif kind is events.TaskWoken or kind is events.MethodEnded:
            task.wait = self._turn()
        elif kind in _ENDS_OF_TASKS:
            self._end_task(task, event)
        if task.number == self._refused:
            self._refused = None

    def _kind_of_wait(self, task: _Task, on: str, by: int | None) -> str:
        """Return the kind of the wait of a task that is blocked."""
        if by is not None:
            return "device" if task.number == self._refused else "thing"
        if on.startswith("(:"):
            return "signal"
        return "window" if on.startswith("time ") else "monitor"

    def _end_wait(self, task: _Task) -> None:
        """End the wait of a task, if any; a step may have waited for its window too."""
        begun, task.wait = task.wait, None
        if begun is None or begun.start == self.now:
            return
        ordered = self._order_until(task) if begun.kind == "order" else self.now
        if begun.start < ordered:
            self._add_wait(task, begun.kind, begun.on, begun.start, ordered, begun.by)
        if ordered < self.now:
            self._add_wait(task, "window", "its start time", ordered, self.now)

    def _add_wait(
        self,
        task: _Task,
        kind: str,
        on: str,
        start: Time,
        stop: Time,
        by: int | None = None,
    ) -> None:
        goal = str(task.goal)
        self.waits.append(
            Wait(kind, on, start, stop, task.number, goal, task.family, by)
        )

    def _order_until(self, task: _Task) -> Time:
        """Return the time at which the steps before a step had ended.

        While a sibling of a step that still waits is live, this is the present time.
        """
        parent = self._tasks.get(task.parent or 0)
        if self._closing and self._has_sibling(task):
            return self.now
        ended = None if parent is None else parent.child_ended
        return task.made if ended is None else max(ended, task.made)

    def _has_sibling(self, task: _Task) -> bool:
        others = (one for one in self._tasks.values() if one is not task)
        return any(one.parent == task.parent for one in others)

    def _end_task(self, task: _Task, event: Any) -> None:
        del self._tasks[task.number]
        if type(event) is events.TaskFailed:
            self.failures[task.family, task.goal.name, event.result] += 1
        parent = self._tasks.get(task.parent or 0)
        if parent is not None:
            parent.child_ended = self.now
        over = type(event) is events.TaskRemoved and event.cause == "run-over"
        if task.parent is None and not over:
            family = self.families[task.number]
            family.ended, family.outcome = self.now, _ENDS_OF_TASKS[type(event)]

    # --- requests and skills ----------------------------------------------------------

    def _begin(self, spell: Spell, task: _Task) -> None:
        """Begin a request or an activation."""
        self._spend(task)
        self.spells.append(spell)
        if not spell.on:
            self._requests.append(spell)
        if not spell.background:
            name = str(spell.parts[0][0])
            kind = SENSING if name in self._sensors else ACTING
            piece = Piece(0, 0, task.family, spell.task, kind, name)
            for lane in (self._run, self._of_family[task.family]):
                lane.under_way[id(spell)] = piece

    def _end_request(self, number: int | None, request: Fact, result: str) -> None:
        """End a request; its items may have been merged into others meanwhile."""
        own = [one for one in self._requests if number in (None, one.task)]
        same = [one for one in own if request in one.parts]
        renamed = (one for one in own if one.parts[0][0] == request[0])
        spell = next(iter(same), None) or next(renamed, None)
        if spell is not None:
            self._requests.remove(spell)
            spell.result = result
            self._finish(spell)

    def _finish(self, spell: Spell) -> None:
        """End a request or an activation; its task may have ended before."""
        spell.stop = self.now
        assert spell.family is not None
        assert spell.task is not None
        for lane in (self._run, self._of_family[spell.family]):
            if id(spell) in lane.under_way:
                lane.spend(self.now, lane.under_way[id(spell)])
                del lane.under_way[id(spell)]
        task = self._tasks.get(spell.task)
        if task is not None and spell.stop > spell.start and not spell.background:
            on = format_list(spell.parts[0])
            self._add_wait(task, "device", on, spell.start, spell.stop)

    def _enable(self, task: _Task, event: events.SkillEnabled) -> None:
        known = self._activations.get(task.number)
        if known is None or not known.on:
            parts = [event.what]
            known = Spell(self.now, self.now, task.family, task.number, parts)
            known.on, known.background = 1, event.background
            self._activations[task.number] = known
            self._begin(known, task)
            return
        known.on += 1
        if event.what not in known.parts:
            known.parts.append(event.what)

    def _disable(self, number: int) -> None:
        known = self._activations.get(number)
        if known is None:  # in a damaged recording
            return
        known.on -= 1
        if not known.on:
            self._finish(known)

    # --- the time of lanes ------------------------------------------------------------

    def _spend(self, task: _Task) -> None:
        """Count the time up to now; the wait of `task` has ended an idle interval."""
        family = self._of_family[task.family]
        if self._run.since < self.now or family.since < self.now:
            idle = self._idle_for(task)
            family.spend(self.now, idle)
            if not self._run.under_way:
                idle = self._idle_in_run(idle)
            self._run.spend(self.now, idle)

    def _idle_in_run(self, default: Piece, *, arrival: bool = False) -> Piece:
        """Return the piece of an idle interval of the run; see the head of the module.

        Args:
            default: the result if all waits depend on other tasks.
            arrival: whether the arrival of a task has ended the interval: `default`
                then counts before the waits of background tasks.
        """
        latest: dict[int, _Task] = {}
        holders = set()
        for task in self._tasks.values():
            wait = task.wait
            if wait is None:
                continue
            if wait.by is not None:
                holder = self._tasks.get(wait.by)
                if holder is not None and holder.family != task.family:
                    holders.add(holder.family)
            elif wait.kind in _INDEPENDENT:
                known = latest.get(task.family)
                if known is None or known.wait.start <= wait.start:  # type: ignore[union-attr]
                    latest[task.family] = task
        foreground = {n for n in latest if not self.families[n].background}
        for families in (holders, foreground, set() if arrival else set(latest)):
            tasks = [latest[number] for number in families if number in latest]
            if tasks:
                return self._idle_for(max(tasks, key=_start_of_wait))
        return default

    def _idle_for(self, task: _Task | None) -> Piece:
        """Return the piece of an idle interval that counts for the wait of a task."""
        if task is None:
            return Piece(0, 0, None, None, WAITING, "a task")
        rap = task.goal.name
        kind, on, by, _ = task.wait or _OpenWait("turn", "its selection", None, 0)
        if kind == "order" and self._order_until(task) < self.now:
            kind, on = "window", "its start time"
        what = f"{kind} of {rap}"
        if kind == "signal":
            what = f"signal {first_word(on)} for {rap}"
        elif by is not None:
            holder = self._tasks.get(by)
            of = "a task that has ended"
            if holder is not None:
                of = self.families[holder.family].rap
            what = f"{on} of {of}"
            if kind == "device":
                what = f"the request {first_word(on)} of {of}"
            elif kind == SUSPENDED:
                what = f"by {of} for {on}"
        kind = SUSPENDED if kind == SUSPENDED else WAITING
        return Piece(0, 0, task.family, task.number, kind, what, on)


def _start_of_wait(task: _Task) -> tuple[Time, int]:
    """Return the start of the wait of a task, and its number."""
    return task.wait.start if task.wait is not None else 0, task.number


def first_word(text: str) -> str:
    """Return the first word of a list that is given as text."""
    return text[1:].rstrip(")").split(" ")[0]


def idle_in_words(kind: str, what: str) -> str:
    """Return the `kind` and `what` of an idle piece as text: `waiting for ...`."""
    return f"{kind} {'for ' if kind == WAITING else ''}{what}"


def account_of(
    told: Iterable[ToldEvent], now: Time, sensors: Collection[str] = ()
) -> Account:
    """Return the account of a run from its events, up to a time."""
    found = Account(sensors)
    for one in told:
        if one.time > now:
            break
        found(one.event())
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
