"""The state of a run, apart from the parts that act on it.

A saved run consists of this state, the tasks reached from here, and the saved fields of
memory, agenda, monitors and recorder; `rapc.runtime.saving` combines them. Nothing here
can be called. Not here: the registrations of a host (listeners, timers), which are not
saved (`rapc.runtime.run`).
"""

from __future__ import annotations

import heapq
from typing import ClassVar

from rapc.base.values import Fact
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.runtime.fields import LEFT_OUT, Fields, Natural
from rapc.runtime.state.activations import Activations
from rapc.runtime.state.task import Task, TopLevelTask
from rapc.runtime.task_request import TaskRequest
from rapc.world import Time


class RunState:
    """The progress of a run; a new state is that of a run before its start."""

    FIELDS: ClassVar[Fields] = {
        "top_level": list[TopLevelTask],
        "live_top": LEFT_OUT,
        "foreground": LEFT_OUT,
        "scheduled": list[tuple[Time, int, TaskRequest]],
        "expected": LEFT_OUT,
        "requests": Natural,
        "pending": dict[int, tuple[Task | None, Fact]],
        "activations": Activations,
        "resources": LEFT_OUT,
        "listening": LEFT_OUT,
        "running_goals": LEFT_OUT,
        "added_methods": LEFT_OUT,
        "numbers": Natural,
        "tickets": Natural,
        "succeeded": Natural,
        "moved_at": int,
        "idle_waits": Natural,
        "received": bool,
        "until": Time | None,
        "past_until": bool,
        "picture": str,
        "started": bool,
        "stops": LEFT_OUT,
        "reason": str | None,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self) -> None:
        #: The top-level tasks so far, in the order in which they came.
        self.top_level: list[TopLevelTask] = []
        #: The top-level tasks that have not ended, by number.
        self.live_top: dict[int, TopLevelTask] = {}
        #: How many of these tasks keep the run going; the others are background tasks.
        self.foreground = 0
        #: The tasks for later: a heap by time, then by the order in which they came.
        self.scheduled: list[tuple[Time, int, TaskRequest]] = []
        #: How many of the tasks for later keep the run going.
        self.expected = 0
        #: How many tasks for later and timers of the host have been registered.
        self.requests = 0
        #: The requests under way by ticket: the task, None once it has left, and the
        #: request, in memory names.
        self.pending: dict[int, tuple[Task | None, Fact]] = {}
        #: The active skills of methods.
        self.activations = Activations()
        #: How many sets and counters live tasks have.
        self.resources = 0
        #: The steps that wait for a signal, by the signal's name and task number.
        self.listening: dict[str, dict[int, Task]] = {}
        #: How many tasks of each goal key have a method under way.
        self.running_goals: dict[object, int] = {}
        #: The methods that solvers have added, by RAP.
        self.added_methods: dict[str, list[MethodPlan]] = {}
        #: How many tasks have been numbered, from 1.
        self.numbers = 0
        #: How many requests the world has received, from 1.
        self.tickets = 0
        #: How many tasks of all levels have succeeded.
        self.succeeded = 0
        #: The cycle in which the clock last moved, minus the number of later waits
        #: without a move: such a wait counts like an idle cycle.
        self.moved_at = 0
        #: The number of waits since the last cycle.
        self.idle_waits = 0
        #: Whether the present pass of the loop has read the clock and the messages.
        self.received = False
        #: The time limit of the run, if there is one.
        self.until: Time | None = None
        #: Whether the world's clock has passed `until`.
        self.past_until = False
        #: The last picture in the trace, as JSON; empty before the first.
        self.picture = ""
        #: Whether the run has begun, and the reason why it is over.
        self.started = False
        self.reason: str | None = None
        #: Whether the loop stops before its next cycle: at the end of the run, or when
        #: the host interrupts it.
        self.stops = False

    def settle(self) -> None:
        """Compute the fields that follow from the fields that have been set."""
        self.live_top = {g.task.number: g for g in self.top_level if g.task.live}
        self.foreground = sum(not g.background for g in self.live_top.values())
        heapq.heapify(self.scheduled)
        self.expected = sum(not entry[2].background for entry in self.scheduled)
        self.stops = self.reason is not None
        for task in self.live_tasks():
            self.resources += task.resources
            if task.step is not None and task.wait is not None and not task.waiting:
                for wait in task.step.waits:
                    self.listening.setdefault(wait.signal, {})[task.number] = task
        for one in self.activations.on.values():
            one.run = None if one.task is None else one.task.run
        for one in self.activations.off.values():
            one.run = None

    def live_tasks(self) -> list[Task]:
        """Return all tasks of the run that have not ended, by number."""
        found = [given.task for given in self.live_top.values()]
        for task in found:
            if task.run is not None:
                found.extend(s for s in task.run.steps if s.number and s.live)
        found.sort(key=lambda task: task.number)
        return found

    def methods(self, plan: RapPlan) -> tuple[MethodPlan, ...]:
        """Return a RAP's methods with those that solvers have added in this run."""
        if not self.added_methods:
            return plan.methods
        return (*plan.methods, *self.added_methods.get(plan.name, ()))
