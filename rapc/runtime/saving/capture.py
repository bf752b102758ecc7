"""A run into records: what `Interpreter.save` writes down.

Nothing changes by it: no event, no serial, no draw. A run is captured between cycles.
"""

from __future__ import annotations

import math

from rapc.base.chance import stream_state
from rapc.base.resources import Counter, SetResource, Value
from rapc.base.values import Atom
from rapc.compiler.watches import WatchKey
from rapc.runtime.machine import Machine
from rapc.runtime.memory import saving as memory_saving
from rapc.runtime.saving.records import (
    COUNTS,
    ActivationRecord,
    AgendaRecord,
    AskRecord,
    CounterRecord,
    CountsRecord,
    Frozen,
    HistoryRecord,
    Members,
    MethodRecord,
    MonitorsRecord,
    Parts,
    Ref,
    RunRecord,
    Saved,
    SetRecord,
    TaskRecord,
    ThingWaitRecord,
    TopRecord,
    WaitRecord,
)
from rapc.runtime.state.history import History
from rapc.runtime.state.states import ENDED, RUNNING
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.runtime.state.things import Ask
from rapc.runtime.state.wait_state import WaitState
from rapc.world import Time, World


def capture(machine: Machine, seed: int, library: str, world: bytes) -> RunRecord:
    """Return all that a run holds now.

    `library` is the digest of the library, `world` what the world says of itself.
    """
    state = machine.state
    found = _Capture(machine)
    top_level = tuple(
        TopRecord(
            found.place_of(given.task),
            given.background,
            given.outcome,
            found.environment(given.outputs) if given.outputs else -1,
            given.because,
            given.came,
            given.ended,
        )
        for given in state.top_level
    )
    found.work_off()
    return RunRecord(
        library=library,
        world_name=machine.world.name,
        options=options_of(machine.world),
        settings=machine.settings,
        seed=seed,
        random=stream_state(machine.rng),
        counts=_counts(machine),
        added_methods=tuple(
            (name, method.node)
            for name, methods in state.added_methods.items()
            for method in methods
        ),
        resources=tuple(found.resources),
        environments=tuple(found.environments),
        tasks=tuple(found.tasks),
        top_level=top_level,
        scheduled=tuple(sorted(state.scheduled, key=lambda entry: entry[:2])),
        pending=tuple(
            (ticket, None if task is None else task.number, asked)
            for ticket, (task, asked) in state.pending.items()
        ),
        activations=_activations(machine),
        listening=tuple(
            (signal, tuple(tasks)) for signal, tasks in state.listening.items() if tasks
        ),
        agenda=_agenda(machine),
        monitors=_monitors(machine),
        memory=memory_saving.capture_memory(machine.parts),
        world=world,
    )


def options_of(world: World) -> dict[str, str | int | float | bool]:
    """Return the options that a world was made with, as far as that is known."""
    found: dict[str, str | int | float | bool] = {}
    for name, value in world.made_with.items():
        a_number = isinstance(value, int | float) and math.isfinite(value)
        found[name] = value if a_number else str(value)  # type: ignore[assignment]
    return found


def _counts(machine: Machine) -> CountsRecord:
    state, recorder = machine.state, machine.recorder
    counts = {name: getattr(state, name) for name in COUNTS}
    place = (recorder.time, recorder.cycle, recorder.serial)
    return CountsRecord(*place, **counts)


def _activations(machine: Machine) -> tuple[ActivationRecord, ...]:
    tables = machine.state.activations
    found = []
    for activation in (*tables.on.values(), *tables.off.values()):
        hearer = activation.hearer()
        found.append(
            ActivationRecord(
                activation.ticket,
                activation.owner,
                None if hearer is None else hearer.number,
                activation.skills,
                activation.run is not None,
            )
        )
    return tuple(found)


def _agenda(machine: Machine) -> AgendaRecord:
    agenda = machine.agenda
    sole, others = agenda.entries()
    return AgendaRecord(
        stack=tuple(agenda.stack),
        last_family=agenda.last_family,
        sole=sole,
        sorted=tuple((number, _time(late), failed) for number, late, failed in others),
    )


def _monitors(machine: Machine) -> MonitorsRecord:
    """Return what the monitors hold, by task number: who came first says nothing."""
    monitors = machine.monitors
    return MonitorsRecord(
        to_test=tuple(
            # a running task is tested when its method ends, whether it is here or not
            number
            for number, task in sorted(monitors.to_test.items())
            if task.state is not RUNNING
        ),
        aging=tuple(sorted(monitors.aging)),
        # where no belief ages it says nothing, and may be another after a restore
        tested_at=monitors.tested_at if monitors.aging else -1,
        deadlines=tuple(
            (time, task.number) for time, task in monitors.deadlines.entries()
        ),
        missed=tuple(
            (n, tuple(times)) for n, times in sorted(monitors.deadlines.missed.items())
        ),
        ways=tuple(sorted(machine.things.changed)),
        conflicts=machine.things.conflicts,
    )


def _time(time: float) -> Time | None:
    """Return a time; None for what lies infinitely far ahead."""
    return None if time == math.inf else time


class _Capture:
    """The lists of a `RunRecord` while they grow."""

    def __init__(self, machine: Machine) -> None:
        self.resources: list[CounterRecord | SetRecord] = []
        self.environments: list[dict[str, Saved]] = []
        self.tasks: list[TaskRecord] = []
        self._notations = machine.memory.notations
        self._things = machine.things
        self._waiting: list[Task] = []
        self._resource_places: dict[int, int] = {}
        self._environment_places: dict[int, int] = {}

    def place_of(self, task: Task) -> int:
        """Return the place that a task will have in `tasks`, once worked off."""
        self._waiting.append(task)
        return len(self._waiting) - 1

    def work_off(self) -> None:
        """Write down all tasks that have been given a place, and those below them."""
        for task in self._waiting:  # it grows meanwhile
            self.tasks.append(self._task(task))

    def _task(self, task: Task) -> TaskRecord:
        if task.state is ENDED and task.within is not None:
            return TaskRecord(task.plan.name, task.number, task.state)
        return TaskRecord(
            rap=task.plan.name,
            number=task.number,
            state=task.state,
            env=self.environment(task.env),
            family=task.family,
            priority=task.priority,
            limit=_time(task.limit),
            waiting=task.waiting,
            inputs=tuple([self._value(value) for value in task.goal_args]),
            identity=_key(task.identity),
            method=None if task.method is None else task.method.index,
            choice=_key(task.choice),
            last_result=task.last_result,
            history=None if task.history is None else self._history(task.history),
            wait=None if task.wait is None else self._wait(task, task.wait),
            things=self._thing_wait(task),
            run=None if task.run is None else self._run(task.run),
        )

    def _run(self, run: MethodRun) -> MethodRecord:
        ends = run.ends
        held = self._things.held.get(run.task.number, ())
        return MethodRecord(
            method=run.plan.index,
            env=self.environment(run.env),
            started=run.started,
            steps=tuple([self.place_of(step) for step in run.steps]),
            steps_left=run.steps_left,
            ends=None if ends is None else tuple(ends.times),
            ended_by_until=() if ends is None else tuple(sorted(ends.ended_by_until)),
            notations=tuple(self._notations.facts(run.notations)),
            skills=run.skills,
            ticket=run.ticket,
            held=tuple([_ask(hold.ask, hold.said) for hold in held]),
        )

    def _thing_wait(self, task: Task) -> ThingWaitRecord | None:
        wait = self._things.waits.get(task.number)
        if wait is None:
            return None
        ways = [tuple([_ask(ask) for ask in asks]) for asks in wait.alternatives]
        return ThingWaitRecord(
            tuple(ways), wait.on, wait.holder, wait.woken, wait.skills
        )

    def _history(self, history: History) -> HistoryRecord:
        success, before = history.success, history.before
        last, choices = history.last_choice, list(history.choices)
        return HistoryRecord(
            choices=tuple((_parts(key), n) for key, n in history.choices.items()),
            tries=tuple(history.tries.items()),  # type: ignore[arg-type]  # indexes
            last_choice=choices.index(last) if last in history.choices else None,
            before=None if before is None else before.index,
            results=tuple(history.results.items()),  # type: ignore[arg-type]  # names
            failures=tuple(history.failures.items()),
            failure=history.failure,
            because=history.because,
            success=None if success is None else self.environment(success),
        )

    def _wait(self, task: Task, wait: WaitState) -> WaitRecord:
        windows: tuple[int, ...] = ()
        if wait.windows and task.step is not None:
            windows = tuple([task.step.windows.index(w) for w in wait.windows])
        keys = wait.keys
        return WaitRecord(
            windows=windows,
            earliest_start=wait.earliest_start,
            awaits_signal=wait.awaits_signal,
            ready_at=wait.ready_at,
            made=wait.made,
            keys=None if keys is None else tuple([self._watched(key) for key in keys]),
            timer=wait.timer,
            blocked_on=wait.blocked_on,
            formula=wait.formula,
            given_deadline=_time(wait.given_deadline),
            monitor_deadline=_time(wait.monitor_deadline),
            missed=wait.missed,
            first_selected=wait.first_selected,
            after_method=wait.after_method,
            prepared=wait.prepared,
            setup_failed=wait.setup_failed,
            duration=wait.duration,
        )

    def _watched(self, key: WatchKey) -> tuple[Atom, ...] | Ref:
        return key if isinstance(key, tuple) else self._resource(key)

    def environment(self, env: Env) -> int:
        """Return the place of an environment; it is written down the first time."""
        place = self._environment_places.get(id(env))
        if place is None:
            place = self._environment_places[id(env)] = len(self.environments)
            self.environments.append({n: self._value(v) for n, v in env.items()})
        return place

    def _value(self, value: Value | None) -> Saved:
        if isinstance(value, Counter | SetResource):
            return self._resource(value)
        return value

    def _resource(self, resource: Counter | SetResource) -> Ref:
        place = self._resource_places.get(id(resource))
        if place is None:
            place = self._resource_places[id(resource)] = len(self.resources)
            if isinstance(resource, Counter):
                self.resources.append(CounterRecord(resource.value))
            else:
                self.resources.append(SetRecord(tuple(resource.members)))
        return Ref(place)


def _ask(ask: Ask, said: str = "") -> AskRecord:
    return AskRecord(ask.thing, ask.priority, ask.used, said)


def _key(key: tuple[object, ...] | None) -> Parts | None:
    return None if key is None else _parts(key)


def _parts(key: tuple[object, ...]) -> Parts:
    """Return a key, whose tuples nest three deep at most, as a record."""
    return Parts(tuple([_frozen(part) for part in key]))


def _frozen(part: object) -> Frozen:
    if isinstance(part, tuple):
        return _parts(part)
    if isinstance(part, frozenset):
        return Members(tuple(sorted(part, key=lambda m: (type(m).__name__, str(m)))))
    return part  # type: ignore[return-value]  # an atom, or None
