"""A session: a run that is stepped, stopped, changed, and taken back in time.

The past is reached by saved states and silent replay; what the user did to the run is
kept with the moments at which it was done, and done again. Changing something in the
past begins a new branch, and the other future stays. Not here: what is asked of a run
(`rapc.debug.why` and the modules beside it), how anything is shown (`rapc.repl`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rapc.debug.acts import Act
from rapc.debug.course import Branch, Course
from rapc.debug.log import EventLog
from rapc.debug.reload import TakeUp, changed
from rapc.debug.saves import Moment
from rapc.debug.stepped import Stop
from rapc.errors import ArgumentError, Error
from rapc.host import CheckedLibrary
from rapc.runtime.host_query import HostQuery
from rapc.runtime.interpreter import Interpreter

_NO_MORE_TO_DO = ("done", "stuck")
"""Why a run is over that goes on if something is done to it."""

_FEW = 16
"""Fewer cycles than these are sooner replayed than saved."""


class Session(Course):
    """A run under a debugger.

    Args:
        run: a run that has been begun, `log` among its listeners.
        log: gets its events.
    """

    def __init__(self, run: Interpreter, log: EventLog) -> None:
        super().__init__(run, log)
        self._questions: tuple[Interpreter, dict[str, HostQuery]] = (run, {})

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
        return cls(run, log)

    def go(
        self, until: Callable[[], str | None] | None = None, *, heed: bool = True
    ) -> Stop:
        """Run until something stops it: see `Stepped.go`."""
        stop = super().go(until, heed=heed)
        if self.cycle >= self._saved + _FEW and not self.over:
            self._save()
        return stop

    # --- acting -------------------------------------------------------------------

    def act(self, act: Act) -> None:
        """Do something to the run, now; in the past it begins a new branch.

        A run that is over because there was no more to do goes on with it.

        Raises:
            Error: if it cannot be done; then nothing has changed.
        """
        goes_on = self.reason in _NO_MORE_TO_DO and not self.no_way_back
        if goes_on:
            self.goto(self.cycle)
        branch, moment = self.branch, self.moment
        follower, self.log.follower = self.log.follower, None
        try:
            run = act.do(self.run)
        except Error:
            if goes_on:
                self.step()  # to its end again
            raise
        finally:
            self.log.follower = follower
        if moment < branch.end or moment.acts < len(branch.acts):
            branch = self._branch_off(moment)
        branch.acts.append((moment.cycle, act))
        branch.over = False
        self.run = run
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

    def question(self, text: str) -> HostQuery:
        """Return a formula made ready to be asked of the run, as it is made now.

        Raises:
            ValueError: for what is no formula, or names what is not declared.
        """
        run, ready = self._questions
        if run is not self.run:
            ready = {}
            self._questions = (self.run, ready)
        if text not in ready:
            ready[text] = self.run.question(text)
        return ready[text]

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
        before, after = self.run.machine.library.library, library.program.library
        act = TakeUp(library.program, changed(before, after))
        self.act(act)
        return act
