"""Compiled libraries made by hand, and a world in which any of them can be run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path

import msgspec

from rapc import host
from rapc.base.values import Fact
from rapc.compiler.program import Program
from rapc.events import Event
from rapc.library.library import Library
from rapc.library.saved import SavedLibrary, Suite, encode
from rapc.runtime.events.trace import record
from rapc.testing import discover
from rapc.testing.coverage import Coverage
from rapc.world import (
    Handlers,
    Kit,
    Message,
    Reply,
    Time,
    World,
)
from rapc.worlds.script import offer_of

HERE = Path(__file__).parent
KITCHEN = HERE / "kitchen.rap"


def suites(path: Path) -> list[Suite]:
    """The tests at a path, with the libraries that they run."""
    found = discover.find([path])
    assert found.reports == ()
    groups = groupby(found.cases, lambda case: id(case.library))
    together = [list(cases) for _, cases in groups]
    return [
        Suite(
            [case.test for case in cases],
            cases[0].library.library,
            cases[0].library.name,
        )
        for cases in together
    ]


def compiled(path: Path) -> bytes:
    """A library with its tests as bytes."""
    return saved(host.load(path), suites(path))


def saved(library: host.CheckedLibrary, tests: Sequence[Suite] = ()) -> bytes:
    """A library as bytes, with some tests."""
    return encode(library.program.library, library.name, tests)


def program(data: bytes, file: str = "file") -> Program:
    """A library from bytes, ready to be run."""
    library = SavedLibrary(data, file)
    return Program(library.library, library.name)


def fields(library: Library) -> Mapping[str, object]:
    """All that a library says, spans and texts among it, in a form to be compared."""
    found = {name: getattr(library, name) for name in library.__struct_fields__}
    found["raps"] = dict(library.raps)
    found["files"] = {name: source.text for name, source in library.files.items()}
    return {name: msgspec.json.encode(value) for name, value in found.items()}


class Recorded(Coverage):
    """Listens to a test as coverage does, and keeps the trace."""

    def __init__(self) -> None:
        super().__init__()
        self.trace: list[bytes] = []

    def __call__(self, event: Event) -> None:
        """Keep an event as its line of JSON."""
        self.trace.append(msgspec.json.encode(record(event)))


class YesWorld(World):
    """A world that offers whatever a library declares, and where all goes well."""

    name = "yes"

    def __init__(self, library: Program) -> None:
        offer = offer_of(library.library)
        self.kit = Kit(offer, Handlers({}, dict.fromkeys(offer.data, _ignored)))
        self._time: Time = 0

    def now(self) -> Time:
        """A time unit for each request."""
        return self._time

    def perform(self, ticket: int, request: Fact) -> Reply:
        """All goes well."""
        self._time += 1
        return Reply("okay")

    def next_time(self) -> Time | None:
        """Nothing comes."""
        return None

    def advance(self, to: Time) -> None:
        """Let time pass."""
        self._time = max(self._time, to)

    def messages(self) -> Sequence[Message]:
        """None."""
        return ()


def _ignored(memory: object, datum: Fact) -> None:
    """Change nothing."""
