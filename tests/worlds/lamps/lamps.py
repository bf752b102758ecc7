"""A corridor of rooms, a lamp in each, and a robot that can press switches."""

from random import Random
from typing import Any

from rapc.world import (
    Datum,
    Fact,
    HandlerMemory,
    Handlers,
    Kit,
    Offer,
    Option,
    Reply,
    World,
)


def pressed(memory: HandlerMemory, request: Fact, result: str) -> None:
    if result == "okay":
        before = memory.value("lamp-state", request[1])
        memory.assert_fact("lamp-state", request[1], "off" if before == "on" else "on")


def lamp_seen(memory: HandlerMemory, datum: Fact) -> None:
    memory.assert_fact("lamp-state", datum[1], datum[2])


class LampWorld(World):
    """A corridor of rooms with lamps that somebody keeps switching off."""

    name = "lamps"
    kit = Kit(
        Offer(
            {"press": (1, ("okay", "stuck", "none")), "look": (1, ("okay", "none"))},
            {"lamp": 2},
            sensors=("look",),
        ),
        Handlers({"press": pressed}, {"lamp": lamp_seen}),
        (
            Option("rooms", "integer", 3, "rooms", "how many there are"),
            Option("every", "number", 40, "time units", "between visits of somebody"),
        ),
    )

    def __init__(self, rng: Random, options: Any) -> None:
        self.rng, self.every = rng, options["every"]
        self.lit = {f"room-{n}": False for n in range(1, options["rooms"] + 1)}
        self.time, self.due = 0, self.every
        self.sent: list[Datum] = []

    def facts(self) -> list[Fact]:
        return [("room", room) for room in self.lit]

    def now(self) -> int:
        return self.time

    def perform(self, ticket: int, request: Fact) -> Reply:
        name, room = str(request[0]), str(request[1])
        self.advance(self.time + 2)
        if room not in self.lit:
            return Reply("none")
        if name == "look":
            return Reply("okay", (("lamp", room, "on" if self.lit[room] else "off"),))
        if self.rng.random() < 0.25:
            return Reply("stuck")
        self.lit[room] = not self.lit[room]
        return Reply("okay")

    def next_time(self) -> int:
        return self.time if self.sent else self.due

    def advance(self, to: Any) -> None:
        while self.due <= to:
            room = self.rng.choice(list(self.lit))
            self.lit[room], self.due = False, self.due + self.every
            self.sent.append(Datum(("lamp", room, "off")))
        self.time = max(self.time, to)

    def messages(self) -> list[Datum]:
        sent, self.sent = self.sent, []
        return sent
