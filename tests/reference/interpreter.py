"""The reference interpreter: the loop of taking in, looking, choosing, processing.

For tests only: it makes the trace that pages 2 to 9 of docs/language ask for, as
slowly as it likes. Items are not in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, cast

from rapc import events
from rapc.base.values import Atom, Fact, match_pattern, number
from rapc.events import TaskResult
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.runtime.task_request import TaskRequest
from rapc.world import Time, World
from tests.reference.agenda import choose, tell_family
from tests.reference.cycle import process
from tests.reference.endings import remove
from tests.reference.giving_way import resume_skills
from tests.reference.kinds import Broken, hold_event, hold_fact, hold_goal
from tests.reference.methods import announce, create
from tests.reference.primitives import take_in
from tests.reference.run import Limits, Run
from tests.reference.signals import hear
from tests.reference.tasks import Task
from tests.reference.terms import Functions
from tests.reference.waking import look, next_time, read_inputs


class Reference:
    """One run of a library against a world; `events` is its trace."""

    def __init__(
        self,
        library: Library,
        world: World,
        seed: int,
        limits: Limits,
        functions: Functions,
        solvers: Functions,
    ) -> None:
        self._run = Run(library, world, seed, limits, functions, solvers)
        self._later: list[TaskRequest] = []

    @property
    def events(self) -> list[events.Event]:
        """The trace, without `run-started`."""
        return self._run.events

    def assert_fact(self, *fact: Atom) -> None:
        """Assert a fact on behalf of the user."""
        hold_fact(self._run.library, fact)
        self._run.memory.assert_fact(fact, "user")

    def erase(self, *prefix: Atom) -> None:
        """Erase every fact that starts so, on behalf of the user."""
        self._run.memory.erase(prefix, "user")

    def signal(self, *content: Atom) -> None:
        """Send a signal now."""
        hold_event(self._run.library, content)
        hear(self._run, content)

    def at(self, time: Time, action: Callable[[], None]) -> None:
        """Do something at a time, first of all that falls on it."""
        self._run.appointments.append((time, action))

    def cancel(self, goal: Fact) -> None:
        """Cancel every live top-level task that a goal matches."""
        for task in self._run.given:
            if (
                task.live
                and match_pattern(goal, (task.rap.name, *task.args)) is not None
            ):
                remove(self._run, task, "cancelled")

    def take_up(self, agenda: str) -> Iterator[TaskRequest]:
        """The tasks of an agenda, in the order of the text."""
        for task in self._run.library.agendas[agenda].tasks:
            args = [arg.value for arg in task.goal.args if isinstance(arg, nodes.Const)]
            yield TaskRequest(
                (task.goal.name, *args),
                task.priority,
                task.deadline,
                task.at,
                task.background,
            )

    def submit(self, submission: TaskRequest) -> None:
        """Give a task, now or for later. Raises WrongKind."""
        hold_goal(self._run.library, submission.goal)
        self._give(submission)

    def _give(self, submission: TaskRequest) -> None:
        if submission.at is not None and submission.at > self._run.time:
            self._later.append(submission)
            return
        run = self._run
        rap = run.library.raps[str(submission.goal[0])]
        task = create(run, rap, None, None)
        task.args = list(submission.goal[1:])
        task.priority = submission.priority
        task.background = submission.background
        task.given_deadline = submission.deadline
        run.given.append(task)
        announce(run, task)

    def run(self) -> str:
        """Run to the end; returns the reason. Raises Broken and WrongKind."""
        try:
            return self._go()
        except Broken:
            self._end("broken")
            raise

    def _go(self) -> str:
        run = self._run
        cycles = run.limits.cycles
        while True:
            if cycles is not None and run.cycle >= cycles:
                return self._end(self._over() or "cycles")
            reason = self._step()
            if reason is not None:
                return self._end(reason)

    def _step(self) -> str | None:
        """One cycle, waiting for its time to come; a reason if the run is over."""
        run = self._run
        while True:
            run.look_at_clock()
            if not run.late:
                self._take_in()
            reason = self._over()
            if reason is not None:
                return reason
            chosen = choose(run)
            if chosen is not None:
                self._cycle(chosen)
                return None
            reason = self._wait()
            if reason is not None:
                return reason

    def _take_in(self) -> None:
        """What falls on this time: the world's messages, new tasks, wake-ups."""
        run = self._run
        run.keep_appointments()
        take_in(run)
        due = [s for s in self._later if s.at is not None and s.at <= run.time]
        for submission in sorted(due, key=lambda s: s.at or 0):
            self._later.remove(submission)
            self._give(submission)
        for task in run.live():
            look(run, task)
        while resume_skills(run):
            for task in run.live():
                look(run, task)

    def _over(self) -> str | None:
        run = self._run
        if run.late:
            return "until"
        if run.world.ended() is not None:
            return "world"
        waiting = [task for task in run.given if task.live and not task.background]
        coming = [later for later in self._later if not later.background]
        if not (waiting or coming or run.appointments):
            left = self._later or any(task.live for task in run.given)
            alone = all(task.background for task in run.given)
            if run.limits.until is None or not left or not alone:
                return "done"
        if run.idle > run.limits.idle_cycles:
            return "runaway"
        return None

    def _cycle(self, task: Task) -> None:
        run = self._run
        before = run.time
        run.cycle += 1
        run.waits = 0
        if not task.full:
            read_inputs(run, task)
        tell_family(run, task)
        run.tell(events.TaskSelected, task=task.number, goal=task.goal())
        process(run, task)
        if run.limits.cycle_cost:
            run.world.advance(number(run.world.now() + run.limits.cycle_cost))
        run.look_at_clock()
        run.idle = run.idle + 1 if run.time == before else 0

    def _wait(self) -> str | None:
        run = self._run
        times = [next_time(run), run.world.next_time(), *(s.at for s in self._later)]
        known = [time for time in times if time is not None]
        known += [time for time, _ in run.appointments]
        if not known or run.waits == run.limits.idle_waits:
            return "stuck"
        target = max(min(known), run.time)
        if run.limits.until is not None and target > run.limits.until:
            if run.time == run.limits.until:
                return "until"
            target = run.limits.until
        run.idle = run.idle + 1 if target == run.time else 0
        run.waits += 1
        run.world.advance(target)
        if target == run.time:
            take_in(run)
        return None

    def _end(self, reason: str) -> str:
        results = self._results()
        for task in self._run.given:
            if task.live:
                remove(self._run, task, "run-over")
        self._run.tell(
            events.RunEnded, reason=reason, results=tuple(results), waiting=()
        )
        return reason

    def _results(self) -> Sequence[TaskResult]:
        return [
            TaskResult(
                task=task.number,
                goal=cast(Any, task.goal()),  # text: what the trace has
                outcome=task.outcome or ("unfinished" if task.live else "cancelled"),
                result=task.last_result if task.outcome else None,
                background=task.background,
            )
            for task in self._run.given
        ]
