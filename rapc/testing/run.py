"""Run one test in the scripted world or in a simulator, and return the outcome.

This module reads no file and prints nothing. Cases come from `rapc.testing.discover`;
`rapc.console.testing.explain` prints outcomes.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Collection, Sequence

import msgspec
from msgspec.structs import replace

from rapc.analysis.driver import Finding
from rapc.base.source import Span
from rapc.base.values import Fact, format_atom, format_list, number, readable
from rapc.compiler.program import Program
from rapc.debug.saved_state import SavedState
from rapc.errors import (
    FactError,
    LoadError,
    PortError,
    RefusedError,
    StateError,
    WorldError,
    in_a_line,
)
from rapc.host import find_plan
from rapc.ir import nodes
from rapc.runtime.events.recorder import Listener
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest, as_text, of_agenda, of_node
from rapc.runtime.truth import figures_of
from rapc.spec import RunSpec
from rapc.testing.coverage import Coverage
from rapc.testing.effects import EffectsCheck
from rapc.testing.judge import Evidence, judge
from rapc.testing.patterns import atom, flat
from rapc.testing.record import Record
from rapc.testing.setting import (
    ObservedWorld,
    UnansweredQuestion,
    Unmet,
    functions,
    named_world,
    problems,
    row_of,
    saved_state,
)
from rapc.world import Kit, Time, World
from rapc.worlds.scripted import ScriptedWorld, UnansweredRequest

MOST_CYCLES = 100_000
"""The limit of cycles of a test without its own limit."""

LATEST = 100_000
"""The limit of time of a test with a limit of neither time nor cycles."""


class Case(msgspec.Struct, frozen=True):
    """A test with the library it runs, ready to be run any number of times."""

    test: nodes.DefineTest
    library: Program
    #: The checker's errors in the test; a test with errors is not run.
    faults: tuple[Finding, ...] = ()


class Status(enum.Enum):
    """The status of a test; `ERROR` if the test itself has an error."""

    PASSED = "passed"
    FAILED = "failed"
    ERROR = "error"


class Outcome(msgspec.Struct, frozen=True):
    """The outcome of a test under one seed."""

    case: Case
    seed: int
    status: Status
    failures: tuple[Unmet, ...] = ()
    #: The reason why the test ended earlier than its author may expect, or no text.
    note: str = ""
    #: The last lines of the trace, if the test failed.
    trace: tuple[str, ...] = ()
    #: The failures in a simulator that a retry has mended, a line for each RAP.
    mended: tuple[str, ...] = ()
    #: The RAPs whose declared effects were checked.
    checked: tuple[str, ...] = ()


Wrap = Callable[[World, int], World]
"""Wraps the world of a test; called with the world and the seed."""


def run_case(
    case: Case,
    seed: int = 0,
    wrap: Wrap | None = None,
    coverage: Coverage | None = None,
    listener: Listener | None = None,
    modules: Collection[str] = (),
    state: SavedState | None = None,
    effects: bool = False,
) -> Outcome:
    """Run a test once.

    Args:
        case: the test and its library.
        seed: the seed of interpreter and faults, unless the test has its own.
        wrap: wraps the world, for example with faults.
        coverage: counts what the run exercises.
        listener: receives every event of the run, in the way of a trace.
        modules: the modules of which the test may name worlds, as `module:Class`.
        state: the saved state that the test names, if it is not read from its file.
        effects: whether the declared effects of RAPs must come true in a simulator.
    """
    test, place = case.test, case.test.name_span
    seed = seed if test.seed is None else test.seed
    if case.faults:
        return _error(case, seed, [_problem(f) for f in case.faults])
    try:
        state = state or saved_state(test)
        seed = seed if state is None else state.seed
        world, found = named_world(test, seed, modules, state)
        kit = Kit() if world is None else world.kit
        known = {} if world is None or test.script else figures_of(world)
        found = found or problems(test, case.library.library, kit, known, state)
        if found:
            return _error(case, seed, found)
        running = _Run(case, seed, world, wrap, state)
    except WorldError as error:
        return _error(case, seed, [Unmet(place, (in_a_line(error),))])
    except (FactError, LoadError, PortError, StateError) as error:
        return _error(case, seed, [Unmet(place, (error.message,))])
    except RefusedError as error:
        return _error(case, seed, [Unmet(place, (line,)) for line in error.reasons])
    if coverage is not None:
        coverage.begin(case.library.library)
        running.interpreter.listen(coverage)
        running.interpreter.watch_contexts(coverage.context)
    if listener is not None:
        running.interpreter.listen(listener)
    if effects:
        running.check_effects()
    running.run()
    return running.outcome()


def _error(case: Case, seed: int, found: Sequence[Unmet]) -> Outcome:
    return Outcome(case, seed, Status.ERROR, tuple(found))


def _problem(finding: Finding) -> Unmet:
    """Return a finding as one line, with a suggestion of a name."""
    found = finding.diagnostic
    is_question = found.help.startswith("did you mean")
    message = f"{found.message}; {found.help}" if is_question else found.message
    return Unmet(found.span, (message,))


class _Run:
    """One run of a test: its interpreter, and the failures so far.

    Raises:
        RefusedError: if the library or a task cannot be run.
        FactError: for a fact that the declarations do not allow.
    """

    def __init__(
        self,
        case: Case,
        seed: int,
        named: World | None,
        wrap: Wrap | None,
        state: SavedState | None,
    ) -> None:
        self.test = case.test
        self._case = case
        self._seed = seed
        self._record = Record()
        self._failures: list[Unmet] = []
        self._pending: list[nodes.Expect] = []
        self._unreached: dict[int, nodes.At] = dict(enumerate(case.test.ats))
        self._effects: EffectsCheck | None = None
        self._broken = False
        self._note = ""
        test, library = case.test, case.library
        later, known = _later_tasks(test), functions(test.answers)
        tasks = [*map(of_node, test.tasks)]
        self._simulated = named is not None and not test.script
        #: The tasks and facts that are added to a saved state.
        self._more: tuple[list[TaskRequest], list[Fact]] | None = None
        if state is not None and named is not None:
            self.interpreter = state.continued(library, named, known)
            named = self.interpreter.port.behind
        world: World
        if named is not None and self._simulated:
            world = ObservedWorld(named, self._leaving)
        else:
            world = ScriptedWorld(
                [row_of(row, library.signatures) for row in test.script],
                declared=library.library,
                kit=Kit() if named is None else named.kit,
                leaving=self._leaving,
            )
        world = world if wrap is None else wrap(world, seed)
        if state is None:
            spec = RunSpec(
                seed=seed,
                agenda=test.agenda,
                tasks=tuple(map(as_text, tasks)),
                facts=tuple([format_list(flat(fact)) for fact in test.facts]),
            )
            self.interpreter = Interpreter.prepared(
                library, world, spec, later=later, functions=known, planner=find_plan
            )
            return
        self.interpreter.port.enclose(world)
        if test.agenda is not None:
            tasks = [*of_agenda(library.library, test.agenda), *tasks]
        self._more = tasks, [flat(fact) for fact in test.facts]
        self.interpreter.check([*tasks, *later])
        for fact in self._more[1]:
            self.interpreter.check_fact(*fact)

    # --- during the run ------------------------------------------------------------

    def check_effects(self) -> None:
        """Check the declared effects of the RAPs that succeed, in a simulator."""
        if self._simulated:
            self._effects = EffectsCheck(self.interpreter, self._fail)

    def run(self) -> None:
        """Run the test to its end."""
        interpreter, test = self.interpreter, self.test
        interpreter.listen(self._record)
        interpreter.call_at_end(self._judge_at_the_end)
        until = test.until or nodes.Until(LATEST, None)
        cycles = MOST_CYCLES if until.cycles is None else until.cycles
        try:
            for number, at in enumerate(test.ats):
                interpreter.call_at(at.time, self._action(number, at))
            self.interpreter.start()
            if self._more is not None:
                self._begin_in_state(*self._more)
            # A limit that the test does not state keeps no background task going.
            tasks = interpreter.first_tasks
            new, stated = self._more is None, test.until is not None
            alone = new and not stated and all(task.background for task in tasks)
            interpreter.run(None if alone else until.time, cycles=cycles)
        except (UnansweredRequest, UnansweredQuestion) as error:
            self._fail(test.name_span, str(error))
            return
        except (FactError, PortError) as error:
            self._broken = True
            self._fail(test.name_span, str(error))
            return
        self._fail_if_stopped()

    def _begin_in_state(self, tasks: list[TaskRequest], facts: list[Fact]) -> None:
        """Tell the listeners the tasks of a saved state; add those of the test."""
        self.interpreter.tell_tasks()
        for fact in facts:
            self.interpreter.assert_fact(*fact)
        for task in tasks:
            self.interpreter.submit(task)

    def _fail_if_stopped(self) -> None:
        """Fail a test that a limit has ended, unless the test states the limit."""
        reason, stated = self.interpreter.reason, self.test.until
        limit, more = "", "give a time with `(until time)`"
        if reason == "cycles" and (stated is None or stated.cycles is None):
            limit = f"after {MOST_CYCLES} cycles"
            if stated is not None:
                more = f"it was only at time {readable(self.interpreter.now)}"
        elif reason == "until" and stated is None:
            limit = f"at time {LATEST}"
        if limit:
            self._fail(self.test.name_span, f"the test was not over {limit}; {more}")

    def _action(self, number: int, at: nodes.At, times: int = 0) -> Callable[[], None]:
        """Return the call that performs an `at` for the time after `times` times."""

        def act() -> None:
            time = _time(at, times)
            again = _time(at, times + 1)
            if at.until is not None and again <= at.until:
                self.interpreter.call_at(again, self._action(number, at, times + 1))
            else:
                del self._unreached[number]
            try:
                for action in at.actions:
                    self._do(action)
            except FactError as error:
                raise FactError(f"at {format_atom(time)}: {error}") from error

        return act

    def _do(self, action: nodes.Action) -> None:
        match action:
            case nodes.Asserts(facts):
                for fact in facts:
                    self.interpreter.assert_fact(*flat(fact))
            case nodes.Erases(prefixes):
                for prefix in prefixes:
                    self.interpreter.erase(*flat(prefix))
            case nodes.Moves() | nodes.Loses():
                self._do_to_items(action)
            case nodes.Signals(signals):
                for signal in signals:
                    self.interpreter.signal(*flat(signal))
            case nodes.GivenTask():
                self.interpreter.submit(of_node(action))
            case nodes.Cancel(goal):
                self.interpreter.cancel(flat(goal))
            case nodes.Expect():
                self._pending.append(action)

    def _do_to_items(self, action: nodes.Moves | nodes.Loses) -> None:
        if isinstance(action, nodes.Moves):
            for one in action.moves:
                self.interpreter.move(str(atom(one.item)), atom(one.place))
        else:
            for item in action.items:
                self.interpreter.move(str(atom(item)), None)

    def _leaving(self) -> None:
        """Evaluate the expectations of a time before the clock advances."""
        pending, self._pending = self._pending, []
        for expect in pending:
            self._judge(expect.expectations)

    def _judge_at_the_end(self) -> None:
        if self.interpreter.reason == "broken":  # the message says more than the rest
            return
        self._note = self._why_so_early()
        self._leaving()
        self._judge(self.test.expectations)
        for at in self._unreached.values():
            self._not_reached(at)

    def _why_so_early(self) -> str:
        """Return a line if the run ended with only background tasks left."""
        left = [
            one for one in self.interpreter.results() if one.outcome == "unfinished"
        ]
        if self.interpreter.reason != "done" or not left:
            return ""
        now = readable(self.interpreter.now)
        return f"the test was over at time {now}: only background tasks were left"

    def _judge(self, expectations: Sequence[nodes.Expectation]) -> None:
        self._record.refresh(self.interpreter.goals())
        scene = Evidence(
            self._record,
            lambda formula: self.interpreter.question(formula).holds(),
            self.interpreter.figures,
        )
        for expectation in expectations:
            happened = judge(expectation, scene)
            if happened is not None:
                self._fail(expectation.span, *happened)

    def _not_reached(self, at: nodes.At) -> None:
        if any(isinstance(action, nodes.Expect) for action in at.actions):
            now = readable(self.interpreter.now)
            reason = self.interpreter.reason
            self._fail(
                at.span, f"never reached: the run ended at time {now} ({reason})"
            )

    def _fail(self, span: Span, *happened: str) -> None:
        self._failures.append(Unmet(span, happened, len(self._record.events)))

    # --- after the run -----------------------------------------------------------

    def outcome(self) -> Outcome:
        """Return the outcome of the test."""
        mended = tuple(self._record.mended.lines()) if self._simulated else ()
        checked = () if self._effects is None else tuple(self._effects.checked)
        passed = Outcome(
            self._case, self._seed, Status.PASSED, mended=mended, checked=checked
        )
        if not self._failures:
            return passed
        return replace(
            passed,
            status=Status.ERROR if self._broken else Status.FAILED,
            failures=tuple(self._failures),
            note=self._note,
            trace=tuple(self._record.last_lines(self._failures[0].events)),
        )


def _time(at: nodes.At, times: int) -> Time:
    """Return the time of an `at` after it has been performed some times."""
    return number(at.time + times * (at.every or 0))


def _later_tasks(test: nodes.DefineTest) -> list[TaskRequest]:
    actions = [action for at in test.ats for action in at.actions]
    return [of_node(task) for task in actions if isinstance(task, nodes.GivenTask)]
