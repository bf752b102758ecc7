"""One run of the truck library, with what a test wants to know of it afterwards."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from rapc import events
from rapc.base.values import Atom, Text, format_list
from rapc.compiler.program import Program
from rapc.library.loader import load
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import TaskRequest, of_agenda
from rapc.worlds.maps import shipped_map
from rapc.worlds.registry import build_world
from rapc.worlds.truck import TruckWorld

EXAMPLES = Path(__file__).parents[2] / "examples"
STDLIB = Path(__file__).parents[2] / "stdlib"

FACTORIES: Mapping[str, str] = {
    "red": "factory-1",
    "blue": "factory-2",
    "yellow": "factory-3",
}

PLENTY: Mapping[str, Atom | bool] = {"fuel": 1000, "fuel-capacity": 1000}
"""Options for runs that would burn more than a full fuel bay."""


@cache
def library(path: Path = EXAMPLES / "rock-order.rap") -> Program:
    """A library, compiled once for all tests; nothing may be wrong with its text."""
    loaded = load([path])
    assert loaded.diagnostics == ()
    return Program(loaded.library, path.stem)


def order(
    color: str, rocks: int = 4, factory: str | None = None, **how: Any
) -> TaskRequest:
    """The task of an order; `how` is said of the submission."""
    goal = ("fill-order", color, rocks, factory or FACTORIES.get(color, "factory-1"))
    return TaskRequest(goal, **how)


def task(*goal: Atom, **how: Any) -> TaskRequest:
    """Any other task."""
    return TaskRequest(goal, **how)


def agenda(name: str) -> tuple[TaskRequest, ...]:
    """The tasks of an agenda of the truck library."""
    return of_agenda(library(STDLIB / "truck").library, name)


def map_with(*items: tuple[str, str, int, str | None]) -> Text:
    """The map of T 6.1 with other items: kind, place, number and colour of each."""
    ground = json.loads(shipped_map("truck", "default"))
    ground["items"] = [
        {"kind": kind, "place": place, "count": count, "color": color}
        for kind, place, count, color in items
    ]
    return Text(json.dumps(ground))


class Run:
    """A finished run.

    `answers` counts the results of each primitive, `requests` holds them all as text;
    `places` has the last place that memory gave each item, `moves` how often one of a
    class was moved to a place, `put_down` the memory name that each sensor name had
    when an arm last put it down, `faults` every query that could not be asked.
    """

    def __init__(
        self,
        *tasks: TaskRequest,
        seed: int = 0,
        options: Mapping[str, Atom | bool] | None = None,
        compiled: Program | None = None,
        settings: Settings | None = None,
    ) -> None:
        self.answers: Counter[tuple[str, str]] = Counter()
        self.requests: list[str] = []
        self.places: dict[str, str] = {}
        self.moves: Counter[tuple[str, str]] = Counter()
        self.put_down: dict[str, str] = {}
        self.faults: list[str] = []
        world = build_world(TruckWorld, seed, options or {})
        assert isinstance(world, TruckWorld)
        self.world = world
        self.interpreter = Interpreter(
            compiled or library(), world, seed, settings or Settings()
        )
        self.interpreter.listen(self._note)
        for each in tasks:
            self.interpreter.submit(each)
        self.reason = self.interpreter.run(until=30_000)

    def _note(self, event: events.Event) -> None:
        if isinstance(event, events.ItemMoved | events.ItemIntroduced):
            self.places[event.item] = str(event.location)
            if isinstance(event, events.ItemMoved):
                self.moves[event.kind, str(event.location)] += 1
        elif isinstance(event, events.PrimitiveRequested):
            if event.request[0] == "arm-ungrasp":
                self.put_down[str(event.sent[-1])] = str(event.request[-1])
        elif isinstance(event, events.PrimitiveEnded):
            self.requests.append(format_list(event.request))
            self.answers[str(event.request[0]), event.result] += 1
        elif isinstance(event, events.QueryFaulted):
            self.faults.append(event.what)

    @property
    def outcomes(self) -> Sequence[str]:
        """What became of each task that does not stand in the background."""
        results = self.interpreter.results()
        return [result.outcome for result in results if not result.background]

    @property
    def delivered(self) -> Counter[tuple[str, str]]:
        """How many rocks of each colour came to each factory, by the world's log."""
        return Counter((each.color, each.factory) for each in self.world.deliveries)

    def assert_honest(self) -> None:
        """No rock delivered twice, as many where memory has them, no query at fault."""
        log = self.world.deliveries
        items = [each.item for each in log]
        assert len(items) == len(set(items)), "a rock stands twice in the log"
        memory = self.interpreter.memory
        for factory, number in Counter(each.factory for each in log).items():
            assert self.moves["rock", factory] == number
            assert memory.count("rock", factory) >= number
        assert self.faults == []
