"""A porter in real time that outlives the interpreter, and logs each request.

The porter waits before it ends more requests than the file `PORTER_LIMIT` permits.
"""

import os
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from random import Random
from typing import Any

from rapc.world import (
    NOT_KNOWN,
    Fact,
    Finished,
    Kit,
    Message,
    Offer,
    Refused,
    Reply,
    Time,
    World,
)


class Porter(World):
    """A porter that carries parcels, each for 20 ms; a time unit is a second."""

    name = "porter"
    kit = Kit(Offer({"carry": (1, ("okay",))}, not_atomic=("carry",)))

    def __init__(self, rng: Random, options: Mapping[str, Any]) -> None:
        self.began, self.time = time.monotonic(), 0.0
        self.known: set[int] = set()
        #: All messages, the number of fetched messages, and of forgotten messages.
        self.sent: list[Message] = []
        self.fetched = self.forgotten = 0
        self.news = threading.Condition()

    def now(self) -> Time:
        return self.time

    def perform(self, ticket: int, request: Fact) -> None:
        with Path(os.environ["PORTER_LOG"]).open("a") as log:
            log.write(f"{ticket} {request[1]}\n")
        self.known.add(ticket)
        timer = threading.Timer(0.02, self.end, [ticket])
        timer.daemon = True
        timer.start()

    def end(self, ticket: int) -> None:
        while len(self.sent) >= int(Path(os.environ["PORTER_LIMIT"]).read_text()):
            time.sleep(0.005)
        with self.news:
            self.sent.append(Finished(ticket, Reply("okay")))
            self.news.notify_all()

    def next_time(self) -> Time:
        return self.time if self.fetched < len(self.sent) else NOT_KNOWN

    def advance(self, to: Time) -> None:
        with self.news:
            wait = to - (time.monotonic() - self.began)
            self.news.wait_for(lambda: self.fetched < len(self.sent), max(wait, 0))
        self.time = round(max(self.time, time.monotonic() - self.began), 3)

    def messages(self) -> Sequence[Message]:
        found = self.sent[self.fetched :]
        self.fetched += len(found)
        return found

    def resume(
        self, tickets: Sequence[int], received: int
    ) -> Mapping[int, Reply | Refused | None]:
        if received < self.forgotten:
            raise ValueError("messages are forgotten")
        self.fetched = received
        return {ticket: None for ticket in tickets if ticket in self.known}

    def acknowledge(self, received: int) -> None:
        assert received <= self.fetched
        self.forgotten = max(self.forgotten, received)

    def halt(self) -> None:
        """Nothing: the porter finishes the parcel in hand."""
