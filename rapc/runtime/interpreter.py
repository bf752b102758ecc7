"""The interpreter: a run with the interface for a host.

Not here: the loop (`rapc.runtime.tasks.loop`).
"""

from __future__ import annotations

import copy
import heapq
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NoReturn

import msgspec

from rapc.base.resources import Value
from rapc.base.values import Atom, Fact, Number, format_list
from rapc.compiler.program import Program
from rapc.compiler.query.query import Query
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.errors import ArgumentError, PortError, RefusedError, StateError
from rapc.events import Event, Goal, RunEnded, RunStarted, TaskResult
from rapc.ir.nodes import Formula, Node, Proposition, Term
from rapc.language.atoms import kind, need_atoms, need_fact
from rapc.language.results import INTERFERENCE
from rapc.parser.parse import parse_fact, parse_formula
from rapc.runtime import snapshot, strict
from rapc.runtime.achieve import achieving, with_rap
from rapc.runtime.admission import (
    misfitting,
    refusals,
    refuse_extension,
    refuse_other_world,
)
from rapc.runtime.answers import Answers, RecordedWorld
from rapc.runtime.arguments import (
    need_call,
    need_count,
    need_part,
    need_program,
    need_seed,
    need_settings,
    need_spec,
    need_table,
    need_task,
    need_time,
    need_world,
)
from rapc.runtime.authors import code_of_authors
from rapc.runtime.changes import add_declared, changing
from rapc.runtime.events.recorder import Listener, Recording
from rapc.runtime.held_world import HeldWorld
from rapc.runtime.host_query import HandlerQuestions, HostQuery
from rapc.runtime.memory.access import Evidence, MemoryView, Pattern
from rapc.runtime.planner import Planner, computed
from rapc.runtime.run import ContextListener, Run
from rapc.runtime.saving.save import restore, save
from rapc.runtime.settings import Settings, read_settings
from rapc.runtime.snapshot import AgendaEntry, Candidate, Claim
from rapc.runtime.state.activations import Activation
from rapc.runtime.state.task import Env, Task
from rapc.runtime.task_request import (
    TaskRequest,
    as_text,
    of_agenda,
    read_task_request,
    refuse_tasks,
)
from rapc.runtime.tasks import evidence
from rapc.runtime.tasks.causes import (
    Condition,
    PartAsked,
    ask_in_parts,
    conditions,
    context_of,
)
from rapc.runtime.tasks.finish import end_method, fail
from rapc.runtime.tasks.hold_things import asks_of
from rapc.runtime.tasks.loop import run_loop, why_over
from rapc.runtime.tasks.messages import take_in
from rapc.runtime.tasks.primitives import take_reply
from rapc.runtime.tasks.remove import cancel_matching, remove
from rapc.runtime.tasks.rename_items import rename
from rapc.runtime.tasks.signals import signal
from rapc.runtime.tasks.start import create_top, read_inputs, tell_created
from rapc.runtime.truth import WrongBelief, figures_of, wrong_beliefs
from rapc.spec import RunSpec
from rapc.world import Callables, Message, Refused, Reply, Savable, Time, World

TRACE_FORMAT = 2
"""The version of the trace format."""


class Interpreter(Run):
    """One run of a compiled library against a world.

    Args:
        library: the compiled library.
        world: the world, newly made.
        seed: the seed of the run and of the interpreter's random stream.
        settings: see `Settings`.
        functions: callables by registered name, besides those the world registers; each
            gets a `MemoryView` and then its arguments, a default function the
            property's index as a tuple.
        solvers: problem solvers by RAP name; each gets the goal and a `MemoryView` and
            returns methods (T 7.4.1).
        comparators: comparators of descriptions by registered name (T A.5), besides
            those of the world: see `rapc.world.Kit`.
        planner: finds methods for RAPs with `(plan)`: see `rapc.runtime.planner`.

    Attributes:
        library: the compiled library; `extend` replaces it.
        settings: the settings of the interpreter.
        seed: the seed of the interpreter's random stream.
        port: the world with checks of what it returns and sends; `port.behind` is the
            world itself, or a wrapper of it that a tool has put there with
            `port.enclose`.

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
        planner: Planner | None = None,
    ) -> None:
        need_program(library, "`library`")
        need_world(world)
        need_seed(seed)
        need_table(functions, "`functions`")
        need_table(solvers, "`solvers`")
        need_table(comparators, "`comparators`")
        settings = Settings() if settings is None else settings
        need_settings(settings)
        self._spec = RunSpec(seed=seed)
        #: The tasks with which the run begins.
        self.first_tasks: tuple[TaskRequest, ...] = ()
        self.first_facts: tuple[Fact, ...] = ()
        #: Whether each change by a host must be in a journal: it comes as an act.
        self.in_journal = False
        self._registered = (functions, solvers, comparators)
        self._world = world
        code = code_of_authors(world.kit, functions, solvers, comparators)
        port = HeldWorld(world, library, code, settings.strict)
        _refuse(misfitting(library, port))
        refuse_other_world(library, world)
        try:
            super().__init__(library, port, seed, settings)
            self.planner = planner
            _wire(self)
            found = refusals(library, port)
        except BaseException as error:
            port.blame(error)
        _refuse(found)

    @classmethod
    def prepared(
        cls,
        library: Program,
        world: World,
        spec: RunSpec,
        *,
        later: Sequence[TaskRequest] = (),
        functions: Callables | None = None,
        solvers: Callables | None = None,
        comparators: Callables | None = None,
        planner: Planner | None = None,
    ) -> Interpreter:
        """Return a run that can begin, after all checks of library, world and spec.

        Register listeners to the first event before `start`, which begins the run.

        Args:
            library: the library.
            world: the world, made with the seed, options and faults of the spec.
            spec: the specification of the run.
            later: tasks that may be submitted later, checked with the others.
            functions: Python code besides that of the world, like the two following.
            solvers: see `functions`.
            comparators: see `functions`.
            planner: finds methods for RAPs with `(plan)`: see `rapc.runtime.planner`.

        Raises:
            ArgumentError: for an argument of the wrong type.
            TextError: for a task or a fact that cannot be read.
            SettingError: for an unknown setting, or an invalid value.
            RefusedError: if the library or a task cannot be run in the world, or the
                agenda is unknown.
            FactError: for a fact that the declarations do not allow.
        """
        need_program(library, "`library`")
        need_spec(spec)
        agenda = () if spec.agenda is None else of_agenda(library.library, spec.agenda)
        tasks = (*agenda, *map(read_task_request, spec.tasks))
        facts = tuple([parse_fact(text) for text in spec.facts])
        settings = read_settings(spec.settings)
        code = functions, solvers, comparators, planner
        run = cls(library, world, spec.seed, settings, *code)
        run.check([*tasks, *later])
        for fact in facts:
            run.check_fact(*fact)
        run.first_tasks, run.first_facts = tasks, facts
        run._spec = msgspec.structs.replace(
            spec,
            agenda=None,
            tasks=tuple([as_text(task) for task in tasks]),
            facts=tuple([format_list(fact) for fact in facts]),
        )
        return run

    # --- before and during a run -----------------------------------------------------

    @property
    def spec(self) -> RunSpec:
        """Return the specification of the run, with library, digest and world."""
        return msgspec.structs.replace(
            self._spec,
            library=self.library.name,
            digest=self.library.digest,
            world=self.port.name,
            settings=self.settings.named(),
        )

    @property
    def memory(self) -> MemoryView:
        """Return the robot's beliefs, to be read."""
        return self.context.view

    @property
    def world(self) -> World:
        """Return the world of the run."""
        return self._world

    def wrong_beliefs(self) -> list[WrongBelief]:
        """Return the believed facts that are not true, if the world is a `Truth`."""
        return list(wrong_beliefs(self.port, self.beliefs, self.library.signatures))

    def figures(self) -> dict[str, int | float]:
        """Return the ground-truth figures of the world, and the wrong beliefs."""
        return figures_of(self.port, self.wrong_beliefs())

    @property
    def now(self) -> Time:
        """Return the time of the world's clock, as last read."""
        return self.recorder.time

    @property
    def cycle(self) -> int:
        """Return the number of the last cycle."""
        return self.recorder.cycle

    @property
    def serial(self) -> int:
        """Return the serial number of the next event."""
        return self.recorder.serial

    @property
    def created(self) -> int:
        """Return how many tasks have been created; their numbers begin at 1."""
        return self.state.numbers

    @property
    def succeeded(self) -> int:
        """Return how many tasks of all levels have succeeded so far."""
        return self.state.succeeded

    @property
    def reason(self) -> str | None:
        """Return the reason why the run is over, or None before its end."""
        return self.state.reason

    def listen(self, listener: Listener, *kinds: type[Event]) -> None:
        """Call `listener` with every event from now on, or with those of `kinds`."""
        need_call(listener, "a listener")
        for one in kinds:
            if not isinstance(one, type):
                raise ArgumentError(f"a kind of events is {kind(one)}, not a class")
        self.recorder.listen(listener, *kinds)

    def record(self) -> Recording:
        """Record every event from now on, to be read later."""
        return Recording(self.recorder)

    def watch_contexts(self, listener: ContextListener) -> None:
        """Call `listener` with each evaluated context of a method, and the result."""
        need_call(listener, "a listener")
        self.context_listener = listener

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact on behalf of the user.

        Raises:
            FactError: if the declarations do not allow it.
        """
        self._may_change()
        self.access.assert_for("user", fact)
        if self.recognizer.unsettled:
            self.access.recognise()

    def check_fact(self, *fact: Atom) -> None:
        """Validate a fact without an assertion. Raises FactError as `assert_fact`."""
        self.access.checked(fact)

    def erase(self, *prefix: Atom) -> None:
        """Erase every fact that starts with `prefix`, on behalf of the user.

        Raises:
            FactError: if the prefix has an undeclared name.
        """
        self._may_change()
        self.access.erase_for("user", prefix)
        if self.recognizer.unsettled:
            self.access.recognise()

    def move(self, item: str, place: Atom | None) -> None:
        """Move an introduced item to another place; None: the item is lost.

        Raises:
            FactError: for a name that no handler introduced.
        """
        self._may_change()
        with self.access.batch():
            if place is None:
                self.access.lose(item)
            else:
                self.access.move(item, place)

    def signal(self, *content: Atom) -> None:
        """Send a signal `(:name arg...)` now.

        Raises:
            FactError: for an undeclared event, or wrong arguments.
        """
        self._may_change()
        need_fact(content, "the signal")
        self.port.check_signal(content)
        signal(self, self.beliefs.canonical(content))

    def call_at(self, time: Time, action: Callable[[], None]) -> None:
        """Call `action` at a time, before all other work due at that time.

        If an atomic primitive is under way, the call comes at its end, before its
        result. The run goes on until the call, or until the run ends for another
        reason.

        Raises:
            ArgumentError: if `time` is no time, or `action` cannot be called.
        """
        self._may_change()
        need_time(time, "`time`")
        need_call(action, "`action`")
        self.state.requests += 1
        heapq.heappush(self.host_timers, (time, self.state.requests, action))

    def call_at_end(self, action: Callable[[], None]) -> None:
        """Call `action` when the run is over, before live tasks are removed."""
        need_call(action, "`action`")
        self.at_end.append(action)

    def _may_change(self) -> None:
        """Raise StateError if the run has a journal, and this is no act of it."""
        if self.in_journal:
            raise StateError(
                "cannot change the run: its journal would not have the change",
                "use the methods of the `DurableRun`",
            )

    def call_when_waiting(self, action: Callable[[], None]) -> None:
        """Call `action` each time before the run waits for the next time.

        All work due by then is done. The action is for observers: it must not change
        the run.
        """
        need_call(action, "`action`")
        self.when_waiting.append(action)

    def submit(self, task: TaskRequest | str) -> None:
        """Submit a task, as text or as an object, now or for a later time.

        Raises:
            RefusedError: for an unknown RAP, or a wrong number of inputs.
            TextError: for an invalid text.
        """
        self._may_change()
        if isinstance(task, str):
            task = read_task_request(task)
        else:
            need_task(task)
        refuse_tasks(self.library, [task.goal])
        self.start()
        if task.at is not None and task.at > self.now:
            self.state.requests += 1
            self.state.expected += not task.background
            heapq.heappush(
                self.state.scheduled,
                (task.at, self.state.requests, task),
            )
            self.monitors.look_by(task.at)
        else:
            create_top(self, task)

    def achieve(
        self,
        goal: str,
        priority: int = 0,
        deadline: Time | None = None,
        use: Sequence[str] = (),
    ) -> str:
        """Add a RAP with a goal and `(plan)`, submit its task, and return its name.

        Args:
            goal: the goal, a formula as text.
            priority: the priority of the task.
            deadline: its deadline.
            use: the names of the RAPs that a plan may use; empty for all operators.

        Raises:
            TextError: for a text that is no formula, or with undeclared names.
            PlanError: for a RAP in `use` that is no operator.
        """
        rap = achieving(self.library, goal, use)
        task = TaskRequest((rap.name,), priority, deadline)
        need_task(task)
        self.extend(with_rap(self.library, rap))
        self.submit(task)
        return rap.name

    def cancel(self, goal: Fact) -> int:
        """Cancel every live top-level task that a goal matches; return their number.

        Variables of the goal (`?x`, `?`) match anything.
        """
        self._may_change()
        need_atoms(goal, "`goal`")
        return cancel_matching(self, goal)

    def fail_task(self, number: int) -> None:
        """Fail a task, like a task with a false condition; its method ends first.

        Raises:
            ArgumentError: for an unknown task.
        """
        self._may_change()
        task = self.task(number)
        if task.run is not None:
            end_method(self, task.run, INTERFERENCE, None, "cancelled")
        self.eligible.discard(task)
        fail(self, task, INTERFERENCE)

    def retry_task(self, number: int) -> None:
        """Fail the method of a task: the task chooses again.

        Raises:
            ArgumentError: for an unknown task, or a task without a method under way.
        """
        self._may_change()
        task = self.task(number)
        if task.run is None:
            raise ArgumentError(f"task [{number}] has no method under way")
        end_method(self, task.run, INTERFERENCE, None, "cancelled")

    def check(self, tasks: Sequence[TaskRequest]) -> None:
        """Validate tasks without running anything. Raises RefusedError as `submit`."""
        goals = []
        for task in tasks if isinstance(tasks, Iterable) else [tasks]:
            need_task(task)
            goals.append(task.goal)
        refuse_tasks(self.library, goals)

    def extend(self, library: Program) -> None:
        """Continue with additional RAPs, made by `rapc.extend` (T 4.10.1).

        The RAPs of the run stay unchanged: `define-method` adds no method to them.

        Raises:
            RefusedError: if the library is not the present library with added RAPs.
        """
        self._may_change()
        need_program(library, "`library`")
        refuse_extension(self.library.library, library.library)
        self.library = library

    # --- running --------------------------------------------------------------------

    def run(self, until: Time | None = None, cycles: int | None = None) -> str:
        """Run until the run is over or the clock has passed `until`.

        The interpreter runs at most `cycles` further cycles. Return the reason why the
        run is over; a run that is over cannot continue.

        Raises:
            ArgumentError: if `until` is no time.
            PortError: if the world breaks.
        """
        if until is not None:
            need_time(until, "`until`")
        if cycles is not None:
            need_count(cycles, "`cycles`")
        self.state.until = until
        self.start()
        if self.state.reason is None:
            most = None if cycles is None else max(cycles, 0)
            try:
                if until is not None and most != 0:
                    self.set_clock(self.now)  # the clock may not move on
                reason = run_loop(self, most, wait=True) or why_over(self)
            except BaseException as error:
                self._break(error)
            if reason is None and self.state.stops:
                self._raise_interrupt()
            self.end(reason or "cycles")
        return self.state.reason or "done"

    def step(self, wait: bool = True) -> bool:
        """Run one cycle, after its time has come; return False once the run is over.

        Without `wait`, if no task can go on now, do nothing and return False. With
        `wait` the run is over after the number of waits in `Settings.idle_waits`: no
        step waits for ever for the world.
        """
        return self._go(1, wait) == 1

    def run_ready(self, most: int | None = None) -> int:
        """Run cycles until no task can go on now; return the number of cycles.

        Args:
            most: the highest number of cycles; default: no limit.
        """
        if most is not None:
            need_count(most, "the number of cycles")
        return self._go(most, wait=False)

    def come_to_choice(self) -> bool:
        """Advance to the next choice of a task, and stop before the choice.

        The interpreter does all work before a choice: it moves the clock, takes in
        messages and tests monitors. The next step makes the choice. If there is no
        choice to make, the run ends and the method returns False.
        """
        self._go(1, wait=True, choose=False)
        return self.state.reason is None

    def come_to_arrival(self) -> bool:
        """Advance to the next arrival before the next cycle, and stop there.

        Something arrives if the clock moves or the world sends messages: data, signals
        and ends of requests are taken in, and due timers start tasks. The run then
        stands between two cycles. If nothing arrives, the method returns False: the run
        stands before the next choice, or is over. Both ways the trace is that of a run
        without the stop.
        """
        self.arrived = False
        self._go(1, wait=True, arrive=True)
        return self.arrived

    def _go(
        self, most: int | None, wait: bool, choose: bool = True, arrive: bool = False
    ) -> int:
        state, recorder = self.state, self.recorder
        if not state.started:
            self.start()
        before = recorder.cycle
        if state.reason is None:
            try:
                reason = run_loop(self, most, wait, choose, arrive)
            except BaseException as error:
                self._break(error)
            if reason is not None:
                self.end(reason)
            elif state.stops:
                self._raise_interrupt()
        return recorder.cycle - before

    def interrupt(self) -> bool:
        """Let the run raise `KeyboardInterrupt` after its present cycle.

        A signal handler in the thread of the run may call this method instead of
        raising `KeyboardInterrupt` in the middle of a cycle, where the tasks are not
        consistent: the run could not be ended in order.

        Returns:
            whether a cycle is under way; if not, the handler may raise at once.
        """
        if not self.in_loop or self.in_wait:
            return False
        self.state.stops = True
        return True

    def _raise_interrupt(self) -> None:
        """Raise `KeyboardInterrupt` if the run has not ended meanwhile."""
        if self.state.reason is None:
            self.state.stops = False
            raise KeyboardInterrupt

    def _break(self, error: BaseException) -> NoReturn:
        """Raise the error that aborted the run; end the run if an author caused it.

        Raises:
            PortError: see `HeldWorld.blame`.
        """
        self.broken, self.in_wait = True, False
        self.state.stops = self.state.reason is not None
        if self.answers is not None:
            self.answers.store = None  # a resumed run goes on before the error
        try:
            self.port.blame(error)
        except PortError as told:
            self.end("broken", told.message)
            raise

    def start(self, until: Time | None = None) -> None:
        """Begin the run: emit `run-started`, assert first facts, submit first tasks.

        The first task or step also begins the run if necessary.

        Args:
            until: the time limit of a run by steps; `run` sets a limit of its own.

        Raises:
            PortError: if the world breaks.
        """
        if self.state.started:
            return
        if until is not None:
            need_time(until, "`until`")
            self.state.until = until
        self.state.started = True
        if self.recorder.on and self.recorder.wants(RunStarted):
            self.recorder.emit(RunStarted, format=TRACE_FORMAT, spec=self.spec)
        try:
            for fact in self.port.facts():
                self.assert_fact(*fact)
        except BaseException as error:
            self.port.blame(error)
        for fact in self.first_facts:
            self.assert_fact(*fact)
        for task in self.first_tasks:
            self.submit(task)

    # --- tests of a world -------------------------------------------------------------

    def send(self, request: Fact) -> tuple[int, Reply | Refused | None]:
        """Send a request without a task, in sensor names; process a reply.

        Returns:
            the ticket, and the answer of the world. If it is None, the end of the
            request comes later (`receive`).

        Raises:
            PortError: for a world that violates the port.
        """
        need_fact(request, "the request")
        self.state.tickets = ticket = self.state.tickets + 1
        answer = self.port.perform(ticket, request)
        if not isinstance(answer, Refused):
            self.sync_clock()
            asked = self.beliefs.items.named(request)
            if answer is None:
                self.state.pending[ticket] = None, asked
            else:
                take_reply(self, None, asked, answer)
        return ticket, answer

    def receive(self) -> Sequence[Message]:
        """Process the messages of the world without a cycle; return the messages.

        Raises:
            PortError: for a world that violates the port.
        """
        self.sync_clock()
        messages = self.port.messages()
        take_in(self, messages)
        return messages

    # --- saving ---------------------------------------------------------------------

    def save(self) -> bytes:
        """Return the state of the run and its world as bytes.

        The method does not change the run. Listeners and registered callables are not
        saved.

        Raises:
            StateError: in the middle of a cycle, if the world cannot be saved, or with
                registered calls of the host (`call_at`, `call_at_end`).
            PortError: if the world breaks while it is saved.
        """
        return save(self, self.seed)

    def restore(self, saved: bytes) -> None:
        """Replace this run by a run that `save` returned.

        Listeners stay registered, and receive the events from now on. The results of
        `memory` and `question` stay valid. The saved run may be from another process,
        and from another run of the same library in a world made with the same options.

        Raises:
            StateError: if `saved` is no such run; then nothing has changed.
            PortError: if the world breaks while it is restored.
        """
        if not isinstance(saved, bytes):
            raise ArgumentError(f"`saved` is {kind(saved)}, not bytes of `save`")
        self.seed = restore(self, saved)

    def tell_tasks(self) -> None:
        """Emit `task-created` for each live task, for listeners of a restored run."""
        for task in self.tasks():
            tell_created(self, task)

    def fork(self, world: World | None = None) -> Interpreter:
        """Return a second run with the state of this run.

        Both runs are independent. The second run has no listeners.

        Args:
            world: a world for the second run, made with the same options as this run's
                world; by default a copy of this run's world.

        Raises:
            StateError: as `save`.
        """
        saved = self.save()
        made = copy.deepcopy(self.port.behind) if world is None else world
        other = self._made_with(self.library, self.settings, made)
        other.restore(saved)
        return other

    def keep_answers(self) -> Answers:
        """Keep the answers of solvers, and of a world that cannot be saved.

        A run in such a world can then be saved and restored, in this process: it is
        repeated from the answers. Return the store, which this method makes once.
        """
        if self.answers is None:
            self.answers = Answers()
            if not isinstance(self.port.behind, Savable):
                self.port.enclose(RecordedWorld(self.port.behind, self.answers))
        return self.answers

    def remade(self, library: Program, settings: Settings) -> Interpreter:
        """Return a run of another library, or with other settings, in the same world.

        The new run has the listeners of this run. The caller must restore a state in
        the new run, and may continue only one of the two.

        Raises:
            RefusedError: if the library cannot be run in the world.
        """
        other = self._made_with(library, settings, self.port.behind)
        other.recorder.take_over(self.recorder)
        other.answers = self.answers
        if self.context_listener is not None:
            other.watch_contexts(self.context_listener)
        return other

    def _made_with(
        self, library: Program, settings: Settings, world: World
    ) -> Interpreter:
        """Return a run that has not begun, with the callables of this run."""
        functions, solvers, comparators = self._registered
        code = functions, solvers, comparators, self.planner
        return Interpreter(library, world, self.seed, settings, *code)

    # --- the end ------------------------------------------------------------------

    def end(self, reason: str, because: str | None = None) -> None:
        """End the run: remove every live task, report the results.

        Args:
            reason: why the run is over, as one word.
            because: an explanation, if any.
        """
        state = self.state
        if state.reason is not None:
            return
        state.reason, state.stops = reason, True
        for action in self.at_end:
            action()
        results = self.results()
        if reason == "world":
            because = self.port.ended()
        if reason == "runaway" and self.recorder.on:
            because = snapshot.looping(self) or None
        if reason == "stuck" and self.waited_in_vain():
            because = f"no cycle in {state.idle_waits} waits (`rapc.idle-waits`)"
        waiting = snapshot.deadlocks_in_words(self)
        if reason != "done":
            waiting += self.waiting()
        for given in state.top_level:
            if given.task.live:
                remove(self, given.task, "run-over")
        assert not state.activations.on, "skills are on that nobody has"
        if self.recorder.on:
            self.recorder.emit(
                RunEnded,
                reason=reason,
                because=because,
                results=results,
                waiting=waiting,
            )

    # --- the present state, for observers: no call changes the run --------------------

    def results(self) -> tuple[TaskResult, ...]:
        """Return the result of each task so far, in order of arrival."""
        return snapshot.results(self.state.top_level)

    def past(self) -> tuple[Event, ...]:
        """Return events in place of those before this moment, for a restored run.

        The events are `run-started`, and those that give the facts of memory, the live
        tasks with their methods, and the requests under way. They have the cycle 0.
        """
        start = RunStarted(n=0, cycle=0, time=0, format=TRACE_FORMAT, spec=self.spec)
        return snapshot.past(self, start)

    def agenda(self) -> tuple[AgendaEntry, ...]:
        """Return all live tasks by number, each with its slack."""
        return snapshot.agenda(self)

    def goals(self) -> dict[int, Goal]:
        """Return the goals of all live tasks by number, with the known inputs."""
        return snapshot.goals(self)

    def tasks(self) -> list[Task]:
        """Return all live tasks by number."""
        return self.state.live_tasks()

    def task(self, number: int) -> Task:
        """Return a live task by its number.

        Raises:
            ArgumentError: for an unknown task.
        """
        need_count(number, "the number of a task")
        for task in self.state.live_tasks():
            if task.number == number:
                return task
        if 0 < number <= self.state.numbers:
            raise ArgumentError(f"task [{number}] has ended: ask at an earlier moment")
        raise ArgumentError(f"unknown task [{number}]")

    @property
    def added_methods(self) -> Mapping[str, Sequence[MethodPlan]]:
        """Return the methods that solvers have added, by RAP."""
        return self.state.added_methods

    def methods(self, rap: RapPlan) -> tuple[MethodPlan, ...]:
        """Return the methods of a RAP, then those that solvers have added."""
        need_part(rap, RapPlan, "a RAP", "run.library")
        return self.state.methods(rap)

    def notations(self, task: Task) -> list[Fact]:
        """Return the facts that the method of a task has noted."""
        need_part(task, Task, "a task", "run.tasks()")
        noted = () if task.run is None else task.run.notations
        return self.beliefs.notations.facts(noted)

    def monitored(self, task: Task) -> str:
        """Return the formula of a task's monitors, as text."""
        need_part(task, Task, "a task", "run.tasks()")
        return self.monitors.reason(task)

    def requests(self) -> dict[int, tuple[Task | None, Fact]]:
        """Return the requests under way by ticket, each with its task.

        A cancelled request has no task; the world may answer it later, or never.
        """
        return dict(sorted(self.state.pending.items()))

    def skills(self) -> tuple[Activation, ...]:
        """Return the activations that are on, then those that are off but not over."""
        tables = self.state.activations
        return (*tables.on.values(), *tables.off.values())

    def claims(self) -> tuple[Claim, ...]:
        """Return the held things, each with its holder and the waiting tasks."""
        return snapshot.claims(self)

    def deadlocks(self) -> tuple[str, ...]:
        """Return a line for each deadlock: tasks that wait for each other."""
        return snapshot.deadlocks_in_words(self)

    def candidates(self) -> dict[int, Candidate]:
        """Return the eligible tasks by number, as the rules of choice see them."""
        return snapshot.candidates(self)

    def families(self) -> tuple[tuple[int, int], ...]:
        """Return the priority and number of each selected family, preferred first."""
        return tuple(reversed(self.eligible.stack))

    # --- explanations -----------------------------------------------------------------

    def read_inputs(self, task: Task) -> None:
        """Read the inputs of a task that was never selected, as its first cycle does.

        This call changes the task: use it only in a run that is restored afterwards.
        """
        need_part(task, Task, "a task", "run.tasks()")
        if not task.bound:
            read_inputs(self, task)

    def conditions(self, task: Task) -> Iterator[Condition]:
        """Yield the conditions of a task in the order of a cycle [L 3]."""
        need_part(task, Task, "a task", "run.tasks()")
        return conditions(task)

    def explain(
        self, query: Query, task: Task | None, env: Env, most: int
    ) -> Iterator[PartAsked]:
        """Evaluate a query conjunct by conjunct, to the first without a solution.

        Args:
            query: the query.
            task: the task that evaluates the query; None for a user.
            env: the bindings before the evaluation.
            most: the highest number of solutions to find for each conjunct.
        """
        need_part(query, Query, "a query", "task.plan")
        if task is not None:
            need_part(task, Task, "a task", "run.tasks()")
        return ask_in_parts(self, query, task, env, most)

    def solution(self, query: Query, task: Task, env: Env) -> Mapping[str, Value]:
        """Return the first solution of a query of a task; empty without a solution."""
        need_part(query, Query, "a query", "task.plan")
        need_part(task, Task, "a task", "run.tasks()")
        return query.first(context_of(self, task), env) or {}

    def computed(self, term: Term, env: Mapping[str, Value]) -> Number | None:
        """Return the number that a term has in memory; None for any other value.

        Args:
            term: the term.
            env: the values of its variables.
        """
        need_part(term, Node, "a term", "rap.node")
        return computed(self.explaining_context, term, env)

    def supporting(self, formula: Formula, env: Mapping[str, Value]) -> Evidence:
        """Return the facts that make a formula true, each with its time."""
        return evidence.supporting(self, formula, env)

    def opposing(self, part: Formula, env: Mapping[str, Value]) -> Evidence:
        """Return the facts because of which a part of a query does not hold."""
        return evidence.opposing(self, part, env)

    def pattern(self, part: Proposition, env: Mapping[str, Value]) -> Pattern | None:
        """Return a proposition with values for variables, None if unbound.

        The result is None for a proposition that no fact of memory can match.
        """
        need_part(part, Proposition, "a proposition", "run.library")
        return evidence.pattern_of(self, part, env)

    def obstacle(self, task: Task, method: MethodPlan, env: Env) -> Claim | None:
        """Return the claim for which a method would wait, or None."""
        need_part(task, Task, "a task", "run.tasks()")
        need_part(method, MethodPlan, "a method", "run.methods(rap)")
        asks = asks_of(self, task, method, env)
        hold = None if asks is None else self.things.obstacle(task, asks)
        return None if hold is None else snapshot.claim(self, hold)

    def question(self, formula: Formula | str, *given: str) -> HostQuery:
        """Return a formula, or its text, compiled for many evaluations over memory.

        `given` are the variables that get values in each evaluation, in that order.

        Raises:
            TextError: for an invalid text, a name that the library does not declare, a
                variable that is not in the formula.
        """
        if isinstance(formula, str):
            formula = parse_formula(formula)
        if not isinstance(formula, Node):
            raise ArgumentError(f"a query is {kind(formula)}, not a formula")
        for name in given:
            if not isinstance(name, str):
                raise ArgumentError(f"a variable is {kind(name)}", 'as text: "?x"')
        return HostQuery(self, formula, given)

    def waiting(self) -> tuple[str, ...]:
        """Return a line for people on each task under way and its wait."""
        return snapshot.waiting(self)


def _wire(run: Run) -> None:
    """Connect handlers with memory, and check them if the settings are strict."""
    run.recognizer.renamed = partial(rename, run)
    run.access.answers = HandlerQuestions(run).ask
    run.changing = partial(changing, run)
    add_declared(run)
    if run.settings.strict:
        strict.hold_handlers(run, lambda *asked: HostQuery(run, *asked).holds)


def _refuse(found: list[str]) -> None:
    if found:
        raise RefusedError(found)
