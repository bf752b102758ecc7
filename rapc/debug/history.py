"""A history: a run at any moment, with what was done to it.

A moment is reached by the state saved before it and silent replay; acts are done again
where they were done. An act in the past begins a branch, and the other future stays. A
recorded run whose library or world is missing is a history, too: it can be stepped and
searched, not asked or changed. Not here: questions (`rapc.debug.questions`), and how
anything is shown (`rapc.repl`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import msgspec

from rapc.base.values import readable
from rapc.compiler.program import Program
from rapc.debug.acts import Act
from rapc.debug.log import EventLog, Hear, ToldEvent, Want
from rapc.debug.recording import Playback
from rapc.debug.reload import TakeUp, changed
from rapc.errors import ArgumentError, Error, PortError, StateError
from rapc.events import Event, TaskSelected
from rapc.host import CheckedLibrary
from rapc.runtime.host_query import HostQuery
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.world import Time, World

_NO_MORE_TO_DO = ("done", "stuck")
"""Why a run is over that goes on if something is done to it."""

_FEW = 16
"""Fewer cycles than these are sooner replayed than saved."""

_EVERY = 64
"""How many cycles lie between two saved states at first."""

_RUNNING = 512
"""How many cycles a run goes on for before its state is saved."""

_SHARE = 12
"""A gap between saved states is at most this part of their distance from now, then."""

_ONLY_TO_LOOK_AT = (
    "this is a recorded run without what it ran: it can be stepped, searched and told, "
    "not asked or changed"
)


class Stop(msgspec.Struct, frozen=True):
    """Why a run has stopped."""

    #: `asked` for what was asked for, `over`, `break`, `pause` or `broken`.
    kind: str
    #: What there is to say of it, in words.
    said: str = ""


class Moment(NamedTuple):
    """A place in a run: after a cycle, and after so many acts of the host in all."""

    cycle: int
    acts: int = 0


_BEGINNING = Moment(0)


class Save(NamedTuple):
    """A saved state of a run, and what the run was made with then."""

    state: bytes
    program: Program
    settings: Settings
    world: World


@dataclass
class Branch:
    """One course of a run: what the user did in it, and how far it has been seen."""

    name: str
    #: Which branch it comes from, and where, in words; empty for the first.
    begun: str = ""
    #: What was done, each with the cycle after which it was done.
    acts: list[tuple[int, Act]] = field(default_factory=list)
    #: Saved states in the order of their moments.
    saves: dict[Moment, Save] = field(default_factory=dict)
    #: The furthest moment that was reached.
    end: Moment = _BEGINNING
    #: Whether the run was over after that.
    over: bool = False
    #: Where the user was when another branch was taken up.
    left: Moment = _BEGINNING

    def moment_after(self, cycle: int) -> Moment:
        """Return the moment at the end of a cycle, after all that was done then."""
        return Moment(cycle, sum(1 for done, _ in self.acts if done <= cycle))

    def begun_at(self, moment: Moment, name: str) -> Branch:
        """Return a branch that begins at a moment of this one."""
        begun = f"{self.name} at cycle {moment.cycle}"
        saves = {at: save for at, save in self.saves.items() if at <= moment}
        acts = self.acts[: moment.acts]
        return Branch(name, begun, acts, saves, end=moment, left=moment)

    def keep(self, moment: Moment, save: Save) -> None:
        """Keep a state of now, and let states go: the older, the fewer are kept.

        A state goes if the gap around it is small for its age without it. So there are
        a few dozen of a run of any length, and the way back is never long to replay.
        """
        self.saves.setdefault(moment, save)
        at = sorted(self.saves)
        kept = at[:1]
        for here, after in pairwise(at[1:]):
            gap, age = after.cycle - kept[-1].cycle, moment.cycle - here.cycle
            if gap > max(_EVERY, age // _SHARE):
                kept.append(here)
        if len(at) > 1:
            kept.append(at[-1])
        self.saves = {at: self.saves[at] for at in kept}


class History:
    """A run that is stepped, stopped, changed, and put at any moment of its past.

    Args:
        run: a run that has been begun, `log` among its listeners; or a recording that
            is only played.
        log: gets the events of the run; it may be left out for a recording.
    """

    def __init__(
        self, run: Interpreter | Playback, log: EventLog | None = None
    ) -> None:
        self._run = run
        self.log: EventLog | Playback = log or EventLog()
        #: Why there is no way back; empty if there is one.
        self.no_way_back = ""
        #: Asked after each cycle: text to stop with, or nothing.
        self.checks: dict[str, Callable[[], str | None]] = {}
        #: Asked after each stop: a line to be told, or nothing.
        self.notes: list[Callable[[], str]] = []
        self.branch = Branch("main")
        self.branches = [self.branch]
        #: The serial number of the first event that no check has looked at.
        self.fresh = self.serial
        self._paused = False
        self._done = 0
        self._saved = 0
        self._questions: tuple[object, dict[str, HostQuery]] = (run, {})
        if isinstance(run, Playback):
            self.log = run
            self.branch.end, self.branch.over = Moment(run.last_cycle), True
        self._save()

    @classmethod
    def open(cls, library: CheckedLibrary, world: Any, **more: Any) -> History:
        """Begin a run and return its history.

        Args:
            library: what `rapc.load` returned.
            world: see `CheckedLibrary.start`.
            more: what else `CheckedLibrary.start` takes: `tasks`, `agenda`, `seed`, ...

        Raises:
            Error: as `CheckedLibrary.start`.
        """
        log = EventLog()
        listeners = [log, *more.pop("listeners", ())]
        return cls(library.start(world, listeners=listeners, **more), log)

    # --- where it stands ----------------------------------------------------------

    @property
    def run(self) -> Interpreter:
        """The run; an act that changes what it is made with puts another in its place.

        Raises:
            StateError: for a recorded run that is only looked at.
        """
        if isinstance(self._run, Playback):
            raise StateError(_ONLY_TO_LOOK_AT)
        return self._run

    @property
    def is_run(self) -> bool:
        """Whether it can be asked and changed: no recording that is only played."""
        return not isinstance(self._run, Playback)

    def check_is_run(self) -> None:
        """Raise StateError for a recorded run that is only looked at."""
        if not self.is_run:
            raise StateError(_ONLY_TO_LOOK_AT)

    @property
    def cycle(self) -> int:
        """The number of the cycle that was run last."""
        run = self._run
        return run.cycle if isinstance(run, Playback) else run.recorder.cycle

    @property
    def serial(self) -> int:
        """The serial number that the next event will get."""
        run = self._run
        return run.serial if isinstance(run, Playback) else run.recorder.serial

    @property
    def now(self) -> Time:
        """The time of the clock."""
        return self._run.now

    @property
    def reason(self) -> str:
        """The reason why the run is over, here; empty while it is not."""
        return self._run.reason or ""

    @property
    def over(self) -> bool:
        """Whether the run is over, here."""
        return self.reason != ""

    @property
    def moment(self) -> Moment:
        """Where the run stands."""
        return Moment(self.cycle, self._done)

    @property
    def seen(self) -> int:
        """The furthest cycle that was seen in this branch."""
        return self.branch.end.cycle

    @property
    def seen_over(self) -> bool:
        """Whether the run was seen to be over after that cycle."""
        return self.branch.over

    @property
    def selected(self) -> int | None:
        """The number of the task whose cycle was run last."""
        told = next(self.log.backwards(TaskSelected), None)
        return None if told is None else told.keys["task"]

    def stand(self) -> str:
        """Return where the run stands, in a line."""
        words = f"cycle {self.cycle}, time {readable(self.now)}"
        words += f", run over ({self.reason})" if self.over else ""
        return words if self.branch.name == "main" else f"{words}, {self.branch.name}"

    # --- forwards -----------------------------------------------------------------

    def step(self, cycles: int = 1) -> Stop:
        """Run some cycles, or fewer if something stops the run."""
        if cycles <= 0:
            return Stop("asked")
        last = self.cycle + cycles
        return self.go(lambda: "" if self.cycle >= last else None)

    def go(
        self, until: Callable[[], str | None] | None = None, *, heed: bool = True
    ) -> Stop:
        """Go on until something stops it.

        Args:
            until: asked after each cycle; returns what to stop with, None to go on.
            heed: whether breakpoints stop it.
        """
        stop = None
        while stop is None:
            stop = self._step(until, heed)
        if self.cycle >= self._saved + _FEW and not self.over:
            self._save()
        return stop

    def _step(self, until: Callable[[], str | None] | None, heed: bool) -> Stop | None:
        """Run a cycle; return what stops the run then, if anything does."""
        try:
            if self.over or not self._cycle():
                return Stop("over", self.reason)
        except PortError as error:
            return Stop("broken", error.message)
        hits = (check() for check in self.checks.values()) if heed else ()
        hit = next((one for one in hits if one is not None), None)
        self.fresh = self.serial
        if hit is not None:
            return Stop("break", hit)
        if until is not None and (said := until()) is not None:
            return Stop("asked", said)
        if self._paused:
            self._paused = False
            return Stop("pause")
        return None

    def _cycle(self) -> bool:
        """Run a cycle, and redo what the user did after it in this branch.

        Returns:
            Whether there was one: the run may be over instead.
        """
        if not self._run.step():
            self.branch.over = True
            return False
        branch, cycle = self.branch, self.cycle
        while self._done < len(branch.acts) and branch.acts[self._done][0] <= cycle:
            self._do(branch.acts[self._done][1])
        if cycle >= branch.end.cycle:
            branch.end = max(branch.end, Moment(cycle, self._done))
        if cycle >= self._saved + _RUNNING:
            self._save()
        return True

    def _do(self, act: Act) -> None:
        """Do an act, and go on with the run that takes the place of this one."""
        self._run = act.do(self.run) or self.run
        self._done += 1

    def _save(self) -> None:
        self._saved = self.cycle
        run = self._run
        if self.no_way_back or isinstance(run, Playback):
            return
        try:
            world = run.port.behind
            save = Save(run.save(), run.library, run.settings, world)
            self.branch.keep(self.moment, save)
        except (StateError, PortError) as error:
            self.no_way_back = error.message

    def pause(self, wanted: bool = True) -> None:
        """Stop after the cycle under way, or the first one if none is; or do not.

        May be called by a signal handler.
        """
        self._paused = wanted

    # --- other moments --------------------------------------------------------------

    def goto(self, cycle: int, *, heed: bool = False) -> Stop:
        """Go to the end of a cycle, back or forth; forth as far as the run goes.

        Args:
            cycle: the number of the cycle.
            heed: whether breakpoints stop the run on the way forth.

        Raises:
            StateError: if the run cannot be taken back in time.
        """
        cycle = max(cycle, 0)
        if isinstance(self._run, Playback):
            self._run.goto(cycle)
            return Stop("over", self.reason) if self.over else Stop("asked")
        if cycle > self.cycle:
            return self.go(lambda: "" if self.cycle >= cycle else None, heed=heed)
        if cycle < self.cycle or self.over:
            self._put_back(self.branch.moment_after(cycle))
        return Stop("asked")

    def goto_time(self, time: Time, *, heed: bool = False) -> Stop:
        """Go to the last moment at or before a time, back or forth.

        Args:
            time: the time.
            heed: whether breakpoints stop the run on the way forth.

        Raises:
            StateError: if the run cannot be taken back in time.
        """
        if isinstance(self._run, Playback):
            return self.goto(self._run.cycle_by(time))
        if time < self.now:
            later = self.scan(want=lambda told: told.time > time)
            found = next(iter(later), None)
            stop = self.goto(self.cycle if found is None else found.cycle)
        else:
            stop = self.go(lambda: "" if self.now > time else None, heed=heed)
            if self.no_way_back or stop.kind not in ("asked", "over"):
                return stop
            if self.over and self.now > time:  # the clock ran on as the run ended
                stop = self.goto(self.cycle)
        return self.goto(self.cycle - 1) if self.now > time else stop

    def _look_back(self) -> None:
        if self.no_way_back:
            raise StateError(f"there is no way back: {self.no_way_back}")

    def _put_back(self, moment: Moment) -> None:
        """Take up the run as it was at a moment of the branch."""
        self._look_back()
        saves = self.branch.saves
        at = max((one for one in saves if one <= moment), default=None)
        if at is None:
            raise StateError("there is no saved state before that moment")
        run, save = self.run, saves[at]
        if run.library is not save.program or run.settings != save.settings:
            run = run.remade(save.program, save.settings)
        run.port.enclose(save.world)
        run.restore(save.state)
        self._run, self._done, self._saved = run, at.acts, at.cycle
        aside = self._log.elsewhere is not None
        if not aside:
            self._log.forget_from(self.serial)
        while self.moment < moment:
            self._replay(moment)
        if not aside:
            self.fresh = self.serial
            if self.cycle >= at.cycle + _EVERY:
                self._save()

    @property
    def _log(self) -> EventLog:
        """The log of a run that can be asked."""
        assert isinstance(self.log, EventLog)
        return self.log

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

    @contextmanager
    def at(self, cycle: int | None = None) -> Iterator[Interpreter]:
        """Stand at the end of another cycle of the past for a while, and come back.

        Whatever is done to the run meanwhile is undone.

        Args:
            cycle: the cycle; the run stays where it is if none is given.

        Yields:
            the run as it was then.

        Raises:
            StateError: if the run cannot be taken back in time.
        """
        self._look_back()
        run, here, done, saved = self.run, self.run.save(), self._done, self._saved
        world = run.port.behind
        log, before = self._log, self._log.elsewhere
        log.elsewhere = _nobody
        try:
            if cycle is not None:
                self._put_back(self.branch.moment_after(cycle))
            yield self.run
        finally:
            run.port.enclose(world)
            run.restore(here)
            self._run, self._done, self._saved = run, done, saved
            log.elsewhere = before

    def ahead(self, acts: Iterable[Act], cycles: int) -> list[ToldEvent]:
        """Return the events of the next cycles after some acts: tried, and undone.

        Raises:
            Error: if an act cannot be done.
            StateError: if the run cannot be taken back in time.
        """
        found: list[ToldEvent] = []
        with self.at():
            for act in acts:
                self._run = act.do(self.run) or self.run
            self._log.elsewhere = found.append
            for _ in range(cycles):
                if not self.run.step():
                    break
        return found

    # --- events -----------------------------------------------------------------------

    def scan(
        self,
        *kinds: type[Event],
        first: int = 0,
        want: Want | None = None,
    ) -> Iterable[ToldEvent]:
        """Return events up to now, in order, from a cycle on.

        What is not in the log any more is made again by replay.

        Args:
            kinds: the kinds of events; all if there are none.
            first: the first cycle.
            want: says which of them are wanted; all if it is not given.

        Raises:
            StateError: if some are gone and there is no way back.
        """
        if self.log.has(first):
            return self.log.scan(first, kinds, want)
        gathered: list[ToldEvent] = []

        def take(told: ToldEvent) -> None:
            wanted = told.cycle >= first and (not kinds or told.kind in kinds)
            if wanted and (want is None or want(told)):
                gathered.append(told)

        until, over = self.moment, self.over
        with self.at(max(first - 1, 0)):
            for told in self._log.opening:
                if told.serial < self.serial:
                    take(told)
            self._log.elsewhere = take
            while self.moment < until:
                self._replay(until)
            if over:
                self.run.step()
        return gathered

    def last(self, *kinds: type[Event], want: Want) -> ToldEvent | None:
        """Return the last event up to now of some kinds that is wanted, or None.

        Raises:
            StateError: as `scan`.
        """
        found = next(filter(want, self.log.backwards(*kinds)), None)
        if found is None and not self.log.has(0):
            found = next(reversed([*self.scan(*kinds, want=want)]), None)
        return found

    def seek(self, *kinds: type[Event], want: Want) -> ToldEvent | None:
        """Go to the cycle of the next event of some kinds that is wanted.

        Breakpoints do not matter meanwhile. Where there is none it stands where it
        stood, or at the end of the run if there is no way back.

        Returns:
            The event, or None.
        """
        if isinstance(self._run, Playback):
            return self._run.seek(kinds, want)
        met: ToldEvent | None = None
        start, over, heard = self.cycle, self.over, self.serial

        def look() -> str | None:
            nonlocal met, heard
            told, heard = self.log.since(heard), self.serial
            met = next((o for o in told if o.kind in kinds and want(o)), None)
            return None if met is None else ""

        self.go(look, heed=False)
        if met is None:
            look()  # at what the run has ended with
        if not (met or over or self.no_way_back):
            self.goto(start)
        return met

    def follow(self, hear: Hear) -> None:
        """Call `hear` with each event that the run emits from now on, but for acts."""
        self._log.follower = hear

    # --- acting -------------------------------------------------------------------

    def act(self, act: Act) -> None:
        """Do something to the run, now; in the past it begins a new branch.

        A run that is over because there was no more to do goes on with it.

        Raises:
            Error: if it cannot be done; then nothing has changed.
        """
        goes_on = self.reason in _NO_MORE_TO_DO and not self.no_way_back
        run = self.run
        if goes_on:
            self.goto(self.cycle)
            run = self.run
        branch, moment, log = self.branch, self.moment, self._log
        follower, log.follower = log.follower, None
        try:
            run = act.do(run) or run
        except Error:
            if goes_on:
                self.step()  # to its end again
            raise
        finally:
            log.follower = follower
        if moment < branch.end or moment.acts < len(branch.acts):
            branch = self.branch_off()
        branch.acts.append((moment.cycle, act))
        branch.over = False
        self._run = run
        self._done += 1
        branch.end = self.moment

    def branch_off(self, name: str = "") -> Branch:
        """Begin a new branch here, and return it; the one before stays as it is.

        Raises:
            ArgumentError: for a name that is taken.
        """
        self.check_is_run()
        if any(name == branch.name for branch in self.branches):
            raise ArgumentError(f"there is a branch `{name}` already")
        self.branch.left = self.moment
        name = name or f"branch-{len(self.branches)}"
        self.branch = self.branch.begun_at(self.moment, name)
        self.branches.append(self.branch)
        return self.branch

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
        if self._questions[0] is not self.run:
            self._questions = (self.run, {})
        ready = self._questions[1]
        if text not in ready:
            ready[text] = self.run.question(text)
        return ready[text]

    @property
    def library(self) -> CheckedLibrary:
        """The library that runs now."""
        return CheckedLibrary(self.run.library)

    def take_up(self, library: CheckedLibrary) -> TakeUp:
        """Go on with another text of the library, and return what was done.

        Raises:
            RefusedError: if the run cannot go on with it; then nothing has changed.
            StateError: if the run cannot be saved.
        """
        before, after = self.run.library.library, library.program.library
        act = TakeUp(library.program, changed(before, after))
        self.act(act)
        return act


def _nobody(told: ToldEvent) -> None:
    """Hear of an event, and do nothing."""
