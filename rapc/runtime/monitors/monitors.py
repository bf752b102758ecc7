"""Monitors: the waits of blocked tasks, and their waking without polling.

A monitored task listens to the changes that can affect its formula, and to the times at
which beliefs in the formula go stale. Before the next choice, the interpreter tests
only the tasks with such a change [T 4.7; L 5].
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Final

from rapc.base.values import format_atom, number
from rapc.compiler.watches import WatchKey
from rapc.events import (
    DeadlineMissed,
    Deadlock,
    Event,
    TaskBlocked,
    TaskWoken,
)
from rapc.ir.printer import format_formula
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.monitors.listeners import Listeners
from rapc.runtime.monitors.times import Times, deadline_of, timer_of
from rapc.runtime.query_context import QueryContext, time_of
from rapc.runtime.state.agenda import Agenda
from rapc.runtime.state.deadlocks import Circle, deadlock_of, in_words
from rapc.runtime.state.states import BLOCKED, ELIGIBLE, UNTESTED, WAITING
from rapc.runtime.state.task import Task
from rapc.runtime.state.things import Things, ThingWait, words
from rapc.runtime.state.wait_state import WaitState
from rapc.world import Time

_NOW: Final = -math.inf


class Monitors:
    """All waits for states and times in a run.

    Tasks to be tested are collected and then tested by number.

    Args:
        context: the context that evaluates the formulas of monitors.
        recorder: receives the events about blocks, wakes and missed deadlines.
        agenda: receives the tasks that wake.
        things: the holds and waits; tasks that wait for things are tested here too.
    """

    def __init__(
        self,
        context: QueryContext,
        recorder: Recorder,
        agenda: Agenda,
        things: Things,
    ) -> None:
        self._context = context
        self._things = things
        self._thing_waits, self._things_to_test = things.waits, things.to_test
        self._recorder = recorder
        self._agenda = agenda
        self._timers = Times(timer_of)
        self._deadlines = Times(deadline_of)
        #: Missed deadlines without an event so far, by task number.
        self.missed: dict[int, list[float]] = {}
        #: The marked tasks: their monitors are to be tested; by number. The table is
        #: never replaced: the loop refers to it.
        self.to_test: dict[int, Task] = {}
        #: The tasks by the changes that they listen to; an observer of all changes.
        self.listeners = Listeners(self.to_test)
        #: Before this time nothing falls due; None if no task waits for a time.
        self.next_look: float | None = None
        #: The tasks whose monitors depend on the age of a belief, by number.
        self.aging: dict[int, Task] = {}
        #: The time of the last test of changed monitors while beliefs aged.
        self.tested_at: Time = -1

    def load(
        self,
        live: Iterable[Task],
        to_test: Mapping[int, Task],
        missed: dict[int, list[float]],
        tested_at: Time,
    ) -> None:
        """Replace all waits by those of the `live` tasks."""
        self.listeners.clear()
        self.aging = {}
        tasks = [task for task in live if task.wait is not None]
        for task in tasks:
            if task.wait is not None and task.wait.keys is not None:
                self._listen(task, task.wait)
        self._timers.load(tasks)
        self._deadlines.load(tasks)
        self.missed = missed
        self.to_test.clear()
        self.to_test.update(to_test)
        self.tested_at = tested_at
        self.next_look = _NOW

    # --- listening -------------------------------------------------------------

    def _listen(self, task: Task, wait: WaitState) -> None:
        keys: dict[WatchKey, None] = {}
        for watch in task.plan.watches:
            key = watch.resolve(task.env)
            if key is not None:
                keys[key] = None
            if watch.age is not None and watch.age not in task.env:
                self.aging[task.number] = task
                self.next_look = _NOW
        for key in keys:
            self.listeners.add(key, task)
        wait.keys = tuple(keys)

    def forget(self, task: Task) -> None:
        """Unregister an ended task from its listeners, times and tests."""
        wait = task.wait
        if wait is not None:
            wait.timer = None
            self.missed.pop(task.number, None)
            self._ignore(task, wait)

    def _ignore(self, task: Task, wait: WaitState) -> None:
        self.to_test.pop(task.number, None)
        self.aging.pop(task.number, None)
        for key in wait.keys or ():
            self.listeners.drop(key, task)
        wait.keys = None

    def rebind(self, task: Task) -> None:
        """Register a task again after a renaming in its bindings, to be tested."""
        wait = task.wait
        if wait is None or wait.keys is None:
            return
        wait.formula = None
        self._ignore(task, wait)
        self._listen(task, wait)
        self.to_test[task.number] = task
        if task.state is BLOCKED and self._recorder.on:
            wait.blocked_on = self._reason_to_tell(task)

    # --- times -----------------------------------------------------------------

    def at(self, time: Time, task: Task) -> None:
        """Test or start a task when the clock has reached `time`, not before."""
        assert task.wait is not None
        task.wait.timer = time
        self.look_by(time)
        self._timers.add(time, task)

    def look_by(self, time: float) -> None:
        """Schedule a check of due times for `time` at the latest."""
        if self.next_look is None or time < self.next_look:
            self.next_look = time

    def state_deadline(self, task: Task) -> None:
        """Register the deadline of a task, which has been set or has changed."""
        stated = math.inf if task.wait is None else task.wait.deadline
        inherited = math.inf if task.parent is None else task.parent.limit
        task.limit = min(inherited, stated)
        if stated < math.inf:
            self._deadlines.add(stated, task)
            self.look_by(stated)

    def next_time(self) -> Time | None:
        """Return the next time that a task waits for, or None."""
        return self._timers.soonest()

    def due(self) -> list[Task]:
        """Return the tasks whose start time has come; mark woken tasks for a test."""
        started = []
        for task in self._timers.due(self._recorder.time):
            assert task.wait is not None
            task.wait.timer = None
            if task.state is WAITING:
                started.append(task)
            elif task.state is BLOCKED or task.state is ELIGIBLE:
                self.to_test[task.number] = task
        return started

    def arm(self, task: Task, since: Time) -> None:
        """Set a task's `monitor-time`; `since` is its creation or its method's end."""
        plan, wait = task.plan.monitor_time, task.wait
        if plan is None or wait is None:
            return
        if self._misses(task):
            self.next_look = _NOW
        self._context.task = task
        base = since if plan.reference == "now" else 0
        start = time_of(self._context, plan.start, task.env)
        stop = None if start is None else time_of(self._context, plan.stop, task.env)
        if start is None or stop is None:
            wait.setup_failed = True
            return
        wait.ready_at = number(base + start)
        wait.monitor_deadline = base + stop
        self.state_deadline(task)

    # --- testing ----------------------------------------------------------------

    def first_test(self, task: Task) -> None:
        """Mark a task for a test; its order and time allow its start."""
        task.state = UNTESTED
        self.to_test[task.number] = task

    def test_marked(self) -> None:
        """Test all marked tasks, by task number; report missed deadlines."""
        missed = self.next_look is not None and self._look_at_times()
        if self.aging:
            self.tested_at = self._recorder.time
        if missed or self._things_to_test:
            self._test_with_things()
        elif len(self.to_test) == 1:
            self._test(self.to_test.popitem()[1])
        elif self.to_test:
            marked = dict(self.to_test)
            self.to_test.clear()
            for task_number in sorted(marked):
                self._test(marked[task_number])
        if self.next_look is not None:
            self._look_ahead()

    def _look_at_times(self) -> bool:
        """Mark tasks with aging beliefs; return whether there are missed deadlines."""
        now = self._recorder.time
        if self.aging and now != self.tested_at:
            self.to_test.update(self.aging)
        for task in self._deadlines.due(now, passed=True):
            self._misses(task)
        return bool(self.missed)

    def _misses(self, task: Task) -> bool:
        """Record a newly missed deadline of a task; return whether there was one."""
        stated = deadline_of(task)
        if task.wait is None or stated is None or stated >= self._recorder.time:
            return False
        task.wait.missed = stated
        self.missed.setdefault(task.number, []).append(stated)
        return True

    def _test_with_things(self) -> None:
        """Test things and monitors, and report missed deadlines, by task number."""
        marked, blocked = dict(self.to_test), dict(self._things_to_test)
        self.to_test.clear()
        self._things_to_test.clear()
        missed, self.missed = self.missed, {}
        for task_number in sorted(marked.keys() | missed.keys() | blocked.keys()):
            task = blocked.get(task_number)
            woken = task is not None and self._test_thing_wait(task)
            if task_number in marked and not woken:
                self._test(marked[task_number])
            for deadline in missed.get(task_number, ()):
                self._emit_missed(task_number, deadline)

    def _look_ahead(self) -> None:
        """Compute the next time at which something may fall due."""
        self.next_look = _NOW if self.aging or self.missed else None
        for times in (self._timers, self._deadlines):
            if times.heap:
                self.look_by(times.heap[0][0])

    def _emit_missed(self, task_number: int, deadline: float) -> None:
        if self._recorder.on:
            self._recorder.emit(
                DeadlineMissed, task=task_number, deadline=number(deadline)
            )

    def _test(self, task: Task) -> None:
        """Test a task that is untested, blocked, or woken and not yet selected."""
        state, wait = task.state, task.wait
        if (
            wait is None
            or wait.after_method
            or not (state is BLOCKED or state is UNTESTED or state is ELIGIBLE)
            or (
                self._thing_waits
                and task.number in self._thing_waits
                and state is BLOCKED
            )
        ):
            return
        if self.holds(task, wait):
            if state is BLOCKED and self._recorder.on:
                on = wait.blocked_on or self._reason_to_tell(task)
                self._recorder.emit(TaskWoken, task=task.number, on=on)
            if state is not ELIGIBLE:
                task.state = ELIGIBLE
                self._agenda.add(task)
        elif state is not BLOCKED:
            self._agenda.discard(task)
            self.block(task)

    def _test_thing_wait(self, task: Task) -> bool:
        """Wake a task with free things; block a woken task without free things.

        Return whether the task was woken: then its monitors have been tested too.
        """
        wait = self._thing_waits.get(task.number)
        if wait is None:
            return False
        obstacle = self._things.obstacle_of(wait)
        if wait.skills:
            if obstacle is None:
                self._things.resumable[task.number] = task
            return False
        if wait.woken:
            if obstacle is not None:
                self._agenda.discard(task)
                wait.woken, task.state = False, BLOCKED
                if task.wait is not None:
                    task.wait.timer = None
                wait.on, wait.holder = words(obstacle), obstacle.run.task.number
                self.tell_blocked(wait)
        elif obstacle is None:
            wait.woken = True
            self._emit_thing_wait(TaskWoken, wait)
            monitors = task.wait if task.plan.monitored else None
            if monitors is not None and not self.holds(task, monitors):
                self.block(task)
            else:
                task.state = ELIGIBLE
                self._agenda.add(task)
            return True
        return False

    def tell_blocked(self, wait: ThingWait) -> None:
        """Report that a thing blocks a task, and the deadlock that the block closes."""
        self._emit_thing_wait(TaskBlocked, wait)
        if self._recorder.on:
            self.tell_deadlock(deadlock_of(self._things, wait))

    def tell_deadlock(self, found: Circle) -> None:
        """Report a deadlock that has closed, if any."""
        if found and self._recorder.on:
            tasks = tuple([wait.task.number for wait, _ in found])
            self._recorder.emit(Deadlock, tasks=tasks, waiting=in_words(found))

    def _emit_thing_wait(self, kind: type[Event], wait: ThingWait) -> None:
        if self._recorder.on:
            self._recorder.emit(
                kind, task=wait.task.number, on=wait.on, holder=wait.holder
            )

    def still_hold(self, task: Task, wait: WaitState) -> bool:
        """Return whether the monitors of a selected task hold.

        Most monitors were tested before the choice. This method tests again only after
        a change since then, or if the task is selected after its method.
        """
        if wait.after_method or wait.keys is None or task.number in self.to_test:
            wait.after_method = False
            return self.holds(task, wait)
        return True

    def holds(self, task: Task, wait: WaitState) -> bool:
        """Return whether a task's monitors hold now; listen to later changes."""
        if wait.keys is None:
            self._listen(task, wait)
        if self.to_test:
            self.to_test.pop(task.number, None)
        wait.timer = None
        if self._recorder.time < wait.ready_at:
            self.at(wait.ready_at, task)
            return False
        plan = task.plan.monitor_state
        if plan is None:
            return True
        context = self._context
        context.task = task
        if not task.plan.ages:
            return context.bound[plan].holds(task.env)
        context.horizon = []
        found = context.bound[plan].holds(task.env)
        if context.horizon:
            self.at(min(context.horizon), task)
        context.horizon = None
        return found

    def block(self, task: Task) -> None:
        """Block a task until its monitors hold; reset its futile-loop detector."""
        task.state = BLOCKED
        if self._thing_waits:
            self._things.stop_waiting(task)
        task.forget_choices()
        if self._recorder.on and task.wait is not None:
            task.wait.blocked_on = on = self._reason_to_tell(task)
            self._recorder.emit(TaskBlocked, task=task.number, on=on)

    def reason(self, task: Task) -> str:
        """Return the wait of a monitored task as text: a time, or its formula as bound.

        The method changes nothing: observers may call it.
        """
        plan, wait = task.plan.monitor_state, task.wait
        ready_at = 0 if wait is None else wait.ready_at
        if plan is None or self._recorder.time < ready_at:
            return f"time {format_atom(ready_at)}"
        if wait is None or wait.formula is None:
            return format_formula(plan.formula, task.env)
        return wait.formula

    def _reason_to_tell(self, task: Task) -> str:
        """Return the reason for an event; keep the text of a formula.

        A task that listens is rebound when names change (`rebind`): its text stays
        valid.
        """
        plan, wait = task.plan.monitor_state, task.wait
        if (
            plan is not None
            and wait is not None
            and wait.formula is None
            and self._recorder.time >= wait.ready_at
            and not task.has_resources()
        ):
            wait.formula = format_formula(plan.formula, task.env)
        return self.reason(task)
