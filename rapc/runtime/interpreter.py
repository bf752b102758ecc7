"""The interpreter: a library, a world and tasks put together and run.

What a host may do to a run, before it and while it goes on. How the parts of a run are
made is in `rapc.runtime.put_together`, how it goes on in `rapc.runtime.loop`.
"""

from __future__ import annotations

import copy
import heapq
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NoReturn

from rapc.base.values import Atom, Fact
from rapc.compiler.program import Program
from rapc.errors import ArgumentError, PortError
from rapc.events import Event, Goal, TaskResult
from rapc.ir.nodes import Formula, Node
from rapc.parser.parse import parse_formula
from rapc.runtime import snapshot
from rapc.runtime.admission import refuse_extension, refuse_tasks
from rapc.runtime.arguments import (
    kind,
    need_atoms,
    need_call,
    need_count,
    need_fact,
    need_program,
    need_seed,
    need_settings,
    need_table,
    need_task,
    need_time,
    need_world,
)
from rapc.runtime.authors import code_of_authors
from rapc.runtime.begin_and_end import end_run, tell_start
from rapc.runtime.events.recorder import Listener, Recording
from rapc.runtime.host_query import HostQuery
from rapc.runtime.loop import Loop
from rapc.runtime.machine import ContextListener, Machine
from rapc.runtime.memory.gate import MemoryView
from rapc.runtime.put_together import put_together
from rapc.runtime.saving.save import restore, save
from rapc.runtime.settings import Settings
from rapc.runtime.snapshot import AgendaEntry
from rapc.runtime.task_request import TaskRequest, read_task_request
from rapc.runtime.tasks.remove import cancel_matching
from rapc.runtime.tasks.signals import signal
from rapc.runtime.tasks.start import create_top
from rapc.spec import RunSpec
from rapc.world import Time, World


class Interpreter:
    """One run of a compiled library against a world.

    Args:
        library: the compiled library.
        world: the world, freshly made.
        seed: the run's seed; the interpreter's random stream is made from it.
        settings: see `Settings`.
        functions: callables by registered name, besides those the world registers;
            each gets a `MemoryView` and then its arguments, a default function the
            property's index as a tuple.
        solvers: problem solvers by RAP name; each gets the goal and a `MemoryView`
            and returns methods (T 7.4.1).
        comparators: comparators of descriptions by registered name (T A.5), besides
            those of the world: see `rapc.world.Kit`.

    Raises:
        RefusedError: if the library cannot run in this world, before anything happens.
    """

    def __init__(
        self,
        library: Program,
        world: World,
        seed: int = 0,
        settings: Settings | None = None,
        functions: Mapping[str, Callable[..., Any]] | None = None,
        solvers: Mapping[str, Callable[..., Any]] | None = None,
        comparators: Mapping[str, Callable[..., Any]] | None = None,
    ) -> None:
        need_program(library, "`library`")
        need_world(world)
        need_seed(seed)
        need_table(functions, "`functions`")
        need_table(solvers, "`solvers`")
        need_table(comparators, "`comparators`")
        self.seed = seed
        self._registered = (functions, solvers, comparators)
        self._world = world
        if settings is None:
            settings = Settings()
        need_settings(settings)
        code = code_of_authors(world.kit, functions, solvers, comparators)
        self._machine = put_together(library, world, seed, settings, code)
        self._loop = Loop(self._machine)

    # --- before and while it runs -------------------------------------------------

    @property
    def memory(self) -> MemoryView:
        """Return what the robot believes, to be read."""
        return self._machine.context.view

    @property
    def world(self) -> World:
        """The world of the run: `run.world.figures()`, say, if it has figures."""
        return self._world

    @property
    def machine(self) -> Machine:
        """The parts of the run, for tools that look into it: they change nothing."""
        return self._machine

    @property
    def now(self) -> Time:
        """Return the time of the world's clock, as last looked at."""
        return self._machine.recorder.time

    @property
    def settings(self) -> Settings:
        """The settings of the interpreter."""
        return self._machine.settings

    @property
    def succeeded(self) -> int:
        """Return how many tasks of all levels have succeeded so far."""
        return self._machine.state.succeeded

    @property
    def reason(self) -> str | None:
        """Return why the run is over, or None while it is not."""
        return self._machine.state.reason

    def listen(self, listener: Listener, *kinds: type[Event]) -> None:
        """Call `listener` with every event from now on, or with those of `kinds`."""
        need_call(listener, "a listener")
        for one in kinds:
            if not isinstance(one, type):
                raise ArgumentError(f"a kind of events is {kind(one)}, no class")
        self._machine.recorder.listen(listener, *kinds)

    def record(self) -> Recording:
        """Keep every event from now on, to be read later."""
        return Recording(self._machine.recorder)

    def watch_contexts(self, listener: ContextListener) -> None:
        """Tell `listener` whenever the context of a method is asked, and the answer."""
        need_call(listener, "a listener")
        self._machine.context_asked = listener

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact on behalf of the user.

        Raises:
            FactError: if the declarations do not allow it.
        """
        machine = self._machine
        machine.access.assert_for("user", fact)
        if machine.recognizer.unsettled:
            machine.access.recognise()

    def check_fact(self, *fact: Atom) -> None:
        """Look at a fact without asserting it. Raises FactError as `assert_fact`."""
        self._machine.access.checked(fact)

    def erase(self, *prefix: Atom) -> None:
        """Erase every fact that starts so, on behalf of the user.

        Raises:
            FactError: if the prefix names nothing declared.
        """
        machine = self._machine
        machine.access.erase_for("user", prefix)
        if machine.recognizer.unsettled:
            machine.access.recognise()

    def move(self, item: str, place: Atom | None) -> None:
        """Let an introduced item be at another place; None: it is lost.

        Raises:
            FactError: for a name that no handler introduced.
        """
        with (access := self._machine.access).batch():
            access.lose(item) if place is None else access.move(item, place)

    def signal(self, *content: Atom) -> None:
        """Send a signal `(:name arg...)` now.

        Raises:
            FactError: if no event is called so, or it has other arguments.
        """
        need_fact(content, "the signal")
        self._machine.world.check_signal(content)
        signal(self._machine, self._machine.memory.canonical(content))

    def call_at(self, time: Time, action: Callable[[], None]) -> None:
        """Do something at a time: first of all that falls on it.

        In the course of an atomic primitive it is done when that ends, before its
        result. The run goes on until it is done, or is ended for another reason.

        Raises:
            ArgumentError: if `time` is no time, or `action` cannot be called.
        """
        need_time(time, "`time`")
        need_call(action, "`action`")
        self._machine.state.requests += 1
        heapq.heappush(
            self._machine.host_timers, (time, self._machine.state.requests, action)
        )

    def call_at_end(self, action: Callable[[], None]) -> None:
        """Do something when the run is over, before live tasks are removed."""
        need_call(action, "`action`")
        self._machine.at_end.append(action)

    def call_when_waiting(self, action: Callable[[], None]) -> None:
        """Do something each time the run has nothing to do but to let time pass.

        All that has come by then is dealt with. It is for those who look on: what they
        do changes nothing.
        """
        need_call(action, "`action`")
        self._machine.when_waiting.append(action)

    def submit(self, task: TaskRequest | str) -> None:
        """Give the robot a task, as text or as an object, now or for a later time.

        Raises:
            RefusedError: for an unknown RAP, or a wrong number of inputs.
            TextError: for a text that is no task.
        """
        if isinstance(task, str):
            task = read_task_request(task)
        if not isinstance(task, TaskRequest):
            raise ArgumentError(f"a task is {kind(task)}", 'as text: "(rap args)"')
        self.check([task])
        self.start()
        if task.at is not None and task.at > self.now:
            self._machine.state.requests += 1
            self._machine.state.expected += not task.background
            heapq.heappush(
                self._machine.state.scheduled,
                (task.at, self._machine.state.requests, task),
            )
            self._machine.monitors.look_by(task.at)
        else:
            create_top(self._machine, task)

    def cancel(self, goal: Fact) -> int:
        """Cancel every live top-level task that a goal matches; how many they were.

        Its variables (`?x`, `?`) match anything.
        """
        need_atoms(goal, "`goal`")
        return cancel_matching(self._machine, goal)

    def check(self, tasks: Sequence[TaskRequest]) -> None:
        """Look at tasks without running anything. Raises RefusedError as `submit`."""
        goals = []
        for task in tasks if isinstance(tasks, Iterable) else [tasks]:
            need_task(task)
            goals.append(task.goal)
        refuse_tasks(self._machine.library, goals)

    def extend(self, library: Program) -> None:
        """Go on with more RAPs than before, made by `rapc.extend` (T 4.10.1).

        Tasks under way keep the RAPs they began with.

        Raises:
            RefusedError: if the library is not the one that runs with some RAPs added.
        """
        need_program(library, "`library`")
        refuse_extension(self._machine.library.library, library.library)
        self._machine.library = library

    # --- running --------------------------------------------------------------------

    def run(self, until: Time | None = None, cycles: int | None = None) -> str:
        """Run until the run is over or the clock has passed `until`.

        At most `cycles` further cycles are run. Returns the reason why the run is
        over; it is over for good.

        Raises:
            ArgumentError: if `until` is no time.
            PortError: if the world breaks.
        """
        if until is not None:
            need_time(until, "`until`")
        if cycles is not None:
            need_count(cycles, "`cycles`")
        self._machine.state.until = until
        self.start()
        if self._machine.state.reason is None:
            most = None if cycles is None else max(cycles, 0)
            try:
                if until is not None and most != 0:
                    self._machine.set_clock(self.now)  # it may not go on
                reason = self._loop.run(most, wait=True) or self._loop.reason()
            except BaseException as error:
                self._break(error)
            self.end(reason or "cycles")
        return self._machine.state.reason or "done"

    def step(self, wait: bool = True) -> bool:
        """Run one cycle, after its time has come; return False once the run is over.

        Without `wait` also False, and nothing done, if no task can go on now. With it
        the run is over after as many waits as `Settings.idle_waits` says: no step goes
        on for ever because the world does.
        """
        return self._go(1, wait) == 1

    def run_ready(self) -> int:
        """Run cycles until no task can go on now; how many they were."""
        return self._go(None, wait=False)

    def come_to_choice(self) -> bool:
        """Go on to the moment at which a task is about to be chosen, and stop there.

        What comes before a choice is done: the clock moves on, messages are taken in,
        monitors are tested. The next step makes the choice. Returns False, with the run
        ended, if there is none to make.
        """
        self.start()
        if self._machine.state.reason is None:
            try:
                reason = self._loop.run(1, wait=True, choose=False)
            except BaseException as error:
                self._break(error)
            if reason is not None:
                self.end(reason)
        return self._machine.state.reason is None

    def _go(self, most: int | None, wait: bool) -> int:
        state, recorder = self._machine.state, self._machine.recorder
        if not state.started:
            self.start()
        before = recorder.cycle
        if state.reason is None:
            try:
                reason = self._loop.run(most, wait)
            except BaseException as error:
                self._break(error)
            if reason is not None:
                self.end(reason)
        return recorder.cycle - before

    def _break(self, error: BaseException) -> NoReturn:
        """Raise what broke the run off; what is a world's author's also ends it.

        Raises:
            PortError: see `HeldWorld.blame`.
        """
        self._machine.turning, self._machine.broken = False, True
        try:
            self._machine.world.blame(error)
        except PortError as told:
            self.end("broken", told.message)
            raise

    def start(self, spec: RunSpec | None = None) -> None:
        """Begin the run: emit `run-started` and assert the world's first facts.

        The first task or step begins a run that was not begun before.

        Args:
            spec: what the run is begun with, for the trace; library, world and
                settings are those of the run.
        """
        if self._machine.state.started:
            return
        machine = self._machine
        machine.state.started = True
        tell_start(machine, spec or RunSpec(seed=self.seed))
        try:
            for fact in machine.world.facts():
                self.assert_fact(*fact)
        except BaseException as error:
            machine.world.blame(error)

    # --- saving ---------------------------------------------------------------------

    def save(self) -> bytes:
        """Return the whole run as bytes, its world among it; nothing changes by it.

        Listeners and registered callables are no part of a run.

        Raises:
            StateError: in the middle of a cycle, if the world cannot be saved, or if
                the host is to be called (`call_at`, `call_at_end`).
            PortError: if the world breaks while it is saved.
        """
        return save(self._machine, self.seed)

    def restore(self, saved: bytes) -> None:
        """Take up a run that `save` returned, in place of this one.

        Listeners stay, and hear of what happens from now on; so do what `memory` and
        `question` have returned. It may have been saved by another process, and by
        another run of the same library in a world made the same way.

        Raises:
            StateError: if `saved` is no such run; then nothing has changed.
            PortError: if the world breaks while it is restored.
        """
        if not isinstance(saved, bytes):
            raise ArgumentError(f"`saved` is {kind(saved)}, no bytes of `save`")
        self.seed = restore(self._machine, saved)

    def fork(self, world: World | None = None) -> Interpreter:
        """Return a second run that stands where this one stands.

        Both go on by themselves. Nobody listens to the second one yet.

        Args:
            world: a world for it, made as that of this run was; without one it gets a
                copy of that of this run.

        Raises:
            StateError: as `save`.
        """
        saved, machine = self.save(), self._machine
        made = copy.deepcopy(machine.world.behind) if world is None else world
        other = self._made_with(machine.library, machine.settings, made)
        other.restore(saved)
        return other

    def remade(self, library: Program, settings: Settings) -> Interpreter:
        """Return a run of another library, or with other settings, in the same world.

        Its listeners are those of this run. It stands nowhere until a state is restored
        in it, and only one of the two may go on from then on.

        Raises:
            RefusedError: if the library cannot be run in the world.
        """
        other = self._made_with(library, settings, self._machine.world.behind)
        other._machine.recorder.take_over(self._machine.recorder)
        if self._machine.context_asked is not None:
            other.watch_contexts(self._machine.context_asked)
        return other

    def _made_with(
        self, library: Program, settings: Settings, world: World
    ) -> Interpreter:
        """Return a run that has not begun, with the callables of this one."""
        functions, solvers, comparators = self._registered
        return Interpreter(
            library, world, self.seed, settings, functions, solvers, comparators
        )

    # --- the end ------------------------------------------------------------------

    def end(self, reason: str, because: str | None = None) -> None:
        """End the run: every live task is removed, the results are told.

        Args:
            reason: why it is over, in a word.
            because: more of it, where somebody knows more.
        """
        if self._machine.state.reason is None:
            end_run(self._machine, reason, because)

    def results(self) -> tuple[TaskResult, ...]:
        """Return what has become of each task given so far, in order of arrival."""
        return snapshot.results(self._machine.state.top_level)

    def agenda(self) -> tuple[AgendaEntry, ...]:
        """All live tasks as they stand now, by number, each with its slack."""
        return snapshot.agenda(self._machine)

    def goals(self) -> dict[int, Goal]:
        """The goals of all live tasks by number, with the inputs that are known."""
        return snapshot.goals(self._machine)

    def question(self, formula: Formula | str, *given: str) -> HostQuery:
        """A formula, or its text, made ready to be asked of memory again and again.

        `given` are the variables whose values come with each asking, in that order.

        Raises:
            TextError: for a text that is no formula, a name that the library does not
                declare, a variable that the formula does not have.
        """
        if isinstance(formula, str):
            formula = parse_formula(formula)
        if not isinstance(formula, Node):
            raise ArgumentError(f"a question is {kind(formula)}, no formula")
        for name in given:
            if not isinstance(name, str):
                raise ArgumentError(f"a variable is {kind(name)}", 'as text: "?x"')
        return HostQuery(self._machine, formula, given)

    def waiting(self) -> tuple[str, ...]:
        """Each task that is not done, and what it waits for, for a person to read."""
        return snapshot.waiting(self._machine)
