"""History of a run: any moment of the run, with the acts of the user.

A history is the specification of a run, the acts of the user, and the answers that
cannot be made again: those of solvers, and of a world that cannot be saved. The run is
a function of these.

A moment is the end of a cycle, or an arrival between two cycles. To reach a moment, a
history restores the nearest saved state before the moment and replays from there. The
replay repeats each act of the branch at its moment, and adds no event that the branch
has already. An act in the past begins a branch with the acts, saved states and events
up to there; the old branch is kept.

A recorded run without library or world is also a history: the user can step and search,
but not query or change the run. Not here: questions (`rapc.debug.questions`), output
(`rapc.repl`), and a run in a file (`rapc.debug.bug`).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import msgspec

from rapc import events
from rapc.base.values import readable
from rapc.compiler.program import Program
from rapc.debug.acts import Act
from rapc.debug.discrepancies import Discrepancies
from rapc.debug.log import EventLog, Events, Hear, ToldEvent, Want
from rapc.debug.recording import Playback
from rapc.debug.reload import TakeUp, changed
from rapc.errors import ArgumentError, Error, PortError, StateError
from rapc.events import Event, RunEnded, TaskSelected
from rapc.host import CheckedLibrary
from rapc.runtime.answers import (
    Answers,
    Goal,
    RecordedWorld,
    UnknownAnswerError,
)
from rapc.runtime.host_query import HostQuery
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.spec import RunSpec
from rapc.world import Time, Truth, World

_NO_MORE_TO_DO = ("done", "stuck")
"""The end reasons after which an act lets the run go on."""

_FEW = 16
"""The least number of cycles between saves; a replay of fewer is faster."""

_EVERY = 64
"""The number of cycles between two recent saved states."""

_RUNNING = 512
"""The number of cycles after which a running history saves its state."""

_SHARE = 12
"""The divisor for older saved states: a gap is at most age / `_SHARE`."""

_ONLY_TO_LOOK_AT = (
    "not available in a read-only recording: its library or world is missing"
)


_QUIET = (
    events.TaskCreated,
    events.TaskSelected,
    events.MethodChosen,
    events.MethodEnded,
    events.TaskBlocked,
    events.TaskWoken,
    events.TaskSucceeded,
    events.TaskFailed,
    events.TaskRemoved,
)
"""The events that change neither beliefs nor the world, if no time passes."""


class Stop(msgspec.Struct, frozen=True):
    """The reason for a stop of the run."""

    #: `asked` (the request of the user), `over`, `break`, `pause` or `broken`.
    kind: str
    #: The details as text; may be empty.
    said: str = ""


class Moment(NamedTuple):
    """A moment of a run; moments are ordered like the run.

    The run stands at the end of a cycle, or between two cycles, after an arrival: time
    has passed, and data, signals or timers have arrived.
    """

    #: The last cycle.
    cycle: int
    #: The number of arrivals since the end of that cycle.
    arrivals: int = 0
    #: The number of acts of the branch up to the moment.
    acts: int = 0


_BEGINNING = Moment(0)


class Done(NamedTuple):
    """An act of the user, with its place in the run."""

    #: The last cycle before the act, and the number of arrivals after that cycle.
    cycle: int
    arrivals: int
    time: Time
    act: Act


class Save(NamedTuple):
    """A saved state of a run, with its program, settings, world and time."""

    state: bytes
    program: Program
    settings: Settings
    world: World
    time: Time


Solutions = dict[tuple[int, Goal], Any]
"""Methods from solvers, by the cycle and the goal."""


@dataclass
class Branch:
    """A branch of a run: its acts, saved states, events and furthest moment."""

    name: str
    #: The parent branch and its cycle, as text; empty for the first branch.
    begun: str = ""
    #: The acts, in order.
    acts: list[Done] = field(default_factory=list)
    #: The methods from solvers; see `Answers.solutions`.
    solutions: Solutions = field(default_factory=dict)
    #: The saved states, ordered by moment.
    saves: dict[Moment, Save] = field(default_factory=dict)
    #: The latest events, up to the furthest moment.
    events: Events = field(default_factory=Events)
    #: The wrong beliefs; empty if the world is not a `Truth`.
    discrepancies: Discrepancies = field(default_factory=Discrepancies)
    #: The furthest moment reached.
    end: Moment = _BEGINNING
    #: Whether the run ended at the furthest moment.
    over: bool = False
    #: The moment at which the user left the branch.
    left: Moment = _BEGINNING

    def moment_after(self, cycle: int) -> Moment:
        """Return the moment at the end of a cycle, after the acts there."""
        return Moment(cycle, 0, bisect_right(self.acts, (cycle, 0), key=_place))

    def moment_before(self, cycle: int) -> Moment:
        """Return the moment of the last act before a cycle, or its preceding end."""
        acts = bisect_left(self.acts, (cycle, 0), key=_place)
        last = self.acts[acts - 1] if acts else None
        arrivals = last.arrivals if last and last.cycle == cycle - 1 else 0
        return Moment(cycle - 1, arrivals, acts)

    def begun_at(self, moment: Moment, serial: int, name: str) -> Branch:
        """Return a new branch that begins at a moment of this branch.

        Args:
            moment: the moment.
            serial: the serial number of the next event at the moment.
            name: the name of the new branch.
        """
        begun = f"{self.name} at cycle {moment.cycle}"
        saves = {at: save for at, save in self.saves.items() if at <= moment}
        acts = self.acts[: moment.acts]
        found = _up_to(self.solutions, moment.cycle)
        events = self.events.up_to(serial)
        logs = found, saves, events, self.discrepancies.up_to(serial)
        return Branch(name, begun, acts, *logs, moment, left=moment)

    def keep(self, moment: Moment, save: Save) -> None:
        """Keep a new saved state and drop old states, the older the more.

        A state is dropped if the gap without that state stays small for its age. A run
        of any length keeps a few dozen states, and every replay stays short.
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


def _place(done: Done) -> tuple[int, int]:
    return done.cycle, done.arrivals


class History:
    """A run that the user can step, stop, change and move to any moment.

    Args:
        run: a run that has begun, with `log` among its listeners; or a playback of a
            recording. If the log has heard nothing, the history begins now.
        log: the log of the run; optional for a playback.
        acts: the acts to repeat on the way, in order: those of a run of the same
            specification that somebody has reported.
    """

    def __init__(
        self,
        run: Interpreter | Playback,
        log: EventLog | None = None,
        acts: Iterable[Done] = (),
    ) -> None:
        self._run = run
        #: The specification of the run.
        self.spec: RunSpec = run.spec
        #: The answers of the world, if it cannot be saved, and of solvers.
        self.answers = Answers() if isinstance(run, Playback) else run.keep_answers()
        log = EventLog() if log is None else log
        self.log: EventLog | Playback = log
        #: The reason why the run cannot go back; empty if the run can.
        self.no_way_back = ""
        #: Functions called after each cycle; a returned text stops the run.
        self.checks: dict[str, Callable[[], str | None]] = {}
        #: Functions called after each stop; each returns a line to show; may be empty.
        self.notes: list[Callable[[], str]] = []
        #: The library at the start of the run; an act can replace the library.
        self.first_library: Program | None = None
        #: The first moment, which is later than cycle 0 for a run from a saved state.
        self.beginning = _BEGINNING
        if isinstance(run, Interpreter) and run.serial > log.events.end == 0:
            self.beginning = Moment(run.cycle)
            log.events.opening += map(ToldEvent.of, run.past())
            log.serial = run.serial
        self.branch = Branch("main", acts=list(acts), events=log.events)
        self.branches = [self.branch]
        self.answers.solutions = self.branch.solutions
        #: The serial number of the first event that the checks have not seen.
        self.fresh = self.serial
        self._paused = False
        #: The arrivals since the last cycle, the acts so far, and the cycle of the
        #: last saved state.
        self._arrivals = self._done = self._saved = 0
        #: The time of the last comparison of beliefs with the truth; None if the run
        #: has since been changed or restored.
        self._compared: Time | None = None
        self._questions: tuple[object, dict[str, HostQuery]] = (run, {})
        if isinstance(run, Playback):
            self.log = run
            self.branch.end, self.branch.over = Moment(run.last_cycle), True
        else:
            self.first_library = run.library
            if self.knows_truth:
                run.listen(self._compare, TaskSelected, RunEnded)
        self._save()

    @classmethod
    def open(cls, library: CheckedLibrary, world: Any, **more: Any) -> History:
        """Begin a run and return its history.

        Args:
            library: what `rapc.load` returned.
            world: see `CheckedLibrary.start`.
            more: further arguments of `CheckedLibrary.start`: `tasks`, `agenda`, ...

        Raises:
            Error: as `CheckedLibrary.start`.
        """
        log = EventLog()
        listeners = [log, *more.pop("listeners", ())]
        return cls(library.start(world, listeners=listeners, **more), log)

    # --- the present moment -------------------------------------------------------

    @property
    def run(self) -> Interpreter:
        """The run; a change of settings or library replaces the run.

        Raises:
            StateError: for a playback.
        """
        if isinstance(self._run, Playback):
            raise StateError(_ONLY_TO_LOOK_AT)
        return self._run

    @property
    def is_run(self) -> bool:
        """Whether the user can query and change the run: it is not a playback."""
        return not isinstance(self._run, Playback)

    @property
    def knows_truth(self) -> bool:
        """Whether the world tells the truth at all moments, also when made again."""
        world = None if isinstance(self._run, Playback) else self._run.port
        return isinstance(world, Truth) and not isinstance(world.behind, RecordedWorld)

    def check_knows_truth(self) -> None:
        """Raise ArgumentError if not `knows_truth`, StateError for a playback."""
        port = self.run.port
        if not isinstance(port, Truth):
            raise ArgumentError(f"the world `{port.name}` has no method `truth`")
        if not self.knows_truth:
            said = "its truth is known only at the present"
            raise ArgumentError(f"the world `{port.name}` cannot be saved: {said}")

    def check_is_run(self) -> None:
        """Raise StateError for a playback."""
        if not self.is_run:
            raise StateError(_ONLY_TO_LOOK_AT)

    @property
    def cycle(self) -> int:
        """The number of the last cycle."""
        return self._run.cycle

    @property
    def serial(self) -> int:
        """The serial number of the next event."""
        return self._run.serial

    @property
    def now(self) -> Time:
        """The time of the clock."""
        return self._run.now

    @property
    def reason(self) -> str:
        """The end reason at the present moment; empty before the end."""
        return self._run.reason or ""

    @property
    def over(self) -> bool:
        """Whether the run is over at the present moment."""
        return self.reason != ""

    @property
    def moment(self) -> Moment:
        """The present moment."""
        return Moment(self.cycle, self._arrivals, self._done)

    @property
    def between(self) -> bool:
        """Whether the run stands between two cycles, after an arrival."""
        return self._arrivals > 0

    @property
    def seen(self) -> int:
        """The furthest cycle reached in the branch."""
        return self.branch.end.cycle

    @property
    def seen_over(self) -> bool:
        """Whether the run ended after the furthest cycle."""
        return self.branch.over

    @property
    def selected(self) -> int | None:
        """The number of the task of the last cycle."""
        told = next(self.log.backwards(TaskSelected), None)
        return None if told is None else told.keys["task"]

    def stand(self) -> str:
        """Return the present moment as a line of text."""
        words = f"cycle {self.cycle}, time {readable(self.now)}"
        words = f"after {words}" if self.between and not self.over else words
        if self.over:
            end = next(self.log.backwards(RunEnded), None)
            because = None if end is None else end.keys["because"]
            reason = f"{self.reason}: {because}" if because else self.reason
            words += f", run ended ({reason})"
        return words if self.branch.name == "main" else f"{words}, {self.branch.name}"

    # --- forwards -----------------------------------------------------------------

    def step(self, cycles: int = 1) -> Stop:
        """Run some cycles; stop early at a breakpoint, a pause or the end."""
        if cycles <= 0:
            return Stop("asked")
        last = self.cycle + cycles
        return self.go(lambda: "" if self.cycle >= last else None)

    def go(
        self, until: Callable[[], str | None] | None = None, *, heed: bool = True
    ) -> Stop:
        """Run until a breakpoint, `until`, a pause or the end stops the run.

        Args:
            until: called after each cycle; returns a text to stop, None to go on.
            heed: whether breakpoints stop the run.
        """
        stop = None
        while stop is None:
            stop = self._step(until, heed)
        if self.cycle >= self._saved + _FEW and not self.over:
            self._save()
        return stop

    def wait(self) -> Stop:
        """Run to the next arrival, or else to the end of the next cycle.

        Data, signals and ends of requests arrive, and timers become due.
        """
        return self._step(lambda: "", heed=True, arrivals=True) or Stop("asked")

    def _step(
        self,
        until: Callable[[], str | None] | None,
        heed: bool,
        arrivals: bool = False,
    ) -> Stop | None:
        """Run a cycle, or to an arrival; return the reason to stop, or None."""
        stop = self._run_cycle(arrivals and self.is_run)
        if stop is not None:
            return stop
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

    def _run_cycle(self, arrivals: bool) -> Stop | None:
        """Run a cycle, or to an arrival; return a stop if that is impossible."""
        before = self.moment
        try:
            if self.over or not (self._wait() if arrivals else self._cycle()):
                return Stop("over", self.reason)
        except UnknownAnswerError as error:
            self._put_back(before)
            return Stop("broken", error.message)
        except PortError as error:
            return Stop("broken", error.message)
        return None

    def _cycle(self) -> bool:
        """Run to the end of the next cycle, and repeat the acts of the branch.

        Returns:
            Whether a cycle was run; False if the run is over.
        """
        branch, end = self.branch, self.branch.moment_after(self.cycle + 1)
        while self.moment < end:
            if not self._advance(end):
                branch.over = True
                return False
        branch.end = max(branch.end, end)
        if self.cycle >= self._saved + _RUNNING:
            self._save()
        return True

    def _compare(self, event: Event) -> None:
        """Compare the beliefs with the truth when a branch reaches an event first."""
        found = self.branch.discrepancies
        if self._log.elsewhere is not None or event.n < found.compared:
            return
        since = self._log.since(found.compared)
        if event.time == self._compared and all(one.kind in _QUIET for one in since):
            found.compared = event.n + 1
        else:
            found.compare(event, self.run.wrong_beliefs())
            self._compared = event.time

    def _wait(self) -> bool:
        """Run to the next arrival or end of a cycle; return False if the run is over.

        The acts of the branch there are performed.
        """
        branch = self.branch
        if not self._advance(None):
            branch.over = True
            return False
        while self._done < len(branch.acts) and (
            _place(branch.acts[self._done]) <= (self.cycle, self._arrivals)
        ):
            self._advance(None)
        branch.end = max(branch.end, self.moment)
        return True

    def _advance(self, to: Moment | None) -> bool:
        """Perform the next act, or run to the next arrival or end of a cycle.

        Args:
            to: the moment to reach: the run stops only at arrivals that precede an act
                or the moment. None: the run stops at the next arrival.

        Returns:
            Whether the run went on; False if it is over.
        """
        acts, cycle = self.branch.acts, self.cycle
        last = len(acts) if to is None else to.acts
        act = acts[self._done] if self._done < last else None
        if act is not None and _place(act) <= (cycle, self._arrivals):
            self._run = act.act.do(self.run) or self.run
            self._done += 1
            self._compared = None
            return True
        is_near = act is not None and act.cycle == cycle
        if to is None or cycle == to.cycle or is_near:
            if self.run.come_to_arrival():
                self._arrivals += 1
                return True
            if to is not None:
                return False
        if not self._run.step():
            return False
        self._arrivals = 0
        return True

    def _save(self) -> None:
        self._saved = self.cycle
        run = self._run
        if self.no_way_back or isinstance(run, Playback):
            return
        try:
            world = run.port.behind
            save = Save(run.save(), run.library, run.settings, world, run.now)
            self.branch.keep(self.moment, save)
        except (StateError, PortError) as error:
            self.no_way_back = error.message

    def pause(self, wanted: bool = True) -> None:
        """Stop after the current or next cycle, or withdraw the stop.

        A signal handler may call this method.
        """
        self._paused = wanted

    @property
    def paused(self) -> bool:
        """Whether the run is to stop after the current or next cycle."""
        return self._paused

    # --- other moments --------------------------------------------------------------

    def goto(self, cycle: int | Moment, *, heed: bool = False) -> Stop:
        """Go to the end of a cycle, backwards or forwards.

        Args:
            cycle: the number of the cycle; or a moment of the branch, as `moment`
                returned it.
            heed: whether breakpoints stop the run on the way forwards.

        Raises:
            StateError: if the run cannot go back.
        """
        if isinstance(self._run, Playback):
            self._run.goto(cycle.cycle if isinstance(cycle, Moment) else max(cycle, 0))
            return Stop("over", self.reason) if self.over else Stop("asked")
        if isinstance(cycle, Moment):
            self._put_back(cycle)
            return Stop("asked")
        cycle = max(cycle, 0)
        moment = self.branch.moment_after(cycle)
        at = None if heed else self._nearest(moment)
        if at is not None and at > self.moment:
            self._restore(at)
        if cycle > self.cycle:
            return self.go(lambda: "" if self.cycle >= cycle else None, heed=heed)
        if moment != self.moment or self.over:
            self._put_back(moment)
        return Stop("asked")

    def reach(self, moment: Moment) -> Stop:
        """Go forward to a moment for the first time, and perform the acts on the way.

        The run may end before the moment, or break off as it did at first. Breakpoints
        do not stop the run.

        Raises:
            Error: if an act is impossible.
        """
        stop = None
        while stop is None and self.moment < moment:
            stop = self._step(None, heed=False, arrivals=self.cycle == moment.cycle)
        return stop or Stop("asked")

    def goto_time(self, time: Time, *, heed: bool = False) -> Stop:
        """Go to the last moment at or before a time, backwards or forwards.

        The moment depends on the branch and the time alone. The run may then stand
        between two cycles.

        Args:
            time: the time.
            heed: whether breakpoints stop the run on the way forwards.

        Raises:
            StateError: if the run cannot go back.
        """
        if isinstance(self._run, Playback):
            return self.goto(self._run.cycle_by(time))
        stop = Stop("asked")
        if time >= self.now:
            at = self._nearest_by(time)
            if not heed and at > self.moment:
                self._restore(at)
            stop = self.go(lambda: "" if self.now > time else None, heed=heed)
            if self.no_way_back or stop.kind not in ("asked", "over"):
                return stop
        if self.now <= time:
            return stop
        at = self._nearest_by(time)
        if self._log.has(at.cycle):
            later = self._log.scan(at.cycle, want=lambda told: told.time > time)
            cycle = later[0].cycle - 1 if later else 0
            at = max(at, self.branch.moment_after(cycle))
        self._put_back(at)
        found = self.moment
        while self.now <= time and self._run_cycle(arrivals=True) is None:
            found = self.moment if self.now <= time else found
        if self.over or self.moment != found:
            self._put_back(found)
        return Stop("asked")

    def _nearest_by(self, time: Time) -> Moment:
        """Return the moment of the last saved state up to a time."""
        saves = self.branch.saves.items()
        found = (at for at, save in saves if save.time <= time)
        return max(found, default=self.beginning)

    def _look_back(self) -> None:
        if self.no_way_back:
            raise StateError(f"cannot go back: {self.no_way_back}")

    def _put_back(self, moment: Moment) -> None:
        """Restore the run at a moment of the branch."""
        self._look_back()
        at = self._nearest(moment)
        if at is None:
            raise StateError("cannot go back: no saved state before that moment")
        self._restore(at)
        self._replay(moment)
        if self._log.elsewhere is None:
            self.fresh = self.serial
            if self.cycle >= at.cycle + _EVERY:
                self._save()

    def _nearest(self, moment: Moment) -> Moment | None:
        """Return the moment of the last saved state up to a moment of the branch."""
        return max((one for one in self.branch.saves if one <= moment), default=None)

    def _restore(self, at: Moment) -> None:
        """Restore the saved state of a moment."""
        run, save = self.run, self.branch.saves[at]
        if run.library is not save.program or run.settings != save.settings:
            run = run.remade(save.program, save.settings)
        run.port.enclose(save.world)
        run.restore(save.state)
        self._run, self._saved = run, at.cycle
        self._arrivals, self._done = at.arrivals, at.acts
        self._compared = None
        if self._log.elsewhere is None:
            self._log.serial = self.fresh = self.serial

    @property
    def _log(self) -> EventLog:
        """The log of a run that is not a playback."""
        assert isinstance(self.log, EventLog)
        return self.log

    def _replay(self, moment: Moment) -> None:
        """Go forward to a moment of the branch that the run has reached before."""
        while self.moment < moment:
            if not self._advance(moment):
                raise StateError(
                    f"the replay has ended at cycle {self.cycle}, before "
                    f"{moment.cycle}: the world does not go on from its saved states "
                    "as it did"
                )

    @contextmanager
    def at(self, cycle: int | None = None) -> Iterator[Interpreter]:
        """Move the run to the end of a past cycle within a `with` statement.

        The end of the `with` statement undoes every change to the run.

        Args:
            cycle: the cycle; default: the present moment.

        Yields:
            the run at that cycle.

        Raises:
            StateError: if the run cannot go back.
        """
        self._look_back()
        with self._aside():
            if cycle is not None:
                self._put_back(self.branch.moment_after(cycle))
            yield self.run

    @contextmanager
    def at_choice(self, cycle: int) -> Iterator[Interpreter]:
        """Move the run before the choice of a past cycle, as `at` does.

        The acts of the user before the choice are performed, and all that arrives
        before the choice is taken in.
        """
        self._look_back()
        with self._aside():
            self._put_back(self.branch.moment_before(cycle))
            self.run.come_to_choice()
            yield self.run

    @contextmanager
    def _aside(self) -> Iterator[None]:
        """Undo every change to the run at the end of the `with` statement."""
        run, here, saved = self.run, self.run.save(), self._saved
        place, world = (self._arrivals, self._done), run.port.behind
        log, before = self._log, self._log.elsewhere
        log.elsewhere = _nobody
        closed, self.answers.closed = self.answers.closed, True
        try:
            yield
        finally:
            run.port.enclose(world)
            run.restore(here)
            self._run, self._saved = run, saved
            self._arrivals, self._done = place
            log.elsewhere = before
            self.answers.closed = closed
            self.answers.solutions = self.branch.solutions

    def repeat(self, cycle: int, hear: Hear) -> None:
        """Repeat a past cycle to the next choice; call `hear` with each event.

        The run is in the state of the event while `hear` is called.

        Raises:
            StateError: if the run cannot go back.
        """
        branch = self.branch
        self._look_back()
        with self._aside(), suppress(UnknownAnswerError):
            self._put_back(branch.moment_before(cycle) if cycle else self.beginning)
            if cycle:
                self.run.come_to_choice()
            self._log.elsewhere = hear
            self._replay(branch.moment_before(cycle + 1))
            self.run.come_to_choice()

    def ahead(self, acts: Iterable[Act], cycles: int) -> list[ToldEvent]:
        """Return the events of the next cycles after given acts, then undo all.

        In a world that cannot be saved, the events end at the first question whose
        answer is unknown.

        Raises:
            Error: if an act is impossible.
            StateError: if the run cannot go back.
        """
        found: list[ToldEvent] = []
        with self.at(), suppress(UnknownAnswerError):
            self.answers.solutions = _up_to(self.branch.solutions, self.cycle)
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
        """Return events up to the present moment, in order, from a cycle on.

        A replay reproduces events that the log has dropped.

        Args:
            kinds: the kinds of events; default: all.
            first: the first cycle.
            want: predicate that selects events; default: all.

        Raises:
            StateError: if the log has dropped events and the run cannot go back.
        """
        if self.log.has(first):
            return self.log.scan(first, kinds, want)
        gathered: list[ToldEvent] = []

        def take(told: ToldEvent) -> None:
            wanted = told.cycle >= first and (not kinds or told.kind in kinds)
            if wanted and (want is None or want(told)):
                gathered.append(told)

        until, over = self.moment, self.over
        with self.at(max(first - 1, self.beginning.cycle)):
            for told in self.branch.events.opening:
                if told.serial < self.serial:
                    take(told)
            self._log.elsewhere = take
            self._replay(until)
            if over:
                self.run.step()
        return gathered

    def told_by(self, name: str) -> list[ToldEvent]:
        """Return the events of a branch up to its furthest moment.

        Raises:
            ArgumentError: if no branch has that name.
            StateError: if the run cannot go back.
        """
        branch = next((one for one in self.branches if one.name == name), None)
        if branch is None:
            raise ArgumentError(f"unknown branch `{name}`")
        if branch.events.has(0):
            return list(branch.events.before(branch.events.end))
        gathered: list[ToldEvent] = []
        here = self.branch
        with self.at():
            try:
                self.branch, self.answers.solutions = branch, branch.solutions
                self._put_back(self.beginning)
                gathered += branch.events.opening
                self._log.elsewhere = gathered.append
                while self.moment < branch.end:
                    self._replay(branch.end)
                if branch.over:
                    self.run.step()
            finally:
                self.branch = here
        return gathered

    def last(self, *kinds: type[Event], want: Want) -> ToldEvent | None:
        """Return the last wanted event up to the present moment, or None.

        Raises:
            StateError: as `scan`.
        """
        found = next(filter(want, self.log.backwards(*kinds)), None)
        if found is None and not self.log.has(0):
            found = next(reversed([*self.scan(*kinds, want=want)]), None)
        return found

    def seek(self, *kinds: type[Event], want: Want) -> ToldEvent | None:
        """Go to the cycle of the next wanted event of the given kinds.

        Breakpoints do not stop the search. If no event is found, the run returns to
        its present moment. If the run cannot go back, it stays at its end.

        Returns:
            The event, or None.
        """
        if isinstance(self._run, Playback):
            return self._run.seek(kinds, want)
        met: ToldEvent | None = None
        start, over, heard = self.moment, self.over, self.serial

        def look() -> str | None:
            nonlocal met, heard
            told, heard = self.log.since(heard), self.serial
            met = next((o for o in told if o.kind in kinds and want(o)), None)
            return None if met is None else ""

        self.go(look, heed=False)
        if met is None:
            look()  # at the events of the end of the run
        if not (met or over or self.no_way_back):
            self.goto(start)
        return met

    def follow(self, hear: Hear) -> None:
        """Call `hear` with each further event of the run, except events of acts."""
        self._log.follower = hear

    # --- acting -------------------------------------------------------------------

    def act(self, act: Act) -> None:
        """Perform an act at the present moment; in the past, begin a new branch.

        A run that ended as `done` or `stuck` goes on after the act.

        Raises:
            Error: if the act is impossible; the run is then unchanged.
        """
        goes_on = self.reason in _NO_MORE_TO_DO and not self.no_way_back
        run = self.run
        if goes_on:
            self.goto(self.cycle)
            run = self.run
        branch, moment, log = self.branch, self.moment, self._log
        found: list[ToldEvent] = []
        log.elsewhere = found.append
        try:
            run = act.do(run) or run
        except Error as error:
            log.elsewhere = None
            if isinstance(error, UnknownAnswerError):
                self._put_back(moment)
            if goes_on:
                self.step()  # back to the end of the run
            raise
        finally:
            log.elsewhere = None
        if moment < branch.end or moment.acts < len(branch.acts):
            branch = self.branch_off()
        branch.acts.append(Done(moment.cycle, moment.arrivals, self.now, act))
        branch.over = False
        log.events = branch.events = branch.events.up_to(log.serial)
        branch.discrepancies = branch.discrepancies.up_to(log.serial)
        for told in found:
            branch.events.add(told)
        self._run, log.serial, self._compared = run, run.serial, None
        self._done += 1
        branch.end = self.moment

    def branch_off(self, name: str = "") -> Branch:
        """Begin a new branch at the present moment and return the branch.

        Raises:
            ArgumentError: if a branch has the name already.
        """
        self.check_is_run()
        if any(name == branch.name for branch in self.branches):
            raise ArgumentError(f"duplicate branch `{name}`")
        self.branch.left = self.moment
        name = name or f"branch-{len(self.branches)}"
        branch = self.branch.begun_at(self.moment, self._log.serial, name)
        self.branches.append(branch)
        self._take(branch)
        return branch

    def _take(self, branch: Branch) -> None:
        """Make a branch the present branch."""
        self.branch = branch
        self.answers.solutions = branch.solutions
        self._log.events = branch.events

    def switch(self, name: str) -> None:
        """Switch to a branch, at the moment at which the user left that branch.

        Raises:
            ArgumentError: if no branch has that name.
            StateError: if the run cannot go back.
        """
        self.check_is_run()
        self._look_back()
        for branch in self.branches:
            if branch.name == name:
                self.branch.left = self.moment
                self._take(branch)
                self._put_back(branch.left)
                return
        raise ArgumentError(f"unknown branch `{name}`")

    def question(self, text: str) -> HostQuery:
        """Return a query, compiled for the present library of the run.

        Raises:
            ValueError: for an invalid formula or an undeclared name.
        """
        if self._questions[0] is not self.run:
            self._questions = (self.run, {})
        ready = self._questions[1]
        if text not in ready:
            ready[text] = self.run.question(text)
        return ready[text]

    @property
    def library(self) -> CheckedLibrary:
        """The present library of the run."""
        return CheckedLibrary(self.run.library)

    def take_up(self, library: CheckedLibrary) -> TakeUp:
        """Reload the library with another text; return the act.

        Raises:
            RefusedError: if the run cannot go on; the run is then unchanged.
            StateError: if the run cannot be saved.
        """
        before, after = self.run.library.library, library.program.library
        act = TakeUp(library.program, changed(before, after))
        self.act(act)
        return act


def _up_to(solutions: Solutions, cycle: int) -> Solutions:
    """Return the methods that solvers found up to a cycle."""
    return {key: found for key, found in solutions.items() if key[0] <= cycle}


def _nobody(told: ToldEvent) -> None:
    """Ignore an event."""
