"""The clocks of drivers: the time of the computer, or simulated time.

A driver tells its clock when each action begins, ends, sleeps and is interrupted. The
time of the computer does not depend on that. Simulated time moves only while every
action sleeps, and then to the end of the first sleep. So one action runs at a time, and
a run is the same each time.
"""

from __future__ import annotations

import heapq
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from rapc.world import Time

_LONGEST = 10.0
"""The seconds that an action may run without a sleep in simulated time."""


class Clock(ABC):
    """The clock of a driver, in time units since the start of the run."""

    #: Whether the time is that of the computer.
    real: bool
    #: The time units of a second.
    scale: float

    @abstractmethod
    def start(self) -> None:
        """Start the clock at 0."""

    @abstractmethod
    def now(self) -> Time:
        """Return the time."""

    @abstractmethod
    def begun(self) -> None:
        """Note that an action begins to run."""

    @abstractmethod
    def ended(self) -> None:
        """Note that an action has ended."""

    @abstractmethod
    def settle(self) -> None:
        """Wait until every action sleeps, if the time is simulated."""

    @abstractmethod
    def interrupt(self, key: object) -> None:
        """End the sleep of an action, if it sleeps in simulated time."""

    @abstractmethod
    def shorten(self, key: object) -> None:
        """End the sleep of an action when all others sleep, in simulated time."""

    @abstractmethod
    def wait(
        self,
        changed: threading.Condition,
        until: Time,
        ready: Callable[[], Any],
        beat: Callable[[], Any],
        period: float,
    ) -> None:
        """Wait until a time, or until `ready()`.

        Args:
            changed: notified when `ready()` may have changed.
            until: the time.
            ready: whether the wait is over; called with `changed` held.
            beat: called during the wait.
            period: the seconds between two calls of `beat`.
        """


class WallClock(Clock):
    """The time of the computer.

    Args:
        scale: the time units of a second: 60 counts minutes of the run as seconds.
    """

    real = True

    def __init__(self, scale: float = 1) -> None:
        if not scale > 0:
            raise ValueError(f"`scale` of a WallClock is positive, not {scale}")
        self.scale = scale
        self._started: float | None = None

    def start(self) -> None:
        """Start the clock at 0."""
        self._started = time.monotonic()

    def now(self) -> Time:
        """Return the time, in thousandths."""
        if self._started is None:
            return 0
        return round((time.monotonic() - self._started) * self.scale, 3)

    def begun(self) -> None:
        """Do nothing: this time does not depend on actions."""

    def ended(self) -> None:
        """Do nothing."""

    def settle(self) -> None:
        """Do nothing."""

    def interrupt(self, key: object) -> None:
        """Do nothing: an action ends its sleep by itself."""

    def shorten(self, key: object) -> None:
        """Do nothing: an action ends its wait by itself."""

    def wait(
        self,
        changed: threading.Condition,
        until: Time,
        ready: Callable[[], Any],
        beat: Callable[[], Any],
        period: float,
    ) -> None:
        """Wait until a time, or until `ready()`."""
        with changed:
            while not ready() and (left := until - self.now()) > 0:
                changed.wait(min(left / self.scale, period))
                beat()


class SimulatedClock(Clock):
    """Simulated time, for tests: it moves only while all actions sleep."""

    real = False
    scale = 1

    def __init__(self) -> None:
        self._time: Time = 0
        self._changed = threading.Condition()
        #: The number of actions that run.
        self._running = 0
        self._sleeps = 0
        #: The sleeps with their ends, soonest first, and the present sleep of each key.
        self._coming: list[tuple[Time, int, object]] = []
        self._asleep: dict[object, tuple[int, Callable[[], Any]]] = {}

    def start(self) -> None:
        """Start the clock at 0."""

    def now(self) -> Time:
        """Return the time."""
        return self._time

    def begun(self) -> None:
        """Note that an action begins to run."""
        with self._changed:
            self._running += 1

    def ended(self) -> None:
        """Note that an action has ended."""
        with self._changed:
            self._running -= 1
            self._changed.notify_all()

    def settle(self) -> None:
        """Wait until every action sleeps. Raises RuntimeError after 10 s."""
        with self._changed:
            if not self._changed.wait_for(lambda: not self._running, _LONGEST):
                said = f"an action has run for {_LONGEST:g} s without `action.sleep`"
                raise RuntimeError(f"{said}, in simulated time")

    def sleep(self, key: object, seconds: float, wake: Callable[[], Any]) -> None:
        """Note that an action sleeps; call `wake` after some time."""
        with self._changed:
            self._sleeps += 1
            due = round(self._time + max(seconds, 0), 3)
            heapq.heappush(self._coming, (due, self._sleeps, key))
            self._asleep[key] = self._sleeps, wake
            self._running -= 1
            self._changed.notify_all()

    def interrupt(self, key: object) -> None:
        """End the sleep of an action, if it sleeps."""
        with self._changed:
            sleep = self._asleep.pop(key, None)
            if sleep is not None:
                self._running += 1
                sleep[1]()

    def shorten(self, key: object) -> None:
        """End the sleep of an action when all others sleep."""
        with self._changed:
            sleep = self._asleep.get(key)
            if sleep is not None:
                self._sleeps += 1
                heapq.heappush(self._coming, (self._time, self._sleeps, key))
                self._asleep[key] = self._sleeps, sleep[1]

    def wait(
        self,
        changed: threading.Condition,
        until: Time,
        ready: Callable[[], Any],
        beat: Callable[[], Any],
        period: float,
    ) -> None:
        """Move the time to `until`, or to the first time that is `ready()`."""
        while True:
            self.settle()
            with changed:
                if ready():
                    return
            with self._changed:
                due, number, key = self._coming[0] if self._coming else (until, 0, None)
                if not number or due > until:
                    self._time = max(self._time, until)
                    return
                heapq.heappop(self._coming)
                current = self._asleep.get(key)
                if current is not None and current[0] == number:
                    self._time = max(self._time, due)
                    self.interrupt(key)
