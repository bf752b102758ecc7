"""The parts of a run that its procedures share, put in one place.

Nothing is decided here: `cycle`, `endings`, `monitors` and `requests` act on a
machine, `interpreter` builds one and turns its crank.
"""

from __future__ import annotations

import heapq
import random
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from rapc.base.values import Atom
from rapc.compiler.program import Program
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.build import assemble
from rapc.runtime.monitors.monitors import Monitors
from rapc.runtime.query_context import QueryContext
from rapc.runtime.settings import Settings
from rapc.runtime.state.agenda import Agenda
from rapc.runtime.state.task import Task, TopLevelTask
from rapc.runtime.task_request import TaskRequest
from rapc.world import ResultHandler, Time, World

ContextListener = Callable[[str, str, bool], None]
"""Told of a RAP's method whose context was asked, and whether it held."""


class Machine:
    """The shared state of one run.

    `live_top` are the live top-level tasks by number; `pending` those with requests
    under way, by ticket (None once the task is gone); `listening` the steps that wait
    for a signal, by the signal's name; `active_identities` how many tasks of each
    identity are at work on a method. `top_level` are the top-level tasks so far and
    `scheduled` those for later, of which `expected` are to keep the run going;
    `foreground` counts the live ones that do, `succeeded` the tasks of all levels that
    have ended well. `numbers` tasks and `tickets` requests were counted so far, from 1.
    The choice of a method `is_plain` if no solver may help and `context_asked` is not
    to be told of it.
    """

    def __init__(
        self,
        library: Program,
        world: World,
        rng: random.Random,
        settings: Settings,
        functions: Mapping[str, Callable[..., Any]],
        solvers: Mapping[str, Callable[..., Any]],
        comparators: Mapping[str, Callable[..., Any]],
    ) -> None:
        self.library = library
        self.world = world
        self.settings = settings
        self.solvers = solvers
        self.rng = rng
        self.recorder = Recorder()
        self.recorder.time = world.now()
        parts = assemble(
            library.library,
            library.vocabulary,
            self.recorder,
            comparators,
            settings.max_layers,
        )
        self.memory = parts.memory
        self.access = parts.access
        self.recognizer = parts.recognizer
        self.context = QueryContext(self.memory, self.recorder, functions)
        self.agenda = Agenda(rng)
        self.monitors = Monitors(self.context, self.recorder, self.agenda)
        self.memory.observe(self.monitors)
        self.live_top: dict[int, TopLevelTask] = {}
        self.pending: dict[int, tuple[Task | None, tuple[Any, ...]]] = {}
        self.listening: dict[str, dict[int, Task]] = {}
        self.active_identities: dict[object, int] = {}
        self.top_level: list[TopLevelTask] = []
        self.scheduled: list[tuple[Time, int, TaskRequest]] = []
        self.expected = 0
        self.foreground = 0
        self.succeeded = 0
        self.over = False
        self.until: Time | None = None
        self.past_until = False
        self.host_timers: list[tuple[Time, int, Callable[[], None]]] = []
        self.context_asked: ContextListener | None = None
        self.is_plain = not solvers
        self.handlers = world.handlers()
        self.result_handlers: dict[Atom, ResultHandler] = {}
        self.result_handlers.update(self.handlers.results)
        self.numbers = 0
        self.tickets = 0
        self._overlay: dict[str, list[MethodPlan]] = {}

    def sync_clock(self) -> None:
        """Take the time from the world; for the run it stops at `until`."""
        now = self.world.now()
        if now != self.recorder.time or self.until is not None:
            self.set_clock(now)

    def set_clock(self, now: Time) -> None:
        """It is so late in the world; for the run time stops at `until`."""
        until = self.until
        self.past_until = until is not None and now > until
        self.recorder.time = now if until is None else min(now, until)

    def run_host_timers(self) -> None:
        """Do what the host wants done by now, in the order of its times."""
        due = self.host_timers
        while due and due[0][0] <= self.recorder.time:
            heapq.heappop(due)[2]()

    def live_tasks(self) -> list[Task]:
        """All tasks of the run that have not ended, by number."""
        found = [given.task for given in self.live_top.values()]
        for task in found:
            if task.run is not None:
                found.extend(s for s in task.run.steps if s.number and s.live)
        found.sort(key=lambda task: task.number)
        return found

    def recount_identities(self) -> None:
        """Count anew which identities are at work: items have got other names."""
        at_work = [task for task in self.live_tasks() if task.run is not None]
        counted = [task for task in at_work if self.may_recur(task.plan)]
        self.active_identities = dict(Counter(task.identity for task in counted))

    def may_recur(self, plan: RapPlan) -> bool:
        """Whether a RAP can come up among its own subtasks; solvers may bring it in."""
        return plan.recursive or bool(self.solvers)

    def methods(self, plan: RapPlan) -> tuple[MethodPlan, ...]:
        """A RAP's methods with those that solvers have added in this run."""
        if not self._overlay:
            return plan.methods
        return (*plan.methods, *self._overlay.get(plan.name, ()))

    def add_method(self, plan: RapPlan, method: MethodPlan) -> None:
        """A solver's method joins the RAP for the rest of the run."""
        self._overlay.setdefault(plan.name, []).append(method)
