"""A run: its state and the connected parts that act on the state.

A run makes no decisions: the functions in `tasks` and `monitors` act on it. Not here:
the loop (`rapc.runtime.tasks.loop`) and the interface for a host
(`rapc.runtime.interpreter`).

The progress of a run stands in several parts: `state` (`RunState`), `eligible`,
`things`, `monitors`, `access`, `recorder` and `rng`. A saved run contains these parts
(`rapc.runtime.saving.runs`). All other parts come from the library, the world, the
settings and the host.
"""

from __future__ import annotations

import heapq
import random
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from rapc.base.values import Atom, number
from rapc.compiler.program import Program
from rapc.runtime.answers import Answers
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.held_world import HeldWorld
from rapc.runtime.memory.access import MemoryAccess
from rapc.runtime.monitors.monitors import Monitors
from rapc.runtime.planner import Planned, Planner
from rapc.runtime.query_context import QueryContext
from rapc.runtime.settings import Settings
from rapc.runtime.state.agenda import Agenda
from rapc.runtime.state.run_state import RunState
from rapc.runtime.state.task import Task
from rapc.runtime.state.things import Things
from rapc.world import ResultHandler, Time

ContextListener = Callable[[str, str, bool], None]
"""A listener to evaluated contexts of methods: the RAP, the method, the result."""


class Run:
    """One run of a library in a world.

    Args:
        library: the compiled library; `extend` replaces it.
        port: the world with checks of its declarations, and the code of its authors.
        seed: the seed of the interpreter's random stream.
        settings: the settings of the interpreter.
    """

    #: Makes the handler of a result or datum that has changes of memory as data.
    changing: Callable[..., Any]

    def __init__(
        self, library: Program, port: HeldWorld, seed: int, settings: Settings
    ) -> None:
        self.library = library
        self.port = port
        self.seed = seed
        self.settings = settings
        self.solvers = port.code["the solver of"]
        self.rng = random.Random(f"{seed}:interpreter")
        self.state = RunState()  # `restore` replaces it
        self.recorder = Recorder()
        self.recorder.time = number(port.now())
        #: The memory as handlers and hosts change it, and two parts of it: the facts
        #: with their rules, and the recogniser of items.
        self.access = empty_memory(self)
        self.beliefs, self.recognizer = self.access.memory, self.access.recognizer
        #: Evaluates the queries of tasks.
        self.context = self.new_context()
        #: Evaluates queries of explanations and costs of plans, without side effects.
        self.explaining_context = self.new_context(quiet=True)
        #: The eligible tasks.
        self.eligible = Agenda(self.rng)
        self.things = Things()
        #: Two parts of `things`.
        self.held, self.thing_waits = self.things.held, self.things.waits
        self.monitors = Monitors(
            self.context, self.recorder, self.eligible, self.things
        )
        self.access.observe(self.monitors.listeners)
        #: The kept answers of solvers and of a world that cannot be saved, if wanted.
        self.answers: Answers | None = None
        #: Finds methods for RAPs with `(plan)`; None without a planner.
        self.planner: Planner | None = None
        #: The task that has last asked the planner, and the answer.
        self.planned: tuple[Task, Planned] | None = None
        #: The host's actions at times: a heap by time, then by order.
        self.host_timers: list[tuple[Time, int, Callable[[], None]]] = []
        #: The host's actions at the end of the run, and at each wait.
        self.at_end: list[Callable[[], None]] = []
        self.when_waiting: list[Callable[[], None]] = []
        #: Whether the loop is running, and whether an error has aborted it.
        self.in_loop = self.broken = False
        #: Whether the loop waits for the world's clock or for a planner: an exception
        #: raised there leaves the tasks consistent.
        self.in_wait = False
        #: Whether time has passed or messages have arrived between two cycles; reset
        #: only by `come_to_arrival`.
        self.arrived = False
        #: Receives each evaluated context of a method, for coverage.
        self.context_listener: ContextListener | None = None
        #: Whether any RAP can recur below itself: a solver may add the recursion.
        #: Without solvers only RAPs with `recursive` plans can.
        self.all_may_recur = bool(self.solvers)
        self.handlers = port.kit.handlers
        self.result_handlers: dict[Atom, ResultHandler] = {}
        self.result_handlers.update(self.handlers.results)
        #: The objects that each pass of the loop reads; never replaced. One tuple is
        #: faster than seven fields when a host steps through a run.
        self.read_by_loop = (
            self.recorder,
            self.eligible,
            self.monitors,
            self.monitors.to_test,
            self.things.to_test,
            self.host_timers,
            self.recognizer.unsettled,
        )

    def new_context(self, quiet: bool = False) -> QueryContext:
        """Return a context for queries over memory; `quiet`: see `QueryContext`."""
        functions, steps = self.port.code["the function"], self.settings.query_steps
        return QueryContext(self.beliefs, self.recorder, functions, steps, quiet)

    def sync_clock(self) -> None:
        """Take the time from the world; the clock of the run stops at `until`."""
        now = self.port.clock()
        if now != self.recorder.time or self.state.until is not None:
            self.set_clock(now)

    def set_clock(self, now: Time) -> bool:
        """Set the run's clock to `now`, capped at `until`; return whether capped.

        Raises:
            PortError: for an invalid time, or a time before the present time.
        """
        before, until = self.recorder.time, self.state.until
        now = self.port.time(now, before)
        if now != before:
            self.monitors.listeners.changes += 1
            self.state.moved_at = self.recorder.cycle
        self.state.past_until = until is not None and now > until
        self.recorder.time = now if until is None else min(now, until)
        return self.state.past_until

    def waited_in_vain(self) -> bool:
        """Return whether the run has reached the limit of waits without a cycle."""
        return self.state.idle_waits >= self.settings.idle_waits

    def run_host_timers(self) -> None:
        """Call the host's actions that are due, in the order of their times."""
        due = self.host_timers
        while due and due[0][0] <= self.recorder.time:
            heapq.heappop(due)[2]()

    def recount_running_goals(self) -> None:
        """Count the running goals again after a renaming of items."""
        at_work = [task for task in self.state.live_tasks() if task.run is not None]
        counted = [
            task for task in at_work if task.plan.recursive or self.all_may_recur
        ]
        self.state.running_goals = dict(Counter(task.goal_key for task in counted))


def empty_memory(run: Run) -> MemoryAccess:
    """Return an empty memory for the library of a run."""
    library = run.library
    comparators: Mapping[str, Callable[..., Any]] = run.port.code["the comparator"]
    return MemoryAccess(
        library.library,
        library.signatures,
        run.recorder,
        comparators,
        run.settings.max_layers,
    )
