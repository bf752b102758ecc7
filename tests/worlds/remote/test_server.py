"""The server of Python worlds, and runs that outlive a connection."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pytest

from rapc.live import ResumableDriver
from rapc.world import (
    Datum,
    Fact,
    Finished,
    Kit,
    Message,
    Offer,
    Refused,
    Reply,
    Resumable,
    SimpleWorld,
    World,
)
from rapc.worlds.registry import build_world, find_world
from rapc.worlds.remote.server import Connection, Served
from rapc.worlds.remote.world import RemoteWorld


class Cart(SimpleWorld):
    """A cart that remembers its requests, and can halt."""

    name = "cart"
    kit = Kit(
        Offer(
            {"roll": (1, ("okay",)), "ring": (0, ("okay",))},
            {"rung": 1},
            not_atomic=("roll",),
        )
    )
    halted = 0

    def __init__(self, rng: Any, options: Any) -> None:
        super().__init__(rng, options)
        self.known: dict[int, Reply | None] = {}
        self.all: list[Message] = []

    def perform(self, ticket: int, request: Fact) -> Reply | None:
        if request[0] == "ring":
            self.send(Datum(("rung", ticket), number=ticket))
            self.known[ticket] = Reply("okay")
        else:
            self.send(Finished(ticket, Reply("okay")), after=5)
            self.known[ticket] = None
        return self.known[ticket]

    def messages(self) -> Sequence[Message]:
        found = super().messages()
        self.all += found
        return found

    def resume(
        self, tickets: Sequence[int], received: int
    ) -> Mapping[int, Reply | Refused | None]:
        self.outbox = [(self.time, one) for one in self.all[received:]] + self.outbox
        del self.all[received:]
        return {one: self.known[one] for one in tickets if one in self.known}

    def acknowledge(self, received: int) -> None:
        self.acknowledged = received

    def halt(self) -> None:
        Cart.halted += 1


class Restarted(ResumableDriver):
    """A driver whose machine has gone on when the process of the driver died."""

    name = "restarted"
    kit = Kit(Offer({"ring": (0, ("okay",))}, {"kept": 1}))

    def reconnect(self, tickets: Sequence[int]) -> None:
        for ticket in tickets:
            self.send(Datum(("kept", ticket)))

    def do_ring(self) -> None:
        """Nothing: the machine rings once for a ticket."""


def answers(world: type[World], *calls: tuple[str, Any], token: str = "") -> list[Any]:
    """Return the answers to calls of a connection, which then ends."""
    lines = [
        json.dumps({"jsonrpc": "2.0", "id": n, "method": method, "params": params})
        for n, (method, params) in enumerate(calls)
    ]
    writer = io.BytesIO()
    reader = io.BytesIO("".join(line + "\n" for line in lines).encode())
    Connection(Served(world, token=token), reader, writer).run()
    return [json.loads(line) for line in writer.getvalue().splitlines()]


def test_body_halts_at_the_end_of_the_connection() -> None:
    Cart.halted = 0
    opening = ("open", {"seed": 1})
    answers(Cart, opening)
    assert Cart.halted == 0
    answers(Cart, opening, ("perform", {"ticket": 1, "request": ["roll", "hall"]}))
    assert Cart.halted == 1


def test_description_asks_for_heartbeats_if_the_world_can_halt() -> None:
    (told,) = answers(Cart, ("describe", {"protocol": 1}))
    assert told["result"]["heartbeat"] == 0.25
    assert "resume" in told["result"]["methods"]


@pytest.mark.parametrize(
    ("call", "wanted"),
    [
        (("dance", {}), "unknown method `dance`"),
        (("advance", {"to": 1}), "`open` must come first"),
        (("resume", {"tickets": [], "received": 0}), "no run goes on"),
        (("open", {"seed": "x"}), "invalid call: expected `int`, got `str`"),
    ],
)
def test_server_refuses_invalid_calls(call: tuple[str, Any], wanted: str) -> None:
    (told,) = answers(Cart, call)
    assert wanted in told["error"]["message"]


def test_driver_in_a_new_process_resumes_a_run() -> None:
    resuming = {"tickets": [4], "received": 3, "opening": {"seed": 1}}
    ring = {"ticket": 4, "request": ["ring"]}
    told = answers(Restarted, ("resume", resuming), ("perform", ring))
    resumed, rung = [one["result"] for one in told]
    assert "requests" not in resumed
    assert [one["content"] for one in resumed["messages"]] == [["kept", 4]]
    assert resumed["sent"] == 4
    assert rung["reply"] == {"result": "okay"}


def test_token_must_come_first() -> None:
    told = answers(Cart, ("open", {"seed": 1}), token="a secret")  # noqa: S106
    assert told[0]["error"]["message"] == "`describe` with the token must come first"


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """The address of a served cart, which outlives connections."""
    address = f"unix:{tmp_path}/cart"
    command = [sys.executable, "-m", "rapc.worlds.remote"]
    command += ["tests.worlds.remote.test_server:Cart", address]
    server = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert server.stderr is not None
    assert server.stderr.readline() == f"serving cart at {address}\n"
    yield address
    server.kill()
    server.wait()
    server.stderr.close()


def test_run_resumes_through_a_new_connection(address: str) -> None:
    world: Any = build_world(find_world(address), 0, {})
    assert isinstance(world, RemoteWorld)
    assert isinstance(world, Resumable)
    assert world.perform(1, ("ring",)) == Reply("okay")
    assert world.messages() == [Datum(("rung", 1), number=1)]
    world.perform(2, ("roll", "hall"))
    world.advance(5)
    world._connected().close()  # as the death of the process would
    other: Any = build_world(find_world(address), 0, {})
    assert other.resume([1, 2, 3], 1) == {1: Reply("okay"), 2: None}
    assert other.now() == 5
    assert other.messages() == [Finished(2, Reply("okay"))]
    other.acknowledge(2)
    other.advance(6)
    assert other.now() == 6


def test_resume_without_a_run_is_refused(address: str) -> None:
    world: Any = build_world(find_world(address), 0, {})
    with pytest.raises(ValueError, match="no run goes on"):
        world.resume([], 0)
