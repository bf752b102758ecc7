"""A machine: the parts of a run that its procedures share, wired to each other.

Nothing is decided here: the verbs in `tasks`, `monitors`, `acts` and `intake` act on a
machine, `interpreter` builds one, `loop` turns it. How far the run has come stands
apart, in `RunState`, so that it can be saved, put back and copied.
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
from rapc.runtime.query_context import NotingContext, QueryContext
from rapc.runtime.settings import Settings
from rapc.runtime.state.agenda import Agenda
from rapc.runtime.state.run_state import RunState
from rapc.runtime.state.things import Things
from rapc.world import ResultHandler, Time

ContextListener = Callable[[str, str, bool], None]
"""Told of a RAP's method whose context was asked, and whether it held."""


class Machine:
    """All parts of one run.

    Args:
        library: the compiled library; `extend` puts another in its place.
        world: the world.
        rng: the interpreter's random stream.
        settings: those of the interpreter.
        functions: the registered functions, by name.
        solvers: the problem solvers, by RAP.
        comparators: the registered comparators, by name.
    """

    def __init__(
        self,
        library: Program,
        world: HeldWorld,
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
        self.state = RunState()  # `Interpreter.restore` puts another in its place
        self.recorder = Recorder()
        self.recorder.time = number(world.now())
        #: Memory as handlers change it; the two below are parts of it.
        self.access = Gate(
            library.library,
            library.signatures,
            self.recorder,
            comparators,
            settings.max_layers,
        )
        self.memory, self.recognizer = self.access.memory, self.access.recognizer
        asked = self.memory, self.recorder, functions, settings.query_steps
        self.context = QueryContext(*asked)
        #: Asks what kept a task from going on, without leaving a mark on the run.
        self.noting = NotingContext(*asked)
        self.agenda = Agenda(rng)
        self.things = Things()
        self.held, self.waits = self.things.held, self.things.waits  # parts of them
        self.monitors = Monitors(self.context, self.recorder, self.agenda, self.things)
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
        self.all_may_recur = bool(solvers)
        self.handlers = world.kit.handlers
        self.result_handlers: dict[Atom, ResultHandler] = {}
        self.result_handlers.update(self.handlers.results)

    def sync_clock(self) -> None:
        """Take the time from the world; for the run it stops at `until`."""
        now = self.world.clock()
        if now != self.recorder.time or self.state.until is not None:
            self.set_clock(now)

    def set_clock(self, now: Time) -> bool:
        """Set the run's clock to `now`, capped at `until`; return if it was capped.

        Raises:
            PortError: for what is no time, or before the time it was.
        """
        before, until = self.recorder.time, self.state.until
        now = self.world.time(now, before)
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
