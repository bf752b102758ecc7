"""Runs with a journal: begun, driven and resumed.

Not here: runs in the debugger (`rapc.durable.opening`).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from rapc.base.version import VERSION
from rapc.compiler.program import Program
from rapc.debug import act_lines
from rapc.debug.acts import (
    Act,
    AssertFact,
    CancelTasks,
    EraseFacts,
    ForceResult,
    SendSignal,
    SubmitTask,
)
from rapc.debug.history import Done
from rapc.debug.reload import TakeUp, changed
from rapc.durable import folder as files
from rapc.durable.folder import META, KeptEngine, Lock, Meta, Options, Stored, Writer
from rapc.durable.journal import Journal, Report, Trace
from rapc.durable.past import fill, past_of
from rapc.durable.resuming import Decide, ResumedWorld, settle_requests
from rapc.errors import ArgumentError, Error, StateError
from rapc.host import engine as find_engine
from rapc.host import engine_of, planner_of
from rapc.runtime.answers import Position
from rapc.runtime.events.recorder import Listener
from rapc.runtime.events.trace import JsonTrace
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.planner import Planner
from rapc.runtime.task_request import TaskRequest, read_task_request
from rapc.world import Atom, Fact, Savable, Time, World

if TYPE_CHECKING:
    from rapc.planning.engines import Engine


def enclosed(meta: Meta) -> Callable[[World], World]:
    """Return the wrapper of the world of a run from a journal."""

    def enclose(world: World) -> World:
        return world if isinstance(world, Savable) else ResumedWorld(world, meta.begun)

    return enclose


class DurableRun:
    """A run with a journal.

    Args:
        run: the run.
        journal: its journal.
        lock: the lock of the journal.
        trace: the file of its trace, if any.
    """

    def __init__(
        self, run: Interpreter, journal: Journal, lock: Lock, trace: Trace | None
    ) -> None:
        self.run = run
        self.journal = journal
        self._lock, self._trace = lock, trace
        #: The number of arrivals since the last cycle.
        self._arrivals = 0

    def step(self) -> bool:
        """Run one cycle, after its time has come; return False once the run is over.

        Raises:
            PortError: if the world breaks.
            WriteError: if the journal cannot be written.
        """
        self._arrivals = 0
        over = self.run.reason is not None
        going = self.run.step()
        if going:
            self.journal.after_cycle(self._trace)
        elif not over:
            if self._trace is not None:
                self._trace.size()
            self.journal.ended()
        return going

    def wait(self) -> bool:
        """Run to the next arrival before the next cycle; return False without any."""
        arrived = self.run.come_to_arrival()
        self._arrivals += arrived
        return arrived

    def go(self) -> str:
        """Run to the end; return the reason. Raises the errors of `step`."""
        while self.step():
            pass
        return self.run.reason or ""

    def submit(self, task: TaskRequest | str) -> None:
        """Submit a task: see `Interpreter.submit`."""
        if isinstance(task, str):
            task = read_task_request(task)
        self.act(SubmitTask(task))

    def cancel(self, goal: Fact) -> None:
        """Cancel the top-level tasks that a goal matches.

        Raises:
            ArgumentError: if there are none.
        """
        self.act(CancelTasks(goal))

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact: see `Interpreter.assert_fact`."""
        self.act(AssertFact(fact))

    def erase(self, *prefix: Atom) -> None:
        """Erase every fact that starts with `prefix`: see `Interpreter.erase`."""
        self.act(EraseFacts(prefix))

    def signal(self, *content: Atom) -> None:
        """Send a signal: see `Interpreter.signal`."""
        self.act(SendSignal(content))

    def act(self, act: Act) -> None:
        """Perform an act of the host between two cycles, and write it to the journal.

        Raises:
            StateError: in the middle of a cycle.
            ArgumentError: for a forced result.
            Error: if the act is impossible.
        """
        if self.run.in_loop:
            raise StateError("cannot change the run in the middle of a cycle")
        if isinstance(act, ForceResult):  # it wraps the world, which snapshots hold
            raise ArgumentError("cannot force results in a run with a journal")
        line = act_lines.written(act)
        self.journal.act(self.run.cycle, self._arrivals, line)
        try:
            self._perform(act)
        except Error:
            self.journal.void()
            raise

    def _perform(self, act: Act) -> None:
        self.run.in_journal = False
        try:
            other = act.do(self.run)
        finally:
            self.run.in_journal = True
        if other is not None:
            self.run = other
            other.in_journal = True
            self.journal.follow(other)
        if isinstance(act, TakeUp):
            self.journal.library = act_lines.library_in_text(act.program)

    def repeat(self, acts: Iterable[Done]) -> None:
        """Repeat the acts of the journal at their moments.

        Raises:
            StateError: if the run ends before.
        """
        for done in acts:
            self.reach(done.cycle)
            while self._arrivals < done.arrivals and self.wait():
                pass
            if (self.run.cycle, self._arrivals) != (done.cycle, done.arrivals):
                raise StateError(
                    f"cannot repeat an act of the host at cycle {done.cycle}: the run "
                    "does not go on as it did"
                )
            self._perform(done.act)

    def reach(self, cycle: int) -> None:
        """Run to the end of a cycle, or of the run."""
        while self.run.cycle < cycle and self.step():
            pass

    def settle(self) -> None:
        """Run to the end of the cycle in which the journal ends."""
        answers = self.run.keep_answers()
        while answers.at_end is not None and self.step():
            pass

    def close(self) -> None:
        """Close all files and release the lock."""
        if self._trace is not None:
            self._trace.close()
        self.journal.close()
        self._lock.release()


def begin(
    folder: Path,
    run: Interpreter,
    options: Options | None = None,
    *,
    until: Time | None = None,
    trace: Path | None = None,
    reports: Sequence[Report] = (),
) -> DurableRun:
    """Begin the journal of a run that has not begun; then begin the run.

    Args:
        folder: the folder of the journal; it must be empty or missing.
        run: the run; `Interpreter.prepared` made it, or `start` with `begin=False`.
        options: the options of the journal; None: the defaults.
        until: the time limit of the run.
        trace: the file for its trace.
        reports: listeners whose state is part of a snapshot.

    Raises:
        WriteError: if a file cannot be written, or the folder is not empty.
        StateError: if another process uses the folder.
        PortError: if the world breaks.
    """
    options = options or Options()
    lock = Lock(folder)
    spec = msgspec.structs.replace(run.spec, until=until)
    library = act_lines.library_in_text(run.library)
    named = "" if trace is None else str(trace)
    meta = Meta(VERSION, spec, library, run.now, named, options, _kept(run.planner))
    files.create(folder, meta)
    journal = Journal(folder, Writer(folder, 1), options, reports)
    run.keep_answers().position = Position()
    journal.follow(run)
    file = _traced(run, trace)
    run.start(until)
    run.in_journal = True
    return DurableRun(run, journal, lock, file)


def resume(
    folder: Path,
    library: Program,
    world: World,
    *,
    options: Options | None = None,
    decide: Decide = lambda request: "fail",
    trace: Path | None = None,
    take_up: bool = False,
    engine: Engine | None = None,
    **code: Any,
) -> DurableRun:
    """Resume a run from its journal.

    Args:
        folder: the folder of the journal.
        library: the library, as its files have it.
        world: a new world, made like the first world of the run.
        options: the options of the journal; None: those before.
        decide: decides on requests under way whose treatment is `ask`.
        trace: the file for its trace; it continues the trace of the first process.
        take_up: whether the library may differ from that of the run.
        engine: the engine of the run, if `rapc.engine` did not make it.
        code: `functions`, `solvers`, `comparators`: see `Interpreter.prepared`.

    Raises:
        Error: if the run cannot be continued.
    """
    found = Resumption(folder, library, take_up=take_up)
    meta = found.stored.meta
    try:
        planner, enclosing = planner_for(meta, engine), enclosed(meta)(world)
        run = Interpreter.prepared(
            found.program, enclosing, meta.spec, planner=planner, **code
        )
        return found.resume(run, options or meta.options, decide, trace=trace)
    except BaseException:
        found.release()
        raise


def _kept(planner: Planner | None) -> KeptEngine | None:
    """Return the engine that a planner asks first, for a journal."""
    engine = engine_of(planner)
    if engine is None:
        return None
    timeout = getattr(engine, "timeout", None)
    return KeptEngine(engine.name, timeout, getattr(engine, "costs", True))


def planner_for(meta: Meta, engine: Engine | None = None) -> Planner:
    """Return the planner of a run from a journal, which asks the same engine as before.

    Raises:
        StateError: without `engine` for an engine of the host's own.
        PlanError: for an engine that is not installed.
    """
    kept = meta.engine
    if engine is None and kept is not None:
        if kept.timeout is None:
            raise StateError(
                f"cannot resume: the run asks the engine `{kept.name}` of a program",
                "resume the run in this program, with `engine`",
            )
        engine = find_engine(kept.name, kept.timeout, costs=kept.costs)
    return planner_of(engine)


def _traced(run: Interpreter, trace: Path | None, size: int = 0) -> Trace | None:
    if trace is None:
        return None
    file = Trace(trace, size)
    run.listen(JsonTrace(file))
    return file


class Resumption:
    """A run that is resumed from its journal.

    Args:
        folder: the folder.
        loaded: the library as its files have it; the run goes on with it.
        take_up: whether the library may differ from that of the run.

    Raises:
        LoadError: if the journal cannot be read or is damaged.
        StateError: if another process runs the run, or the library has changed.
    """

    def __init__(self, folder: Path, loaded: Program, *, take_up: bool = False) -> None:
        files.read_meta(folder)  # no lock is made in other folders
        self._lock = Lock(folder)
        try:
            self._read(folder, loaded, take_up)
        except BaseException:
            self.release()
            raise

    def release(self) -> None:
        """Release the lock of a run that is not resumed."""
        self._lock.release()

    def _read(self, folder: Path, loaded: Program, take_up: bool) -> None:
        self.stored: Stored = files.read(folder)
        snapshot = self.stored.snapshot
        self._past = past_of(self.stored.records, self.stored.first_cycle)
        self._loaded = loaded
        first = snapshot.library if snapshot else None
        #: The library of the run at the snapshot.
        self.program = _program(first or self.stored.meta.library, loaded)
        present = self.program
        for done in self._past.acts:
            present = done.act.program if isinstance(done.act, TakeUp) else present
        self._changed = present.digest != loaded.digest
        if self._changed and not take_up:
            raise StateError(
                f"cannot resume: the library `{self.stored.meta.spec.library}` has "
                "changed",
                "use --take-up to go on with the changed library",
            )

    def resume(
        self,
        run: Interpreter,
        options: Options,
        decide: Decide,
        *,
        trace: Path | None = None,
        reports: Sequence[Report] = (),
        hear_past: Listener | None = None,
    ) -> DurableRun:
        """Return the run, as far as the journal knows it.

        Args:
            run: a run of `program` that has not begun, made with `enclosed`.
            options: the options of the journal.
            decide: decides on requests under way whose treatment is `ask`.
            trace: the file of its trace.
            reports: listeners whose state is part of a snapshot.
            hear_past: receives the events in place of those before the snapshot, if
                there is one: see `Interpreter.past`.

        Raises:
            Error: if the run cannot be continued.
        """
        stored, past, snapshot = self.stored, self._past, self.stored.snapshot
        seconds = max(time.time() - _last_written(stored), 0)
        last = stored.last
        answers = run.keep_answers()
        fill(answers, stored, past)
        size = (snapshot.trace or 0) if snapshot else 0
        file = _traced(run, trace, size)
        writer = Writer(stored.folder, last.number, last.end)
        journal = Journal(stored.folder, writer, options, reports)
        journal.library = snapshot.library if snapshot else None
        durable = DurableRun(run, journal, self._lock, file)

        def at_end(*question: Any) -> bool:
            if past.sent is not None and question != past.sent:
                raise StateError(
                    f"cannot resume: the run asks `{question[0]}` of the world where "
                    f"it asked `{past.sent.call}` before"
                )
            answers.at_end = None
            treatments = options.after_crash
            settle_requests(
                durable.run, question, past.sent, treatments, decide, seconds
            )
            return False

        if not isinstance(run.world, Savable):
            answers.at_end = at_end
        journal.follow(run)
        if snapshot is None:
            run.start(stored.meta.spec.until)
        else:
            run.restore(snapshot.run)
            for report, state in zip(reports, snapshot.reports, strict=False):
                report.take_up(state)
            if hear_past is not None:
                for event in run.past():
                    hear_past(event)
        run.in_journal = True
        durable.repeat(past.acts)
        if self._changed:
            durable.reach(past.cycle)
            durable.settle()
            before, after = durable.run.library.library, self._loaded.library
            durable.act(TakeUp(self._loaded, changed(before, after)))
        return durable


def _program(library: act_lines.Library, loaded: Program) -> Program:
    """Return the library of some texts, which is often `loaded`."""
    there = {name: file.text for name, file in loaded.library.files.items()}
    if [one.text for one in library.files] == [*there.values()]:
        return loaded
    return act_lines.read_library(library)


def _last_written(stored: Stored) -> float:
    """Return the time of the last record, in seconds."""
    part = files.part_file(stored.folder, stored.last.number)
    snapshot = files.snapshot_file(stored.folder, stored.last.number)
    written = (part, snapshot, stored.folder / META)
    return next(one.stat().st_mtime for one in written if one.exists())
