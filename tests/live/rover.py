"""A driver whose machine is a clock: drives in threads, looks in asyncio."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from random import Random
from typing import Any, ClassVar

from rapc.live import Action, AsyncAction, Driver, SimulatedClock
from rapc.world import (
    Atom,
    Datum,
    Fact,
    HandlerMemory,
    Handlers,
    Kit,
    Offer,
    Reply,
    Time,
)

LIBRARY = """
(declare-primitive drive (?room) (okay blocked timeout)
  :atomic false :uses (wheels) :on (okay (robot-at ?room)) :on (blocked) :on (timeout))
(declare-primitive look (?room) (okay) :atomic false :on (okay (seen ?room)))
(declare-primitive beep (?n) (okay) :on (okay (beeped ?n)))
(declare-sensor-datum alarm (?n) :on ((alarm ?n)))
(declare-sensor-datum battery (?percent) :on ((battery ?percent)))
(declare-sensor-datum stall (?seconds))
(declare-memory-property robot-at (?room) unknown)
(declare-memory-property alarm (?n) 0)
(declare-memory-property beeped (?n) 0)
(declare-memory-property battery (?percent) unknown)
(declare-memory-proposition seen (?room))

(define-rap (visit ?first ?second)
  (method
    (task-net
      (t1 (go-to ?first) (for t2))
      (t2 (go-to ?second)))))
(define-rap (go-to ?room)
  (succeed (robot-at ?room))
  (method (primitive (drive ?room))))
(define-rap (see ?room)
  (succeed (seen ?room))
  (method (primitive (look ?room))))
(define-rap (glance ?room)
  (duration 1)
  (succeed (seen ?room))
  (method (primitive (look ?room))))
"""


def stall(memory: HandlerMemory, datum: Fact) -> None:
    """Block the thread of the interpreter."""
    time.sleep(float(datum[1]))  # type: ignore[arg-type]


class Rover(Driver):
    """A rover; `log` has the acts of its body with their times."""

    name = "rover"
    kit = Kit(
        Offer(
            {
                "drive": (1, ("okay", "blocked", "timeout")),
                "look": (1, ("okay",)),
                "beep": (1, ("okay",)),
            },
            data={"alarm": 1, "battery": 1, "stall": 1},
            not_atomic=("drive", "look"),
        ),
        Handlers(data={"stall": stall}),
    )
    timeouts: ClassVar[Mapping[str, float]] = {"drive": 10}

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.log: list[tuple[Any, ...]] = []
        self.real_times: list[float] = []
        #: The seconds of a drive, by room.
        self.seconds: dict[Atom, float] = {}
        self.errors: dict[Atom, list[BaseException]] = {}

    def note(self, *what: Atom) -> None:
        self.log.append((self.clock.now(), *what))
        self.real_times.append(time.monotonic())

    def do_drive(self, action: Action, room: Atom) -> str:
        self.note("drive", room)
        if self.errors.get(room):
            raise self.errors[room].pop(0)
        try:
            action.sleep(self.seconds.get(room, 1.5))
        finally:
            self.note("stop", room)
        return "blocked" if room == "cellar" else "okay"

    async def do_look(self, action: AsyncAction, room: Atom) -> Reply:
        self.note("look", room)
        try:
            await action.sleep(2)
            return Reply("okay")
        finally:
            self.note("looked", room)

    def do_beep(self, n: Atom) -> None:
        self.note("beep", n)

    def stop_body(self) -> None:
        self.note("halt")


class SimulatedRover(Rover):
    """The same driver in simulated time."""

    def __init__(self, rng: Random | None = None, options: Any = None) -> None:
        super().__init__(rng, options or {}, SimulatedClock())


class Polled(SimulatedRover):
    """A rover with a job that reads the battery."""

    def connect(self) -> None:
        self.start(self.poll, 100)

    def poll(self, action: Action, percent: int) -> None:
        while True:
            self.send(Datum(("battery", percent)))
            percent -= 1
            action.sleep(0.5)


class Printing(SimulatedRover):
    """A rover that prints what its body does."""

    def note(self, *what: Atom) -> None:
        print(*what)


class StoppedInRequest(Printing):
    """A rover that gets SIGTERM before the interpreter knows of its first drive."""

    def perform(self, ticket: int, request: Fact) -> Any:
        super().perform(ticket, request)
        os.kill(os.getpid(), signal.SIGTERM)


class StoppedInWait(Printing):
    """A rover that gets SIGTERM during its first drive."""

    def advance(self, to: Time) -> None:
        os.kill(os.getpid(), signal.SIGTERM)
