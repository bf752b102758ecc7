"""A run: its state and the parts that act on it, wired to each other.

Nothing is decided here: the verbs in `tasks` and `monitors` act on a run. What a host
may do to one, and its loop, are in `rapc.runtime.interpreter`. How far the run has come
stands apart, in `RunState`, so that it can be saved, put back and copied.
"""

from __future__ import annotations

import heapq
import random
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

from rapc.base.values import Atom, number
from rapc.compiler.program import Program
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.held_world import HeldWorld
from rapc.runtime.memory.gate import Gate
from rapc.runtime.monitors.monitors import Monitors
from rapc.runtime.query_context import QueryContext
from rapc.runtime.settings import Settings
from rapc.runtime.state.agenda import Agenda
from rapc.runtime.state.run_state import RunState
from rapc.runtime.state.things import Things
from rapc.world import ResultHandler, Time

ContextListener = Callable[[str, str, bool], None]
"""Told of a RAP's method whose context was asked, and whether it held."""


class Run:
    """One run of a library in a world.

    Args:
        library: the compiled library; `extend` puts another in its place.
        port: the world, held to what it declares, with the code of its authors.
        seed: the interpreter's random stream is made from it.
        settings: those of the interpreter.
    """

    def __init__(
        self, library: Program, port: HeldWorld, seed: int, settings: Settings
    ) -> None:
        self.library = library
        self.port = port
        self.seed = seed
        self.settings = settings
        self.solvers = port.code["the solver of"]
        self.rng = random.Random(f"{seed}:interpreter")
        self.state = RunState()  # `restore` puts another in its place
        self.recorder = Recorder()
        self.recorder.time = number(port.now())
        comparators: Mapping[str, Callable[..., Any]] = port.code["the comparator"]
        #: Memory as handlers change it; the two below are parts of it.
        self.access = Gate(
            library.library,
            library.signatures,
            self.recorder,
            comparators,
            settings.max_layers,
        )
        self.beliefs, self.recognizer = self.access.memory, self.access.recognizer
        functions = port.code["the function"]
        asked = self.beliefs, self.recorder, functions, settings.query_steps
        self.context = QueryContext(*asked)
        #: Asks what kept a task from going on, without leaving a mark on the run.
        self.noting = QueryContext(*asked, quiet=True)
        #: The tasks that may run now.
        self.eligible = Agenda(self.rng)
        self.things = Things()
        self.held, self.waits = self.things.held, self.things.waits  # parts of them
        self.monitors = Monitors(
            self.context, self.recorder, self.eligible, self.things
        )
        self.access.observe(self.monitors.listeners)
        #: What the host wants done at a time: a heap by time, then by order.
        self.host_timers: list[tuple[Time, int, Callable[[], None]]] = []
        #: What the host wants done when the run is over, and each time that it waits.
        self.at_end: list[Callable[[], None]] = []
        self.when_waiting: list[Callable[[], None]] = []
        #: Whether the loop is turning, and whether it broke off in the midst of that.
        self.turning = self.broken = False
        #: Told of each context that is asked, for coverage.
        self.context_asked: ContextListener | None = None
        #: Whether any RAP can come up among its own subtasks: a solver may bring it
        #: in. Without solvers only those whose plans are `recursive` can.
        self.all_may_recur = bool(self.solvers)
        self.handlers = port.kit.handlers
        self.result_handlers: dict[Atom, ResultHandler] = {}
        self.result_handlers.update(self.handlers.results)

    def sync_clock(self) -> None:
        """Take the time from the world; for the run it stops at `until`."""
        now = self.port.clock()
        if now != self.recorder.time or self.state.until is not None:
            self.set_clock(now)

    def set_clock(self, now: Time) -> bool:
        """Set the run's clock to `now`, capped at `until`; return if it was capped.

        Raises:
            PortError: for what is no time, or before the time it was.
        """
        before, until = self.recorder.time, self.state.until
        now = self.port.time(now, before)
        self.monitors.listeners.changes += now != before
        self.state.past_until = until is not None and now > until
        self.recorder.time = now if until is None else min(now, until)
        return self.state.past_until

    def waited_in_vain(self) -> bool:
        """Whether the run has waited as often in a row as it may without a cycle."""
        return self.state.waits >= self.settings.idle_waits

    def run_host_timers(self) -> None:
        """Do what the host wants done by now, in the order of its times."""
        due = self.host_timers
        while due and due[0][0] <= self.recorder.time:
            heapq.heappop(due)[2]()

    def recount_identities(self) -> None:
        """Count anew which identities are at work: items have got other names."""
        at_work = [task for task in self.state.live_tasks() if task.run is not None]
        counted = [
            task for task in at_work if task.plan.recursive or self.all_may_recur
        ]
        self.state.active_identities = dict(Counter(task.identity for task in counted))
