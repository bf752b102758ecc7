"""A rover in real time that halts without heartbeats; it logs each start and halt."""

import os
import queue
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
    Reply,
    Time,
    World,
)

DRIVE = 1.0
"""The duration of a drive in seconds."""


class Rover(World):
    """A rover in real time; a time unit is a second."""

    name = "rover"
    kit = Kit(
        Offer(
            {"drive": (1, ("okay", "halted"))},
            not_atomic=("drive",),
            arguments={"drive": ("room",)},
        )
    )

    def __init__(self, rng: Random, options: Mapping[str, Any]) -> None:
        self.began = time.monotonic()
        self.time: Time = 0
        self.mailbox: queue.SimpleQueue[Message] = queue.SimpleQueue()
        self.inbox: list[Message] = []
        self.lock = threading.Lock()
        self.ticket: int | None = None

    def now(self) -> Time:
        return self.time

    def perform(self, ticket: int, request: Fact) -> None:
        log("start")
        self.ticket = ticket
        timer = threading.Timer(DRIVE, self.end, [ticket, "okay"])
        timer.daemon = True
        timer.start()

    def end(self, ticket: int | None, result: str) -> None:
        """End the drive; called from several threads."""
        with self.lock:
            if ticket is None or ticket != self.ticket:
                return
            self.ticket = None
            log(result)
            self.mailbox.put(Finished(ticket, Reply(result)))

    def halt(self) -> None:
        self.end(self.ticket, "halted")

    def next_time(self) -> Time:
        return self.time if self.inbox else NOT_KNOWN

    def advance(self, to: Time) -> None:
        while not self.inbox and (wait := to - self.clock()) > 0:
            try:
                self.inbox.append(self.mailbox.get(timeout=wait))
            except queue.Empty:
                break
        self.time = max(self.time, self.clock())

    def clock(self) -> Time:
        return round(time.monotonic() - self.began, 3)

    def messages(self) -> Sequence[Message]:
        sent, self.inbox = self.inbox, []
        return sent


def log(what: str) -> None:
    """Append a line with the time, if the environment names a file."""
    if path := os.environ.get("ROVER_LOG"):
        with Path(path).open("a") as file:
            file.write(f"{what} {time.time()}\n")
