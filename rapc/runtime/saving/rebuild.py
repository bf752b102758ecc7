"""Records into a run: what `Interpreter.restore` puts in place of what was.

All new objects are made first, and anything that is wrong with the records shows then;
only what cannot fail any more touches the machine (`Rebuilt.install`).
"""

from __future__ import annotations

import heapq
import math

from rapc.base.chance import stream_in
from rapc.base.resources import Counter, SetResource, Value
from rapc.compiler.rap_plan import MethodPlan, RapPlan
from rapc.compiler.watches import WatchKey
from rapc.library.saved_check import UnsoundError
from rapc.runtime.machine import Machine
from rapc.runtime.memory.validation import WrongRecordError, need
from rapc.runtime.saving.checks import Remade, check
from rapc.runtime.saving.records import (
    COUNTS,
    AskRecord,
    CounterRecord,
    Frozen,
    HistoryRecord,
    Members,
    MethodRecord,
    Parts,
    Ref,
    RunRecord,
    Saved,
    TaskRecord,
    WaitRecord,
)
from rapc.runtime.state.activations import Activation
from rapc.runtime.state.history import History
from rapc.runtime.state.run_state import RunState
from rapc.runtime.state.states import (
    BLOCKED,
    ELIGIBLE,
    ENDED,
    RUNNING,
    UNTESTED,
    WAITING,
)
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.runtime.state.things import Ask, ThingWait
from rapc.runtime.state.top_level import TopLevelTask
from rapc.runtime.state.wait_state import WaitState
from rapc.runtime.tasks.choose import added_method
from rapc.world import Time

_STATES = {s: s for s in (WAITING, UNTESTED, ELIGIBLE, BLOCKED, RUNNING, ENDED)}

_DEEPEST = 8
"""How deep the tuples of a key may nest in a record; those of a run nest three deep."""


class Rebuilt:
    """A run made of records, not yet in place of another.

    Args:
        machine: the machine for which it is made; its library names the plans.
        record: the records.

    Raises:
        WrongRecordError: for records that do not belong together or to the library.
    """

    def __init__(self, machine: Machine, record: RunRecord) -> None:
        self._machine = machine
        self._record = record
        self.state = RunState()
        self._resources = [_resource(one) for one in record.resources]
        self._environments = [self._environment(one) for one in record.environments]
        self._tasks: list[Task] = []
        self._runs: list[tuple[MethodRun, MethodRecord]] = []
        try:
            self._random = stream_in(record.random)
            self._add_methods()
            self._make_tasks()
            self._fill_state()
            self._check_numbers()
            self._check()
            self._held = [
                (run, [(_ask(one), one.said) for one in saved.held])
                for run, saved in sorted(
                    self._runs, key=lambda pair: pair[0].task.number
                )
            ]
            self._thing_waits = self._waits_for_things()
        except (LookupError, TypeError, ValueError, OverflowError) as error:
            raise WrongRecordError(f"{type(error).__name__}: {error}") from error

    # --- making -------------------------------------------------------------------

    def _environment(self, saved: dict[str, Saved]) -> Env:
        return {name: self._known(value) for name, value in saved.items()}

    def _value(self, saved: Saved) -> Value | None:
        if not isinstance(saved, Ref):
            return saved
        if not 0 <= saved.at < len(self._resources):
            raise WrongRecordError(f"no resource {saved.at}")
        return self._resources[saved.at]

    def _known(self, saved: Saved) -> Value:
        value = self._value(saved)
        if value is None:
            raise WrongRecordError("a variable without a value")
        return value

    def _env_at(self, place: int) -> Env:
        return {} if place < 0 else self._environments[place]

    def _plan(self, name: str) -> RapPlan:
        return self._machine.library.known_rap(name)

    def _add_methods(self) -> None:
        for name, node in self._record.added_methods:
            plan = self._plan(name)
            index = len(self.state.methods(plan))
            try:
                method = added_method(self._machine.library, plan, node, index)
            except UnsoundError as error:
                raise WrongRecordError(str(error)) from error
            self.state.added_methods.setdefault(name, []).append(method)

    def _make_tasks(self) -> None:
        """Make the tasks in order: each comes after the task that it is a step of."""
        owners: dict[int, tuple[MethodRun, int]] = {}
        for place, record in enumerate(self._record.tasks):
            run, at = owners.get(place, (None, 0))
            step = None if run is None else run.plan.steps[at]
            task = Task(self._plan(record.rap), run, step)
            self._tasks.append(task)
            self._fill_task(task, record)
            if record.run is not None:
                task.run = self._run(task, record.run)
                for position, below in enumerate(record.run.steps):
                    if below <= place or below in owners:
                        raise WrongRecordError(f"task {below} is out of place")
                    owners[below] = (task.run, position)
        for run, saved in self._runs:
            run.steps = [self._tasks[at] for at in saved.steps]

    def _fill_task(self, task: Task, record: TaskRecord) -> None:
        task.number = record.number
        task.state = _STATES[record.state]
        if task.state is ENDED and task.within is not None:
            return
        task.env = self._env_at(record.env)
        task.family = record.family
        task.priority = record.priority
        task.limit = _time(record.limit)
        task.waiting = record.waiting
        task.goal_args = tuple([self._value(value) for value in record.inputs])
        if len(task.goal_args) != len(task.plan.inputs):
            raise WrongRecordError(f"`{record.rap}` has other inputs")
        task.identity = _key(record.identity)
        if record.method is not None:
            task.method = self._method(task, record.method)
        task.choice = _key(record.choice)
        task.last_result = record.last_result
        task.history = (
            None if record.history is None else self._history(task, record.history)
        )
        task.wait = None if record.wait is None else self._wait(task, record.wait)

    def _run(self, task: Task, record: MethodRecord) -> MethodRun:
        plan = self._method(task, record.method)
        run = MethodRun(task, plan, self._env_at(record.env), record.started)
        if len(record.steps) != len(plan.steps):
            raise WrongRecordError(f"`{task.plan.name}` has other steps")
        run.steps_left = record.steps_left
        if run.ends is not None and record.ends is not None:
            run.ends.times = list(record.ends)
            run.ends.ended_by_until = set(record.ended_by_until)
        run.skills = record.skills
        run.ticket = record.ticket
        self._runs.append((run, record))
        return run

    def _method(self, task: Task, index: int) -> MethodPlan:
        methods = self.state.methods(task.plan)
        need(0 <= index < len(methods), f"`{task.plan.name}` has no method {index}")
        return methods[index]

    def _history(self, task: Task, record: HistoryRecord) -> History:
        history = History()
        history.choices = {_tuple(key): count for key, count in record.choices}
        history.tries = dict(record.tries)
        if record.last_choice is not None:
            history.last_choice = list(history.choices)[record.last_choice]
        if record.before is not None:
            history.before = self._method(task, record.before)
        history.results = dict(record.results)
        history.failures = dict(record.failures)
        history.failure = record.failure
        history.because = record.because
        if record.success is not None:
            history.success = self._env_at(record.success)
        return history

    def _wait(self, task: Task, record: WaitRecord) -> WaitState:
        windows = () if task.step is None else task.step.windows
        wait = WaitState(tuple([windows[at] for at in record.windows]))
        wait.earliest_start = record.earliest_start
        wait.awaits_signal = record.awaits_signal
        wait.ready_at = record.ready_at
        wait.made = record.made
        if record.keys is not None:
            wait.keys = tuple([self._watched(key) for key in record.keys])
        wait.timer = record.timer
        wait.blocked_on = record.blocked_on
        wait.formula = record.formula
        wait.given_deadline = _time(record.given_deadline)
        wait.monitor_deadline = _time(record.monitor_deadline)
        wait.missed = record.missed
        wait.first_selected = record.first_selected
        wait.after_method = record.after_method
        wait.prepared = record.prepared
        wait.setup_failed = record.setup_failed
        wait.duration = record.duration
        return wait

    def _waits_for_things(self) -> list[ThingWait]:
        found = []
        for task, record in zip(self._tasks, self._record.tasks, strict=True):
            if record.things is not None:
                said = record.things
                ways = [tuple(map(_ask, asks)) for asks in said.alternatives]
                wait = ThingWait(task, tuple(ways), said.on, said.holder)
                wait.woken, wait.skills = said.woken, said.skills
                found.append(wait)
        return found

    def _watched(self, key: tuple[object, ...] | Ref) -> WatchKey:
        return self._known(key) if isinstance(key, Ref) else key  # type: ignore[return-value]

    def _fill_state(self) -> None:
        record, state = self._record, self.state
        for top in record.top_level:
            given = TopLevelTask(self._tasks[top.task], top.background, top.came)
            given.outcome, given.because = top.outcome, top.because
            given.ended = top.ended
            given.outputs = self._env_at(top.outputs)
            state.top_level.append(given)
            if given.task.live:
                state.live_top[given.task.number] = given
        state.foreground = sum(not g.background for g in state.live_top.values())
        self._live = {task.number: task for task in state.live_tasks()}
        state.scheduled = list(record.scheduled)
        heapq.heapify(state.scheduled)
        state.expected = sum(not entry[2].background for entry in state.scheduled)
        state.pending = {
            ticket: (None if number is None else self._live[number], asked)
            for ticket, number, asked in record.pending
        }
        self._switch_on()
        state.listening = {
            signal: {number: self._live[number] for number in numbers}
            for signal, numbers in record.listening
        }
        for name in COUNTS:
            setattr(state, name, getattr(record.counts, name))

    def _switch_on(self) -> None:
        """Have the activations on that were, and those that may still be heard of."""
        for record in self._record.activations:
            task = None if record.task is None else self._live[record.task]
            run = None if task is None or not record.on else task.run
            one = Activation(record.ticket, record.owner, task, run, record.skills)
            if not record.on:
                self.state.activations.off[record.ticket] = one
                continue
            if run is None or run.plan.activation is None:
                raise WrongRecordError(f"task {record.task} has nothing switched on")
            self.state.activations.begin(one)

    def _check_numbers(self) -> None:
        """See that all other numbers of tasks are those of live ones."""
        agenda, monitors = self._record.agenda, self._record.monitors
        numbers: list[int] = [*monitors.to_test, *monitors.aging, *monitors.ways]
        numbers += [number for _, number in monitors.deadlines]
        numbers += [number for number, _ in monitors.missed]
        numbers += [number for number, _, _ in agenda.sorted]
        numbers += [] if agenda.sole is None else [agenda.sole]
        for number in numbers:
            if number not in self._live:
                raise WrongRecordError(f"no live task {number}")

    def _check(self) -> None:
        """Validate what was made; see `rapc.runtime.saving.checks`."""
        record = self._record
        check(
            Remade(
                machine=self._machine,
                record=record,
                tasks=self._tasks,
                runs=self._runs,
                live=self._live,
                records={one.number: one for one in record.tasks},
                asked={entry[:2] for entry in record.pending},
            )
        )

    # --- putting in place ---------------------------------------------------------

    def install(self) -> None:
        """Put the run in place of the one that the machine held.

        Memory has been restored by now: notations are found there.
        """
        machine, record = self._machine, self._record
        for run, saved in self._runs:
            run.notations = machine.memory.notations.of(saved.notations)
        machine.rng.setstate(self._random.getstate())
        machine.state = self.state
        machine.recount_identities()
        counts = record.counts
        machine.recorder.jump(counts.time, counts.cycle, counts.serial)
        agenda, monitors = record.agenda, record.monitors
        machine.agenda.stack[:] = agenda.stack
        machine.agenda.last_family = agenda.last_family
        machine.agenda.load(
            None if agenda.sole is None else self._live[agenda.sole],
            [(self._live[n], _time(late), failed) for n, late, failed in agenda.sorted],
        )
        machine.monitors.load(
            self._live.values(),
            [self._live[number] for number in monitors.to_test],
            [self._live[number] for number in monitors.aging],
            [(time, self._live[number]) for time, number in monitors.deadlines],
        )
        machine.things.load(self._held, self._thing_waits)
        machine.things.changed.update((n, self._live[n]) for n in monitors.ways)
        machine.things.conflicts = monitors.conflicts
        machine.monitors.tested_at = monitors.tested_at
        machine.monitors.deadlines.missed = {n: list(ts) for n, ts in monitors.missed}


def _resource(record: object) -> Counter | SetResource:
    if isinstance(record, CounterRecord):
        return Counter(record.value)
    return SetResource(dict.fromkeys(record.members))  # type: ignore[attr-defined]


def _ask(record: AskRecord) -> Ask:
    if not record.thing:
        raise WrongRecordError("a thing without a name")
    return Ask(record.thing, record.priority, record.used)


def _time(time: Time | None) -> float:
    return math.inf if time is None else time


def _key(parts: Parts | None) -> tuple[object, ...] | None:
    return None if parts is None else _tuple(parts)


def _tuple(parts: Parts, depth: int = 0) -> tuple[object, ...]:
    if depth > _DEEPEST:
        raise WrongRecordError("a key is nested too deeply")
    return tuple([_part(part, depth) for part in parts.parts])


def _part(part: Frozen, depth: int) -> object:
    if isinstance(part, Parts):
        return _tuple(part, depth + 1)
    return frozenset(part.members) if isinstance(part, Members) else part
