"""One body, five tasks: a porter charges, answers alarms and carries three boxes.

Its world tells what was true: whether the porter was driven away while it had work to
do at a place, and what came of that.
"""

from __future__ import annotations

import random
from collections.abc import Sequence

from rapc import events
from rapc.base.values import Atom, Fact
from rapc.compiler.program import Program
from rapc.library.loader import load_text
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.world import (
    OKAY,
    Datum,
    Finished,
    HandlerMemory,
    Handlers,
    Kit,
    Message,
    Offer,
    Reply,
    Time,
    World,
)

LIBRARY = """
(declare-memory-property robot-at (?where) unknown)
(declare-memory-property battery (?level) unknown)
(declare-memory-proposition alarm (?where))
(declare-memory-proposition holding (?box))
(declare-memory-proposition delivered (?box))
(declare-sensor-datum bell (?where))
(declare-primitive drive (?where) (okay stopped) :atomic false :uses (wheels))
(declare-primitive load (?box) (okay failed stopped) :atomic false
  :uses (wheels arm))
(declare-primitive unload (?box) (okay failed stopped) :atomic false
  :uses (wheels arm))
(declare-primitive charge () (okay failed stopped) :atomic false :uses (wheels))
(declare-primitive call-off (?where) (okay) :uses (wheels))

(define-rap (go ?where)
  (succeed (robot-at ?where))
  (method (primitive (drive ?where))))

(define-rap (deliver ?box ?from ?to)
  (succeed (delivered ?box))
  (method (claims wheels)
    (task-net (t1 (fetch ?box ?from) (for t2)) (t2 (put ?box ?to)))))

(define-rap (fetch ?box ?from)
  (succeed (holding ?box))
  (method here (context (robot-at ?from)) (primitive (load ?box)))
  (method (context (not (robot-at ?from))) (task-net (t1 (go ?from)))))

(define-rap (put ?box ?to)
  (succeed (delivered ?box))
  (method here (context (robot-at ?to)) (primitive (unload ?box)))
  (method (context (not (robot-at ?to))) (task-net (t1 (go ?to)))))

(define-rap (keep-charged)
  (monitor-state (and (battery ?level) (< ?level 4)))
  (succeed nil)
  (method (claims wheels)
    (task-net (t1 (go dock) (for t2)) (t2 (refill)))))

(define-rap (refill) (method (primitive (charge))))

(define-rap (answer-alarms)
  (monitor-state (alarm ?))
  (succeed nil)
  (method (context (alarm ?where)) (claims wheels)
    (task-net (t1 (go ?where) (for t2)) (t2 (answer ?where)))))

(define-rap (answer ?where) (method (primitive (call-off ?where))))
"""

TASKS = (
    "(keep-charged) :priority 4 :background true",
    "(answer-alarms) :priority 8 :background true",
    "(deliver red ward-1 ward-2) :priority 1",
    "(deliver blue ward-3 ward-1) :priority 1 :at 5",
    "(deliver green ward-2 ward-3) :priority 1 :at 20",
)


class Ward(World):
    """Wards, a dock, boxes and a bell; drives take as long as they happen to."""

    name = "ward"

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._time: Time = 0
        self._place: Atom = "dock"
        self._arm: Atom | None = None
        self._jobs: dict[int, tuple[Time, Fact]] = {}
        self._sent: list[Message] = []
        wards = ("ward-1", "ward-2", "ward-3")
        self._bells = sorted((rng.randrange(5, 90), rng.choice(wards)) for _ in "123")
        #: How often a box was not to be had, or not to be put down, where it was tried.
        self.failed = 0
        three = (OKAY, "failed", "stopped")
        offer = Offer(
            primitives={
                "drive": (1, (OKAY, "stopped")),
                "load": (1, three),
                "unload": (1, three),
                "charge": (0, three),
                "call-off": (1, (OKAY,)),
            },
            data={"bell": 1},
        )
        results = dict.fromkeys(offer.primitives, _know)
        self.kit = Kit(offer, Handlers(results, {"bell": _hear}))

    def facts(self) -> Sequence[Fact]:
        return (("robot-at", "dock"), ("battery", 9))

    def now(self) -> Time:
        return self._time

    def perform(self, ticket: int, request: Fact) -> Reply | None:
        if request[0] == "call-off":
            self.advance(self._time + 1)
            return Reply(OKAY)
        takes = {"drive": self._rng.randrange(4, 12), "charge": 6}
        self._jobs[ticket] = (self._time + takes.get(str(request[0]), 3), request)
        return None

    def cancel(self, ticket: int) -> None:
        if ticket in self._jobs:
            _, request = self._jobs.pop(ticket)
            if request[0] == "drive":
                self._place = "corridor"
            self._sent.append(Finished(ticket, Reply("stopped")))

    def next_time(self) -> Time | None:
        if self._sent:
            return self._time
        times = [end for end, _ in self._jobs.values()]
        times += [time for time, _ in self._bells]
        return min(times, default=None)

    def advance(self, to: Time) -> None:
        while self._bells and self._bells[0][0] <= to:
            self._sent.append(Datum(("bell", self._bells.pop(0)[1])))
        for ticket, (end, request) in sorted(self._jobs.items()):
            if end <= to:
                del self._jobs[ticket]
                self._sent.append(Finished(ticket, Reply(self._done(request))))
        self._time = max(self._time, to)

    def _done(self, request: Fact) -> str:
        what, *args = request
        if what == "drive":
            self._place = args[0]
        elif what == "charge":
            return OKAY if self._place == "dock" else "failed"
        elif (self._arm is None) == (what == "load"):
            self._arm = args[0] if what == "load" else None
        else:
            self.failed += 1
            return "failed"
        return OKAY

    def messages(self) -> Sequence[Message]:
        found, self._sent = tuple(self._sent), []
        return found


def _know(memory: HandlerMemory, request: Fact, result: str) -> None:
    what, *args = request
    if what == "drive":
        memory.assert_fact("robot-at", args[0] if result == OKAY else "corridor")
        left = memory.value("battery")
        memory.assert_fact("battery", (9 if left is None else int(str(left))) - 1)
    elif result != OKAY:
        return
    elif what == "load":
        memory.assert_fact("holding", args[0])
    elif what == "unload":
        memory.erase("holding", args[0])
        memory.assert_fact("delivered", args[0])
    elif what == "charge":
        memory.assert_fact("battery", 9)
    else:
        memory.erase("alarm", args[0])


def _hear(memory: HandlerMemory, datum: Fact) -> None:
    memory.assert_fact("alarm", datum[1])


class Shift:
    """One run, and what is to be seen in its trace."""

    def __init__(self, seed: int, library: str = LIBRARY) -> None:
        self.world = Ward(random.Random(f"{seed}:world"))
        settings = Settings(futile_limit=20)
        self.run = Interpreter(
            Program(load_text(library).library), self.world, seed, settings
        )
        self.events: list[events.Event] = []
        self.run.listen(self.events.append)
        for task in TASKS:
            self.run.submit(task)
        self.reason = self.run.run(until=1000)

    def suspended(self) -> list[events.MethodSuspended]:
        """Return all suspensions."""
        return [e for e in self.events if isinstance(e, events.MethodSuspended)]

    def never_resumed(self) -> list[int]:
        """Return the tasks that were suspended and not woken after that."""
        woken = {e.task: e.n for e in self.events if isinstance(e, events.TaskWoken)}
        return [s.task for s in self.suspended() if woken.get(s.task, -1) < s.n]

    def moved_from_under(self) -> int:
        """Return how often the robot was driven away from a task of no lower priority.

        Such a task is one with a method under way that wants the robot for itself.
        """
        made: dict[int, events.TaskCreated] = {}
        at_work: set[int] = set()
        found = 0
        for event in self.events:
            match event:
                case events.TaskCreated():
                    made[event.task] = event
                case events.MethodChosen():
                    if event.rap in ("deliver", "keep-charged", "answer-alarms"):
                        at_work.add(event.task)
                case events.MethodEnded():
                    at_work.discard(event.task)
                case events.PrimitiveRequested() if event.request[0] == "drive":
                    for_whom = made[made[event.task].family]
                    found += any(
                        made[one].priority >= for_whom.priority
                        for one in at_work - {for_whom.task}
                    )
        return found


def without_claims() -> str:
    """Return the library with all its claims taken out."""
    return LIBRARY.replace("(claims wheels)", "")
