"""What is stepped: a run, or a recorded one that is only looked at, forth and back.

How a cycle is gone forth, and how the way back is found, is for those who inherit.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from typing import Any

import msgspec

from rapc.base.values import readable
from rapc.debug.log import EventLog, ToldEvent
from rapc.errors import PortError
from rapc.events import TaskSelected
from rapc.world import Time


class Stop(msgspec.Struct, frozen=True):
    """Why a session has stopped."""

    #: `asked` for what was asked for, `over`, `break`, `pause` or `broken`.
    kind: str
    #: What there is to say of it, in words.
    said: str = ""


class Stepped(ABC):
    """Something that has cycles and events, and stands at the end of one of them.

    Args:
        log: has the events up to there.
    """

    def __init__(self, log: EventLog) -> None:
        self.log = log
        #: Why there is no way back; empty if there is one.
        self.no_way_back = ""
        #: Asked after each cycle: text to stop with, or nothing.
        self.checks: dict[str, Callable[[], str | None]] = {}
        #: Asked after each stop: a line to be told, or nothing.
        self.notes: list[Callable[[], str]] = []
        self._paused = False

    # --- where it stands ----------------------------------------------------------

    @property
    @abstractmethod
    def cycle(self) -> int:
        """The number of the cycle that was run last."""

    @property
    @abstractmethod
    def now(self) -> Time:
        """The time of the clock."""

    @property
    @abstractmethod
    def reason(self) -> str:
        """The reason why the run is over, here; empty while it is not."""

    @property
    @abstractmethod
    def serial(self) -> int:
        """The serial number that the next event will get."""

    @property
    @abstractmethod
    def seen(self) -> int:
        """The furthest cycle that was seen."""

    @property
    @abstractmethod
    def seen_over(self) -> bool:
        """Whether the run was seen to be over after that cycle."""

    @property
    def over(self) -> bool:
        """Whether the run is over, here."""
        return self.reason != ""

    @property
    def selected(self) -> int | None:
        """The number of the task whose cycle was run last."""
        told = self.log.last(TaskSelected)
        return None if told is None else told.keys["task"]

    def stand(self) -> str:
        """Return where it stands, in a line."""
        words = f"cycle {self.cycle}, time {readable(self.now)}"
        return f"{words}, run over ({self.reason})" if self.over else words

    @abstractmethod
    def scan(
        self,
        *kinds: type[Any],
        first: int = 0,
        want: Callable[[ToldEvent], bool] | None = None,
    ) -> Iterable[ToldEvent]:
        """Return events up to now, in order, from a cycle on.

        Args:
            kinds: the kinds of events; all if there are none.
            first: the first cycle.
            want: says which of them are wanted; all if it is not given.

        Raises:
            StateError: if some are gone and there is no way back.
        """

    def last(
        self, *kinds: type[Any], want: Callable[[ToldEvent], bool]
    ) -> ToldEvent | None:
        """Return the last event up to now of some kinds that is wanted, or None.

        Raises:
            StateError: as `scan`.
        """
        kept = (told for told in self.log.backwards() if told.kind in kinds)
        found = next((told for told in kept if want(told)), None)
        return found or next(reversed([*self.scan(*kinds, want=want)]), None)

    def seek(
        self, *kinds: type[Any], want: Callable[[ToldEvent], bool]
    ) -> ToldEvent | None:
        """Go to the cycle of the next event of some kinds that is wanted.

        Breakpoints do not matter meanwhile. Where there is none it stands where it
        stood, or at the end of the run if there is no way back.

        Returns:
            The event, or None.
        """
        met: list[ToldEvent] = []

        def watch(told: ToldEvent) -> None:
            if not met and told.kind in kinds and want(told):
                met.append(told)

        start, over = self.cycle, self.over
        before, self.log.watcher = self.log.watcher, watch
        try:
            self.go(lambda: "" if met else None, heed=False)
        finally:
            self.log.watcher = before
        if not (met or over or self.no_way_back):
            self.goto(start)
        return met[0] if met else None

    # --- what inherits ------------------------------------------------------------

    @abstractmethod
    def _cycle(self) -> bool:
        """Go one cycle forth; return False if the run is over instead."""

    @abstractmethod
    def _go_back(self, cycle: int) -> None:
        """Stand at the end of an earlier cycle. Raises StateError if it cannot."""

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
        """Go on until something stops it.

        Args:
            until: asked after each cycle; returns what to stop with, None to go on.
            heed: whether breakpoints stop it.
        """
        while True:
            if self.over:
                return Stop("over", self.reason)
            try:
                went = self._cycle()
            except PortError as error:
                return Stop("broken", error.message)
            if not went:
                return Stop("over", self.reason)
            for check in self.checks.values() if heed else ():
                if (hit := check()) is not None:
                    return Stop("break", hit)
            if until is not None and (said := until()) is not None:
                return Stop("asked", said)
            if self._paused:
                self._paused = False
                return Stop("pause")

    def pause(self, wanted: bool = True) -> None:
        """Stop after the cycle under way, or the first one if none is; or do not.

        May be called by a signal handler.
        """
        self._paused = wanted

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
            self._go_back(cycle)
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
            later = self.scan(want=lambda told: told.time > time)
            found = next(iter(later), None)
            stop = self.goto(self.cycle if found is None else found.cycle)
        else:
            stop = self._as_far(lambda: "" if self.now > time else None, heed)
            if self.no_way_back or stop.kind not in ("asked", "over"):
                return stop
            if self.over and self.now > time:  # the clock ran on as the run ended
                stop = self.goto(self.cycle)
        return self.goto(self.cycle - 1) if self.now > time else stop

    def _as_far(self, until: Callable[[], str | None], heed: bool) -> Stop:
        """Run as far as is asked; without `heed` nobody watches meanwhile."""
        if heed:
            return self.go(until)
        watcher, self.log.watcher = self.log.watcher, None
        try:
            return self.go(until, heed=False)
        finally:
            self.log.watcher = watcher
