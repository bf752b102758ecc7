"""A real memory between handlers and a test, without an interpreter."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec

from rapc.base.values import Fact
from rapc.library.library import Library
from rapc.library.loader import load
from rapc.library.signatures import Signatures
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.access import MemoryAccess
from rapc.world import Datum, Reply, World

TRUCK_WORDS = Path(__file__).parents[2] / "stdlib" / "truck" / "world.rap"


def truck_words() -> Library:
    """The declarations of the truck's world."""
    loaded = load([TRUCK_WORDS])
    assert loaded.diagnostics == ()
    return loaded.library


class Robot:
    """Sends requests to a world and lets its handlers digest what comes back."""

    def __init__(self, world: World, library: Library) -> None:
        self.world = world
        self.handlers = world.kit.handlers
        self.recorder = Recorder()
        plain = msgspec.structs.replace(library, indistinct={})
        self.access = MemoryAccess(plain, Signatures.of(plain), self.recorder, {})
        self.memory = self.access.memory
        for fact in world.facts():
            self.access.assert_fact(*fact)
        self.listen()

    def do(self, *requests: str) -> str:
        """The result of the last of some requests in words, all of them digested."""
        result = ""
        for request in requests:
            result = self.perform(tuple(request.split()))
        return result

    def perform(self, request: Fact) -> str:
        """The result of a request, its handlers run; what came unasked before it."""
        reply = self.world.perform(1, request)
        assert isinstance(reply, Reply)
        self.digest(request, reply.result, reply.data)
        self.listen()
        return reply.result

    def digest(self, request: Fact, result: str, data: Sequence[Fact] = ()) -> None:
        """Run the handlers of a result and its data."""
        self.recorder.time = self.world.now()
        handler = self.handlers.results.get(str(request[0]))
        if handler is not None:
            handler(self.access, request, result)
        for datum in data:
            self.handlers.data[str(datum[0])](self.access, datum)

    def listen(self) -> list[object]:
        """Digest what the world has sent unasked; what is no datum is returned."""
        self.recorder.time = self.world.now()
        others: list[object] = []
        for message in self.world.messages():
            if isinstance(message, Datum):
                self.handlers.data[str(message.content[0])](
                    self.access, message.content
                )
            else:
                others.append(message)
        return others

    def knows(self, fact: str) -> bool:
        """Whether a fact in words is in memory; `?` stands for anything."""
        parts = [None if word == "?" else _atom(word) for word in fact.split()]
        return bool(self.access.query(*parts))

    def where(self, item: str) -> object:
        """Where memory has an item."""
        return self.access.value("location", item)

    def reaches(self, item: str) -> bool:
        """Whether an item has a sensor name now."""
        return self.memory.items.is_accessible(item)


def _atom(word: str) -> str | int | float:
    try:
        return int(word)
    except ValueError:
        return word
