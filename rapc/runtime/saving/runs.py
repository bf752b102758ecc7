"""A run as a record, and a record as a run that can replace another.

`RestoredRun` first makes all new objects, which reveals all errors in a record. Only
operations that cannot fail then change the run (`RestoredRun.install`).
"""

from __future__ import annotations

import math
from typing import Any

from msgspec.json import encode

from rapc.base.chance import stream_in, stream_state
from rapc.library.saved_check import UnsoundError
from rapc.runtime.memory.access import MemoryAccess
from rapc.runtime.run import Run, empty_memory
from rapc.runtime.saving.codecs import (
    Reader,
    Writer,
    WrongRecordError,
    fields_of,
    need,
)
from rapc.runtime.saving.format import RunRecord
from rapc.runtime.state.agenda import Agenda
from rapc.runtime.state.run_state import RunState
from rapc.runtime.state.states import ENDED, RUNNING
from rapc.runtime.state.task import MethodRun, Task
from rapc.runtime.state.things import Things
from rapc.world import World


def capture(run: Run, seed: int, world: bytes) -> RunRecord:
    """Return the record of a run; `world` is the saved state of the world.

    The capture changes nothing: no event, no serial, no draw.
    """
    state, recorder, monitors = run.state, run.recorder, run.monitors
    writer = Writer(run.access)
    tasks = [given.task for given in state.top_level]
    records = tuple([_written(writer, task, tasks) for task in tasks])  # `tasks` grows
    return RunRecord(
        library=run.library.digest,
        world_name=run.port.name,
        options=options_of(run.port),
        settings=run.settings,
        seed=seed,
        random=stream_state(run.rng),
        time=recorder.time,
        cycle=recorder.cycle,
        serial=recorder.serial,
        added_methods=tuple(
            (name, method.node)
            for name, methods in state.added_methods.items()
            for method in methods
        ),
        tasks=records,
        state=fields_of(RunState).write(writer, state),
        agenda=fields_of(Agenda).write(writer, run.eligible),
        things=fields_of(Things).write(writer, run.things),
        to_test=tuple(
            # a running task is tested when its method ends, whether saved or not
            number
            for number, task in sorted(monitors.to_test.items())
            if task.state is not RUNNING
        ),
        missed=tuple((n, tuple(times)) for n, times in sorted(monitors.missed.items())),
        tested_at=monitors.tested_at,
        memory=fields_of(MemoryAccess).write(writer, run.access),
        world=world,
        resources=tuple(writer.resources),
        environments=tuple(writer.environments),
    )


def _written(writer: Writer, task: Task, tasks: list[Task]) -> Any:
    """Return the record of a task, and add its steps to `tasks`."""
    if task.state is ENDED and task.within is not None:
        return task.plan.name, task.number
    if task.run is not None:
        tasks += task.run.steps
    writer.task = task
    return fields_of(Task).write(writer, task)


def options_of(world: World) -> dict[str, str | int | float | bool]:
    """Return the options of a world, as far as known."""
    found: dict[str, str | int | float | bool] = {}
    for name, value in world.made_with.items():
        a_number = isinstance(value, int | float) and math.isfinite(value)
        found[name] = value if a_number else str(value)  # type: ignore[assignment]
    return found


class RestoredRun:
    """The contents of a run made from a record, not yet installed in the run.

    Args:
        run: the run; its library names the plans.
        record: the record.

    Raises:
        WrongRecordError: for a record whose parts do not agree with each other or
            with the library.
    """

    def __init__(self, run: Run, record: RunRecord) -> None:
        self.run, self.record = run, record
        try:
            self._random = stream_in(record.random)
            #: The restored memory, separate from that of the run.
            self.access = empty_memory(run)
            reader = Reader(
                run.library, self.access, record.resources, record.environments
            )
            self.state, self.live = reader.state, reader.live
            self._add_methods()
            #: All tasks in the order of their records.
            self.tasks = self._read_tasks(reader)
            reader.given = iter(self.tasks)
            fields_of(RunState).fill(reader, self.state, record.state)
            self.state.settle()
            self.agenda: Agenda = fields_of(Agenda).read(reader, record.agenda)
            self.things: Things = fields_of(Things).read(reader, record.things)
            self.missed = {number: list(times) for number, times in record.missed}
            self.to_test = {number: self.live[number] for number in record.to_test}
            #: The methods under way by the numbers of their tasks.
            self.runs = {n: t.run for n, t in self.live.items() if t.run is not None}
            fields_of(MemoryAccess).read(reader, record.memory)
        except (LookupError, TypeError, ValueError, OverflowError) as error:
            raise WrongRecordError(f"{type(error).__name__}: {error}") from error

    def _add_methods(self) -> None:
        library, state = self.run.library, self.state
        present = {
            (name, method.index): method
            for name, methods in self.run.state.added_methods.items()
            for method in methods
        }
        for name, node in self.record.added_methods:
            plan = library.known_rap(name)
            try:
                index = len(state.methods(plan))
                method = present.get((name, index))
                # positions count as well: nodes are equal without them
                if method is None or encode(method.node) != encode(node):
                    method = library.added_method(plan, node, index)
            except UnsoundError as error:
                raise WrongRecordError(str(error)) from error
            state.added_methods.setdefault(name, []).append(method)

    def _read_tasks(self, reader: Reader) -> list[Task]:
        """Create the tasks: tasks of the host, then the steps of each in turn."""
        records, made = self.record.tasks, []
        places: list[Any] = [(None, None)] * len(self.record.state.top_level)
        # `places` grows in the loop.
        for (method_run, step), record in zip(places, records, strict=False):
            name = record[0] if isinstance(record, tuple) else record.plan
            task = reader.task = Task(reader.library.known_rap(name), method_run, step)
            made.append(task)
            if method_run is not None:
                method_run.steps.append(task)
            if isinstance(record, tuple):
                task.state, task.number = ENDED, record[1]
                need(method_run is not None, "a task of the host is missing")
                continue
            fields_of(Task).fill(reader, task, record)
            if method_run is None:
                task.family = task.number
            if task.live:
                self.live[task.number] = task
            if task.run is not None and task.run.plan.steps:
                task.run.begin_steps([])
                places += [(task.run, one) for one in task.run.plan.steps]
        need(len(made) == len(places) == len(records), "a task is missing")
        for task in made:
            if task.run is not None:
                _count_steps(task.run)
        return made

    def install(self) -> None:
        """Replace the contents of the run by these contents."""
        run, record = self.run, self.record
        run.access.take_up(self.access)
        run.rng.setstate(self._random.getstate())
        run.state = self.state
        run.recount_running_goals()
        run.recorder.jump(record.time, record.cycle, record.serial)
        run.eligible.take_up(self.agenda)
        run.things.take_up(self.things, self.runs)
        run.monitors.load(
            self.live.values(), self.to_test, self.missed, record.tested_at
        )


def _count_steps(method_run: MethodRun) -> None:
    """Count the live steps of a method, and the predecessors of each step."""
    steps = method_run.steps
    method_run.steps_left = sum(step.live for step in steps)
    for step in steps:
        step.waiting = 0
    for plan in method_run.plan.steps:
        if steps[plan.position].live:
            for after in plan.after:
                steps[after].waiting += 1
