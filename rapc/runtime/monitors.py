"""Monitors: what blocked tasks wait for, and how they are woken without polling.

A monitored task listens to the changes that can affect its formula and to the times
at which beliefs in it go stale; what has changed is tested again before the next
choice, nothing else is (T 4.7, semantics 5).
"""

from __future__ import annotations

import heapq
import math

from rapc.compiler.dependencies import ANYTHING, WatchKey
from rapc.compiler.query import TermValue
from rapc.parser.printer import format_formula
from rapc.resources import Resource
from rapc.runtime.agenda import Agenda
from rapc.runtime.context import QueryContext
from rapc.runtime.events import DeadlineMissed, TaskBlocked, TaskWoken
from rapc.runtime.memory.facts import keys_of
from rapc.runtime.memory.memory import Memory
from rapc.runtime.recorder import Recorder
from rapc.runtime.task import Env, State, Task
from rapc.runtime.world import Time
from rapc.terms import Fact, Number, format_atom, number

_CROWD = 256
"""How many times may be waited for before stale ones are looked for."""


class Monitors:
    """All waiting for states and times in a run.

    Timers stand in one heap by time and task number; what is due is handed out by
    `due`. Tasks to be tested are collected in `_dirty` and tested by number.
    """

    def __init__(
        self,
        memory: Memory,
        context: QueryContext,
        recorder: Recorder,
        agenda: Agenda,
    ) -> None:
        self._context = context
        self._recorder = recorder
        self._agenda = agenda
        self._listeners: dict[WatchKey, dict[int, Task]] = {}
        self._keys: dict[int, list[WatchKey]] = {}
        self._dirty: dict[int, Task] = {}
        self._aging: dict[int, Task] = {}
        self._tested_at: Time = -1
        self._timers: list[tuple[Time, int, Task]] = []
        self._set: set[tuple[Time, int]] = set()
        self._crowded = _CROWD
        self._deadlines: list[tuple[float, int, Task]] = []
        self._stated: set[tuple[float, int]] = set()
        self._missed: dict[int, list[float]] = {}
        memory.changed = self._fact_changed
        memory.moved = self._word_changed

    # --- listening -------------------------------------------------------------

    def _fact_changed(self, fact: Fact) -> None:
        if self._listeners:
            for key in keys_of(fact):
                self._wake(key)
            self._wake(ANYTHING)

    def _word_changed(self, word: str) -> None:
        self._wake((word,))
        self._wake(ANYTHING)

    def resource_changed(self, resource: Resource) -> None:
        """A set or counter has changed: who asks about it is tested again."""
        self._wake(resource)

    def _wake(self, key: WatchKey) -> None:
        listeners = self._listeners.get(key)
        if listeners is not None:
            self._dirty.update(listeners)

    def _listen(self, task: Task) -> None:
        if task.watching:
            return
        task.watching = True
        keys: list[WatchKey] = []
        for watch in task.plan.watches:
            key = watch.resolve(task.env)
            if key is not None:
                self._listeners.setdefault(key, {})[task.number] = task
                keys.append(key)
            if watch.age is not None and watch.age not in task.env:
                self._aging[task.number] = task
        self._keys[task.number] = keys

    def forget(self, task: Task) -> None:
        """A task has ended: it listens to nothing any more, and waits for no time."""
        task.timer = None
        self._missed.pop(task.number, None)
        self._ignore(task)

    def _ignore(self, task: Task) -> None:
        self._dirty.pop(task.number, None)
        self._aging.pop(task.number, None)
        for key in self._keys.pop(task.number, ()):
            listeners = self._listeners.get(key)
            if listeners is not None:
                listeners.pop(task.number, None)
                if not listeners:
                    del self._listeners[key]

    def rebind(self, task: Task) -> None:
        """A task's bindings have got other names: listen to those, and test again."""
        if not task.watching:
            return
        self._ignore(task)
        task.watching = False
        self._listen(task)
        self._dirty[task.number] = task
        if task.state is State.BLOCKED and self._recorder.on:
            task.blocked_on = self.reason(task)

    # --- times -----------------------------------------------------------------

    def at(self, time: Time, task: Task) -> None:
        """Look at a task again when the clock has come to `time`, not before."""
        task.timer = time
        if (time, task.number) not in self._set:
            self._set.add((time, task.number))
            heapq.heappush(self._timers, (time, task.number, task))
            if len(self._timers) > self._crowded:
                self._tidy()

    def _tidy(self) -> None:
        """Drop times that nobody waits for, and deadlines no longer stated."""
        self._timers = [entry for entry in self._timers if entry[0] == entry[2].timer]
        self._set = {entry[:2] for entry in self._timers}
        stated = [e for e in self._deadlines if e[2].live and e[2].deadline == e[0]]
        self._deadlines = stated
        self._stated = {entry[:2] for entry in stated}
        heapq.heapify(self._timers)
        heapq.heapify(self._deadlines)
        self._crowded = max(_CROWD, 2 * len(self._timers), 2 * len(self._deadlines))

    def state_deadline(self, task: Task) -> None:
        """A task's own deadline has been set or has changed."""
        inherited = task.parent.limit if task.parent is not None else math.inf
        task.limit = min(inherited, task.deadline)
        if (
            task.deadline < math.inf
            and (task.deadline, task.number) not in self._stated
        ):
            self._stated.add((task.deadline, task.number))
            heapq.heappush(self._deadlines, (task.deadline, task.number, task))
            if len(self._deadlines) > self._crowded:
                self._tidy()

    def next_time(self) -> Time | None:
        """The next time at which something that is waited for comes, or None."""
        while self._timers and self._timers[0][0] != self._timers[0][2].timer:
            self._pop()
        return self._timers[0][0] if self._timers else None

    def _pop(self) -> tuple[Time, Task]:
        time, tasknumber, task = heapq.heappop(self._timers)
        self._set.discard((time, tasknumber))
        return time, task

    def due(self) -> list[Task]:
        """The tasks whose start time has come; others that are due are tested."""
        started = []
        now = self._recorder.time
        while self._timers and self._timers[0][0] <= now:
            time, task = self._pop()
            if time != task.timer:
                continue
            task.timer = None
            if task.state is State.WAITING:
                started.append(task)
            elif task.state in (State.BLOCKED, State.ELIGIBLE):
                self._dirty[task.number] = task
        return started

    def arm(self, task: Task, since: Time) -> None:
        """Set a task's `monitor-time`: `since` it was made or finished a method."""
        plan = task.plan.monitor_time
        if plan is None:
            return
        self._note_missed(task)
        self._context.task = task
        base = since if plan.reference == "now" else 0
        start = time_of(self._context, plan.start, task.env)
        stop = None if start is None else time_of(self._context, plan.stop, task.env)
        if start is None or stop is None:
            task.spoilt = True
            return
        task.ready_at = number(base + start)
        task.monitor_deadline = base + stop
        self.state_deadline(task)

    # --- testing ----------------------------------------------------------------

    def first_test(self, task: Task) -> None:
        """A monitored task may run as far as order and time go: test it first."""
        task.state = State.UNTESTED
        self._dirty[task.number] = task

    def settle(self) -> None:
        """Test all that may have changed, by task number; tell missed deadlines."""
        if self._aging and self._recorder.time != self._tested_at:
            self._dirty.update(self._aging)
        self._tested_at = self._recorder.time
        self._look_for_missed()
        if not self._dirty and not self._missed:
            return
        dirty, self._dirty = self._dirty, {}
        missed, self._missed = self._missed, {}
        for tasknumber in sorted(dirty.keys() | missed.keys()):
            if tasknumber in dirty:
                self._test(dirty[tasknumber])
            for deadline in missed.get(tasknumber, ()):
                self._tell_missed(tasknumber, deadline)

    def _look_for_missed(self) -> None:
        deadlines = self._deadlines
        while deadlines and deadlines[0][0] < self._recorder.time:
            deadline, tasknumber, task = heapq.heappop(deadlines)
            self._stated.discard((deadline, tasknumber))
            if task.live:
                self._note_missed(task)

    def _note_missed(self, task: Task) -> None:
        """Note that the clock has passed a task's deadline: once for each."""
        if task.deadline < self._recorder.time and task.deadline != task.missed:
            task.missed = task.deadline
            self._missed.setdefault(task.number, []).append(task.deadline)

    def _tell_missed(self, tasknumber: int, deadline: float) -> None:
        if self._recorder.on:
            self._recorder.emit(
                DeadlineMissed, task=tasknumber, deadline=number(deadline)
            )

    def _test(self, task: Task) -> None:
        """Test a task that is untested, blocked, or woken and not yet selected."""
        if task.after_method or task.state not in (
            State.UNTESTED,
            State.BLOCKED,
            State.ELIGIBLE,
        ):
            return
        if self.holds(task):
            if task.state is State.BLOCKED and self._recorder.on:
                self._recorder.emit(TaskWoken, task=task.number, on=task.blocked_on)
            if task.state is not State.ELIGIBLE:
                task.state = State.ELIGIBLE
                self._agenda.add(task)
        elif task.state is not State.BLOCKED:
            self._agenda.discard(task)
            self.block(task)

    def holds(self, task: Task) -> bool:
        """Whether a task's monitors hold now; listens for when that may change."""
        self._listen(task)
        task.timer = None
        if self._recorder.time < task.ready_at:
            self.at(task.ready_at, task)
            return False
        plan = task.plan.monitor_state
        if plan is None:
            return True
        context = self._context
        context.task = task
        context.horizon = []
        found = plan.holds(context, task.env)
        if context.horizon:
            self.at(min(context.horizon), task)
        context.horizon = None
        return found

    def block(self, task: Task) -> None:
        """A task cannot go on until its monitors hold; its loops start afresh."""
        task.state = State.BLOCKED
        task.choices.clear()
        if self._recorder.on:
            task.blocked_on = self.reason(task)
            self._recorder.emit(TaskBlocked, task=task.number, on=task.blocked_on)

    def reason(self, task: Task) -> str:
        """What a monitored task waits for: a time, or its formula as it is bound."""
        plan = task.plan.monitor_state
        if plan is None or self._recorder.time < task.ready_at:
            return f"time {format_atom(task.ready_at)}"
        bindings = {name: format_atom(value) for name, value in task.env.items()}
        return format_formula(plan.formula, bindings)


def time_of(context: QueryContext, term: TermValue, env: Env) -> Number | None:
    """A term as a time; None, with a fault traced, if it is unbound or no number."""
    value = term.needed(context, env)
    if value is None or isinstance(value, int | float):
        return value
    context.unfit(term.where, value, "a number")
    return None
