"""A session: a run that is stepped, stopped, changed, and taken back in time.

The past is reached by saved states and silent replay; what the user did to the run is
kept with the moments at which it was done, and done again. Changing something in the
past begins a new branch, and the other future stays. Not here: what is asked of a run
(`rapc.debug.why` and the modules beside it), how anything is shown (`rapc.repl`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import msgspec

from rapc.base.values import format_atom
from rapc.compiler.program import Program
from rapc.debug.acts import Act
from rapc.debug.forced import ForcedWorld, ForceResult
from rapc.debug.log import EventLog, Told
from rapc.debug.reload import TakeUp, take_up
from rapc.debug.saves import EVERY, Moment, Saves
from rapc.errors import ArgumentError, PortError, StateError
from rapc.host import CheckedLibrary
from rapc.runtime.events.events import TaskSelected
from rapc.runtime.interpreter import Interpreter
from rapc.world import Time, World

_RUNNING = 512
"""How many cycles a run goes on for before its state is saved."""

_FEW = 16
"""Fewer cycles than these are sooner replayed than saved."""


class Stop(msgspec.Struct, frozen=True):
    """Why a session has stopped."""

    #: `asked` for what was asked for, `over`, `break`, `pause` or `broken`.
    kind: str
    #: What there is to say of it, in words.
    said: str = ""


class Branch:
    """One course of a run: what the user did in it, and how far it has been seen."""

    def __init__(self, name: str, saves: Saves, begun: str = "") -> None:
        self.name = name
        #: Which branch it comes from, and where, in words; empty for the first.
        self.begun = begun
        #: What was done, each with the cycle after which it was done.
        self.acts: list[tuple[int, Act]] = []
        self.saves = saves
        #: The furthest moment that was reached.
        self.end = Moment(0)
        #: Where the user was when another branch was taken up.
        self.left = Moment(0)

    def acts_by(self, cycle: int) -> int:
        """Return how many acts have been done by the end of a cycle."""
        return sum(1 for done, _ in self.acts if done <= cycle)


class Session:
    """A run under a debugger.

    Args:
        run: a run that has been begun, `log` among its listeners.
        library: the library that it runs.
        log: gets its events.
    """

    def __init__(
        self, run: Interpreter, library: CheckedLibrary, log: EventLog
    ) -> None:
        self.run = run
        self._program = library.program
        self._world = run.machine.world
        self.log = log
        #: Why the run cannot be taken back in time; empty if it can.
        self.no_way_back = ""
        #: Asked after each cycle: text to stop with, or nothing.
        self.checks: dict[str, Callable[[], str | None]] = {}
        self._paused = False
        self._done = 0
        self._saved = 0
        self.branch = Branch("main", Saves())
        self.branches = [self.branch]
        self._save()

    @classmethod
    def open(cls, library: CheckedLibrary, world: Any, **more: Any) -> Session:
        """Begin a run and return a session with it.

        Args:
            library: what `rapc.load` returned.
            world: see `CheckedLibrary.start`.
            more: what else `CheckedLibrary.start` takes: `tasks`, `agenda`, `seed`, ...

        Raises:
            Error: as `CheckedLibrary.start`.
        """
        log = EventLog()
        listeners = [log, *more.pop("listeners", ())]
        run = library.start(world, listeners=listeners, **more)
        return cls(run, library, log)

    # --- where it stands ----------------------------------------------------------

    @property
    def cycle(self) -> int:
        """The number of the cycle that was run last."""
        return self.run.machine.recorder.cycle

    @property
    def now(self) -> Time:
        """The time of the clock."""
        return self.run.now

    @property
    def over(self) -> bool:
        """Whether the run is over, here."""
        return self.run.reason is not None

    @property
    def moment(self) -> Moment:
        """Return where the session stands."""
        return Moment(self.cycle, self._done)

    @property
    def serial(self) -> int:
        """The serial number that the next event will get."""
        return self.run.machine.recorder.serial

    @property
    def selected(self) -> int | None:
        """The number of the task whose cycle was run last."""
        told = self.log.last(TaskSelected)
        return None if told is None else told.keys["task"]

    # --- forwards -----------------------------------------------------------------

    def step(self, cycles: int = 1) -> Stop:
        """Run some cycles, or fewer if something stops the run."""
        left = cycles
        if left <= 0:
            return Stop("asked")

        def counted() -> str | None:
            nonlocal left
            left -= 1
            return "" if left == 0 else None

        return self.go(counted)

    def go(
        self, until: Callable[[], str | None] | None = None, *, heed: bool = True
    ) -> Stop:
        """Run until something stops it.

        Args:
            until: asked after each cycle; returns what to stop with, None to go on.
            heed: whether breakpoints stop it.
        """
        stop = self._run(until, heed)
        if self.cycle >= self._saved + _FEW and not self.over:
            self._save()
        return stop

    def _run(self, until: Callable[[], str | None] | None, heed: bool) -> Stop:
        """Run until something stops it; see `go`."""
        self._paused = False
        while True:
            if self.over:
                return Stop("over", self.run.reason or "")
            try:
                went = self._cycle()
            except PortError as error:
                return Stop("broken", error.message)
            if not went:
                return Stop("over", self.run.reason or "")
            for check in self.checks.values() if heed else ():
                if (hit := check()) is not None:
                    return Stop("break", hit)
            if until is not None and (said := until()) is not None:
                return Stop("asked", said)
            if self._paused:
                return Stop("pause")

    def pause(self) -> None:
        """Stop after the cycle under way; may be called by a signal handler."""
        self._paused = True

    def _cycle(self) -> bool:
        """Run a cycle, and redo what the user did after it in this branch."""
        if not self.run.step():
            return False
        branch, cycle = self.branch, self.cycle
        if self._done < len(branch.acts):
            self._redo()
        if cycle >= branch.end.cycle:
            branch.end = max(branch.end, Moment(cycle, self._done))
        if cycle >= self._saved + _RUNNING:
            self._save()
        return True

    def _redo(self) -> None:
        """Do what the user has done at this moment of the branch, if anything."""
        acts, cycle = self.branch.acts, self.cycle
        while self._done < len(acts) and acts[self._done][0] <= cycle:
            acts[self._done][1].do(self.run)
            self._done += 1

    def _save(self) -> None:
        self._saved = self.cycle
        if self.no_way_back:
            return
        try:
            self.branch.saves.add(self.moment, self.run.save())
        except StateError as error:
            self.no_way_back = error.message

    # --- acting -------------------------------------------------------------------

    def act(self, act: Act) -> None:
        """Do something to the run, now; in the past it begins a new branch.

        Raises:
            Error: if it cannot be done; then nothing has changed.
        """
        branch, moment = self.branch, self.moment
        act.do(self.run)
        if moment < branch.end or moment.acts < len(branch.acts):
            branch = self._branch_off(moment)
        branch.acts.append((moment.cycle, act))
        self._done += 1
        branch.end = self.moment

    def branch_off(self, name: str = "") -> Branch:
        """Begin a new branch here, and return it; the one before stays as it is.

        Raises:
            ArgumentError: for a name that is taken.
        """
        if any(name == branch.name for branch in self.branches):
            raise ArgumentError(f"there is a branch `{name}` already")
        return self._branch_off(self.moment, name)

    def _branch_off(self, moment: Moment, name: str = "") -> Branch:
        before = self.branch
        before.left = moment
        begun = f"{before.name} at cycle {moment.cycle}"
        name = name or f"branch-{len(self.branches)}"
        branch = Branch(name, before.saves.until(moment), begun)
        branch.acts = before.acts[: moment.acts]
        branch.end = branch.left = moment
        self.branches.append(branch)
        self.branch = branch
        return branch

    def switch(self, name: str) -> None:
        """Go on in another branch, where it was left.

        Raises:
            ArgumentError: if there is none of that name.
            StateError: if the run cannot be taken back in time.
        """
        self._look_back()
        for branch in self.branches:
            if branch.name == name:
                self.branch.left = self.moment
                self.branch = branch
                self._put_back(branch.left)
                return
        raise ArgumentError(f"there is no branch `{name}`")

    # --- backwards ----------------------------------------------------------------

    def goto(self, cycle: int, *, heed: bool = False) -> Stop:
        """Go to the end of a cycle, back or forth; forth as far as the run goes.

        Args:
            cycle: the number of the cycle.
            heed: whether breakpoints stop the run on the way forth.

        Raises:
            StateError: if the run cannot be taken back in time.
        """
        cycle = max(cycle, 0)
        if cycle < self.cycle or (cycle == self.cycle and self.over):
            self._look_back()
            self._put_back(Moment(cycle, self.branch.acts_by(cycle)))
            return Stop("asked")
        if cycle == self.cycle:
            return Stop("asked")
        return self._as_far(lambda: "" if self.cycle >= cycle else None, heed)

    def goto_time(self, time: Time, *, heed: bool = False) -> Stop:
        """Go to the last moment at or before a time, back or forth.

        Args:
            time: the time.
            heed: whether breakpoints stop the run on the way forth.

        Raises:
            StateError: if the run cannot be taken back in time.
        """
        if time < self.now:
            self._look_back()
            later = self.scan(want=lambda told: told.time > time)
            return self.goto(later[0].cycle - 1 if later else self.cycle)
        stop = self._as_far(lambda: "" if self.now > time else None, heed)
        if stop.kind == "asked" and not self.no_way_back:
            return self.goto(self.cycle - 1)
        return stop

    def _as_far(self, until: Callable[[], str | None], heed: bool) -> Stop:
        """Run as far as is asked; without `heed` nobody watches meanwhile."""
        if heed:
            return self.go(until)
        watcher, self.log.watcher = self.log.watcher, None
        try:
            return self.go(until, heed=False)
        finally:
            self.log.watcher = watcher

    def _look_back(self) -> None:
        if self.no_way_back:
            raise StateError(f"there is no way back: {self.no_way_back}")

    def _put_back(self, moment: Moment) -> None:
        """Take up the run as it was at a moment of the branch."""
        found = self.branch.saves.before(moment)
        if found is None:
            raise StateError("there is no saved state before that moment")
        at, state = found
        self.run.machine.library = self._program_at(at.acts)
        self.run.machine.world = self._world_at(at.acts)
        self.run.restore(state)
        self._done = at.acts
        if self.log.elsewhere is None:
            self.log.forget_from(self.serial)
        watcher, self.log.watcher = self.log.watcher, None
        try:
            while self.moment < moment:
                self._replay(moment)
        finally:
            self.log.watcher = watcher
        self._saved = at.cycle
        if self.log.elsewhere is None and self.cycle >= at.cycle + EVERY:
            self._save()

    def _replay(self, moment: Moment) -> None:
        """Do the next act of the branch, or run a cycle, on the way to a moment."""
        acts = self.branch.acts
        if self._done < moment.acts and acts[self._done][0] <= self.cycle:
            acts[self._done][1].do(self.run)
            self._done += 1
        elif not self.run.step():
            raise StateError(
                f"the replay has ended at cycle {self.cycle}, before {moment.cycle}: "
                "the world does not go on from its saved states as it did"
            )

    # --- looking at other moments -----------------------------------------------

    @contextmanager
    def aside(self) -> Iterator[None]:
        """Let something be done to the run, here, that is undone afterwards.

        Raises:
            StateError: if the run cannot be taken back in time.
        """
        self._look_back()
        here, done, saved = self.run.save(), self._done, self._saved
        world = self.run.machine.world
        before, self.log.elsewhere = self.log.elsewhere, _nobody
        try:
            yield
        finally:
            self.run.machine.library = self._program_at(done)
            self.run.machine.world = world
            self.run.restore(here)
            self._done, self._saved = done, saved
            self.log.elsewhere = before

    @contextmanager
    def elsewhere(self, cycle: int) -> Iterator[None]:
        """Stand at the end of another cycle of the past for a while, and come back.

        Whatever is done to the run meanwhile is undone.

        Raises:
            StateError: if the run cannot be taken back in time.
        """
        with self.aside():
            self._put_back(Moment(cycle, self.branch.acts_by(cycle)))
            yield

    def scan(
        self,
        *kinds: type[Any],
        first: int = 0,
        want: Callable[[Told], bool] | None = None,
    ) -> list[Told]:
        """Return events of the branch up to now, in order, from a cycle on.

        What is not in the log any more is made again by replay.

        Args:
            kinds: the kinds of events; all if there are none.
            first: the first cycle.
            want: says which of them are wanted; all if it is not given.

        Raises:
            StateError: if some are gone and the run cannot be taken back in time.
        """
        found: list[Told] = []

        def take(told: Told) -> None:
            if (
                told.cycle >= first
                and (not kinds or told.kind in kinds)
                and (want is None or want(told))
            ):
                found.append(told)

        if self.log.first > self._first_of(first):
            self._replay_all(first, take)
        else:
            for told in self.log.since(0):
                take(told)
        return found

    def _first_of(self, cycle: int) -> int:
        """Return the first serial number that must be kept to know all from a cycle."""
        if cycle > 1:
            for told in self.log.backwards():
                if told.cycle < cycle:
                    return told.serial
        return 0

    def _replay_all(self, first: int, take: Callable[[Told], None]) -> None:
        """Hand over all events from a cycle up to now, by replay."""
        until, over = self.moment, self.over
        with self.elsewhere(max(first - 1, 0)):
            for told in self.log.opening:
                if told.serial < self.serial:
                    take(told)
            self.log.elsewhere = take
            while self.moment < until:
                self._replay(until)
            if over:
                self.run.step()

    # --- the library ----------------------------------------------------------------

    @property
    def library(self) -> CheckedLibrary:
        """The library that runs now."""
        return CheckedLibrary(self.run.machine.library)

    def take_up(self, library: CheckedLibrary) -> TakeUp:
        """Go on with another text of the library, and return what was done.

        Raises:
            RefusedError: if the run cannot go on with it; then nothing has changed.
            StateError: if the run cannot be saved.
        """
        act = take_up(self.run, library)
        self.act(act)
        return act

    def _program_at(self, acts: int) -> Program:
        """Return the text that runs after so many acts of the branch."""
        for _, act in reversed(self.branch.acts[:acts]):
            if isinstance(act, TakeUp):
                return act.program
        return self._program

    def _world_at(self, acts: int) -> World:
        """Return the world as it was put together after so many acts of the branch."""
        forced = any(isinstance(act, ForceResult) for _, act in self.branch.acts[:acts])
        return ForcedWorld(self._world) if forced else self._world

    def stand(self) -> str:
        """Return where the session stands, in a line."""
        words = f"cycle {self.cycle}, time {format_atom(self.now)}"
        if self.branch.name != "main":
            words += f", {self.branch.name}"
        return f"{words}, run over ({self.run.reason})" if self.over else words


def _nobody(told: Told) -> None:
    """Hear of an event, and do nothing."""
