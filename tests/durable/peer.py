"""A world that goes on when the process of the interpreter dies.

The robot does jobs that take time, and a sensor sends a datum each second. It is in
this process, with a clock that only `advance` moves, or in a process of its own with
real time, until it is killed:

    python -m tests.durable.peer SOCKET
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from multiprocessing.connection import Client, Listener
from typing import Any

from rapc.base.values import Fact
from rapc.world import (
    NOT_KNOWN,
    Datum,
    Finished,
    Handlers,
    Kit,
    Message,
    Offer,
    Refused,
    Reply,
    Time,
    World,
)

SPEED = 50
"""Time units in a second of real time."""

PACE = SPEED // 20
"""Time units between two data in real time."""

JOB = 3
"""The time that a job takes."""


class Peer:
    """A robot with jobs by ticket, and messages until they are acknowledged.

    Args:
        real: whether the clock is that of the machine.
    """

    def __init__(self, *, real: bool = False) -> None:
        self._begun = time.monotonic() if real else None
        self._time: Time = 0
        self._beat = 1
        #: The time of the end of each job, by ticket, and what the job is.
        self.jobs: dict[int, tuple[Time, Fact]] = {}
        #: The answer to the last call of `perform`.
        self.answered: dict[int, Reply | None] = {}
        #: The messages after the first `forgotten` ones, and how many were returned.
        self.kept: list[Message] = []
        self.forgotten = self.returned = 0
        #: How often each request was begun, and how often done.
        self.started: Counter[Fact] = Counter()
        self.done: Counter[Fact] = Counter()
        self.resumed = 0

    def now(self) -> Time:
        """Return the time, after all that is due was done."""
        if self._begun is not None:
            self._go((time.monotonic() - self._begun) * SPEED)
        return self._time

    def _go(self, to: Time) -> None:
        for ticket, (end, request) in sorted(self.jobs.items()):
            if end <= to:
                del self.jobs[ticket]
                self.done[request] += 1
                self.kept.append(Finished(ticket, Reply("okay")))
        while self._beat <= to:
            self.kept.append(Datum(("beat", self._beat)))
            self._beat += 1 if self._begun is None else PACE
        self._time = max(self._time, to)

    def perform(self, ticket: int, request: Fact) -> Reply | None:
        """Begin a job; a look ends at once."""
        self.started[request] += 1
        answer = None
        if request[0] == "look":
            self.done[request] += 1
            answer = Reply("okay")
        else:
            self.jobs[ticket] = self.now() + JOB, request
        self.answered = {ticket: answer}
        return answer

    def cancel(self, ticket: int) -> None:
        self.jobs.pop(ticket, None)

    def next_time(self) -> Time:
        if self._begun is not None:
            return NOT_KNOWN
        return min([self._beat, *(end for end, _ in self.jobs.values())])

    def advance(self, to: Time) -> None:
        """Wait for a message or for the time `to`."""
        if self._begun is None:
            self._go(to)
        while self.now() < to and not self._fresh():
            time.sleep(0.001)

    def _fresh(self) -> list[Message]:
        return self.kept[self.returned - self.forgotten :]

    def messages(self) -> Sequence[Message]:
        self.now()
        found = self._fresh()
        self.returned += len(found)
        return found

    def resume(self, tickets: Sequence[int], received: int) -> dict[int, Reply | None]:
        if received < self.forgotten:
            raise ValueError(f"{self.forgotten} messages are forgotten")
        self.resumed += 1
        self.returned = received
        for ticket in {*self.jobs} - {*tickets}:
            del self.jobs[ticket]
        coming = {one.ticket for one in self._fresh() if isinstance(one, Finished)}
        known: dict[int, Reply | None] = dict.fromkeys(coming | {*self.jobs})
        known |= self.answered
        return {ticket: known[ticket] for ticket in tickets if ticket in known}

    def acknowledge(self, received: int) -> None:
        del self.kept[: received - self.forgotten]
        self.forgotten = received

    def counts(self) -> tuple[Counter[Fact], Counter[Fact], int]:
        """Return the requests begun and done, and the number of resumptions."""
        return self.started, self.done, self.resumed


def _done(memory: Any, request: Fact, result: str) -> None:
    memory.assert_fact("done", request[1])


def _beat(memory: Any, datum: Fact) -> None:
    memory.assert_fact("beaten", datum[1])


class PeerWorld(World):
    """The world of a peer.

    Args:
        call: calls a method of the peer by its name.
    """

    name = "peer"
    kit = Kit(
        Offer(
            primitives={"work": (1, ("okay",)), "look": (1, ("okay",))},
            data={"beat": 1},
            sensors=("look",),
            not_atomic=("work",),
        ),
        Handlers({"work": _done, "look": _done}, {"beat": _beat}),
    )

    def __init__(self, call: Callable[..., Any]) -> None:
        self.call = call

    def now(self) -> Time:
        return self.call("now")  # type: ignore[no-any-return]

    def perform(self, ticket: int, request: Fact) -> Reply | Refused | None:
        return self.call("perform", ticket, request)  # type: ignore[no-any-return]

    def cancel(self, ticket: int) -> None:
        self.call("cancel", ticket)

    def next_time(self) -> Time | None:
        return self.call("next_time")  # type: ignore[no-any-return]

    def advance(self, to: Time) -> None:
        self.call("advance", to)

    def messages(self) -> Sequence[Message]:
        return self.call("messages")  # type: ignore[no-any-return]


class ResumablePeer(PeerWorld):
    """The world of a peer that can be asked what became of requests."""

    def resume(
        self, tickets: Sequence[int], received: int
    ) -> Mapping[int, Reply | Refused | None]:
        return self.call("resume", tickets, received)  # type: ignore[no-any-return]

    def acknowledge(self, received: int) -> None:
        self.call("acknowledge", received)


def of(peer: Peer) -> Callable[..., Any]:
    """Return the calls of a peer in this process."""
    return lambda name, *args: getattr(peer, name)(*args)


def at(socket: str) -> Callable[..., Any]:
    """Return the calls of a peer in a process of its own."""
    connection = Client(socket, "AF_UNIX")

    def call(name: str, *args: object) -> Any:
        connection.send((name, *args))
        found = connection.recv()
        if isinstance(found, Exception):
            raise found
        return found

    return call


def library(jobs: int) -> str:
    """Return a library whose task `(all)` does some jobs, each after a look."""
    steps = [
        f"(s{n} (look-p {n}) (for t{n})) (t{n} (work-p {n})"
        + (f" (for s{n + 1}))" if n < jobs else ")")
        for n in range(1, jobs + 1)
    ]
    return f"""
    (declare-memory-proposition done (?n))
    (declare-memory-property beaten (?n) unknown)
    (declare-primitive work (?n) (okay) :atomic false)
    (declare-primitive look (?n) (okay))
    (declare-sensor-datum beat (?n))
    (define-rap (look-p ?n) (method (primitive (look ?n))))
    (define-rap (work-p ?n) (method (primitive (work ?n))))
    (define-rap (all) (method (task-net {" ".join(steps)})))
    """


def serve(socket: str) -> None:
    """Serve one process of the interpreter after the other."""
    peer = Peer(real=True)
    with Listener(socket, "AF_UNIX") as listener:
        print("ready", flush=True)
        while True:
            with listener.accept() as connection:
                try:
                    while True:
                        name, *args = connection.recv()
                        try:
                            connection.send(getattr(peer, name)(*args))
                        except ValueError as error:
                            connection.send(error)
                except (EOFError, OSError):
                    continue


if __name__ == "__main__":
    serve(sys.argv[1])
