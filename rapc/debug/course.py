"""A run with its past: it can be put at any moment of a branch, and goes on from there.

Branches are the courses that it has taken under the hands of its user. A moment is
reached by the state saved before it and silent replay; acts are done again
where they were done. What a run is made with, its library and settings, may change by
an act, and goes back with it. Not here: what stops a run, and who may change what
(`rapc.debug.session`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rapc.debug.acts import Act, Setup
from rapc.debug.forced import ForcedWorld, ForceResult
from rapc.debug.log import EventLog, ToldEvent, Wanted
from rapc.debug.saves import EVERY, Moment, Saves
from rapc.debug.stepped import Stepped
from rapc.errors import PortError, StateError
from rapc.runtime.interpreter import Interpreter
from rapc.world import Time, World

_RUNNING = 512
"""How many cycles a run goes on for before its state is saved."""


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
        #: Whether the run was over after that.
        self.over = False
        #: Where the user was when another branch was taken up.
        self.left = Moment(0)

    def acts_by(self, cycle: int) -> int:
        """Return how many acts have been done by the end of a cycle."""
        return sum(1 for done, _ in self.acts if done <= cycle)

    def setup_after(self, acts: int, first: Setup) -> Setup:
        """Return what the run is made with after so many acts, `first` before them."""
        found = first
        for _, act in self.acts[:acts]:
            found = act.setup(found)
        return found

    def world_after(self, acts: int, first: World) -> World:
        """Return the world as put together after so many acts, `first` before them."""
        forced = any(isinstance(act, ForceResult) for _, act in self.acts[:acts])
        return ForcedWorld(first) if forced else first


class Course(Stepped):
    """A run and what has been seen of it, branch by branch.

    Args:
        run: a run that has been begun, `log` among its listeners.
        log: gets its events.
    """

    def __init__(self, run: Interpreter, log: EventLog) -> None:
        super().__init__(log)
        #: The run; an act that changes what it is made with puts another in its place.
        self.run = run
        self.branch = Branch("main", Saves())
        self.branches = [self.branch]
        self._setup = Setup.of(run)
        self._world = run.machine.world.behind
        self._done = 0
        self._saved = 0
        self._save()

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
    def reason(self) -> str:
        """The reason why the run is over, here; empty while it is not."""
        return self.run.reason or ""

    @property
    def seen(self) -> int:
        """The furthest cycle that was seen in this branch."""
        return self.branch.end.cycle

    @property
    def seen_over(self) -> bool:
        """Whether the run was seen to be over there."""
        return self.branch.over

    @property
    def moment(self) -> Moment:
        """Return where the session stands."""
        return Moment(self.cycle, self._done)

    @property
    def serial(self) -> int:
        """Return the serial number that the next event will get."""
        return self.run.machine.recorder.serial

    def stand(self) -> str:
        """Return where the run stands, in a line."""
        words = super().stand()
        return words if self.branch.name == "main" else f"{words}, {self.branch.name}"

    # --- forwards

    def _cycle(self) -> bool:
        """Run a cycle, and redo what the user did after it in this branch."""
        if not self.run.step():
            self.branch.over = True
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
            self._do(acts[self._done][1])

    def _do(self, act: Act) -> None:
        """Do an act, and go on with the run that it returns."""
        self.run = act.do(self.run)
        self._done += 1

    def _save(self) -> None:
        self._saved = self.cycle
        if self.no_way_back:
            return
        try:
            self.branch.saves.add(self.moment, self.run.save())
        except (StateError, PortError) as error:
            self.no_way_back = error.message

    # --- backwards

    def _look_back(self) -> None:
        if self.no_way_back:
            raise StateError(f"there is no way back: {self.no_way_back}")

    def _go_back(self, cycle: int) -> None:
        self._look_back()
        self._put_back(Moment(cycle, self.branch.acts_by(cycle)))

    def _put_back(self, moment: Moment) -> None:
        """Take up the run as it was at a moment of the branch."""
        found = self.branch.saves.before(moment)
        if found is None:
            raise StateError("there is no saved state before that moment")
        at, state = found
        self.run = self.branch.setup_after(at.acts, self._setup).made(self.run)
        self.run.machine.world.enclose(self.branch.world_after(at.acts, self._world))
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
            self._do(acts[self._done][1])
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
        run, here, done, saved = self.run, self.run.save(), self._done, self._saved
        world = run.machine.world.behind
        before, self.log.elsewhere = self.log.elsewhere, _nobody
        try:
            yield
        finally:
            self.run = run
            run.machine.world.enclose(world)
            run.restore(here)
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
        want: Callable[[ToldEvent], bool] | None = None,
    ) -> list[ToldEvent]:
        """Return events of the branch: see `Stepped.scan`.

        What is not in the log any more is made again by replay.
        """
        found: list[ToldEvent] = []

        wanted = Wanted(kinds, first, want)

        def take(told: ToldEvent) -> None:
            if wanted.fits(told):
                found.append(told)

        if self.log.first > self.log.first_from(first):
            self._replay_all(first, take)
        else:
            for told in self.log.since(0):
                take(told)
        return found

    def _replay_all(self, first: int, take: Callable[[ToldEvent], None]) -> None:
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


def _nobody(told: ToldEvent) -> None:
    """Hear of an event, and do nothing."""
