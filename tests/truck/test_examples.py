"""The examples do what their comments say; those without a truck, against a script."""

from __future__ import annotations

from collections.abc import Sequence

from rapc import events
from rapc.base.values import Fact, format_list
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.task_request import TaskRequest
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld

from .runs import EXAMPLES, Run, library, task


class Scripted:
    """A run of an example against a script, with the requests it made."""

    def __init__(
        self,
        name: str,
        script: Sequence[Row],
        facts: Sequence[Fact],
        *tasks: TaskRequest,
        until: float | None = None,
    ) -> None:
        compiled = library(EXAMPLES / f"{name}.rap")
        world = ScriptedWorld(script, declared=compiled.library)
        self.requests: list[str] = []
        self.interpreter = Interpreter(compiled, world)
        self.interpreter.listen(self._note)
        for fact in facts:
            self.interpreter.assert_fact(*fact)
        for each in tasks:
            self.interpreter.submit(each)
        self.reason = self.interpreter.run(until=until)
        self.outcomes = [result.outcome for result in self.interpreter.results()]

    def _note(self, event: events.Event) -> None:
        if isinstance(event, events.PrimitiveRequested):
            self.requests.append(format_list(event.request))


def seen(state: str) -> tuple[Fact, ...]:
    """What memory is told of the door."""
    return (("door-state", "?door", state),)


DOOR = (
    Row(("look-at", "?door"), asserts=seen("shut")),
    Row(("turn-handle", "?door"), "door-locked", times=1, asserts=seen("locked")),
    Row(("turn-handle", "?door"), "door-stuck", asserts=seen("stuck")),
    Row(("turn-key", "?door"), asserts=seen("shut")),
    Row(("push", "?door"), "door-stuck", times=1),
    Row(("push", "?door"), asserts=seen("open")),
    Row(("drive-through", "?door")),
)


def test_stuck_door_is_unlocked_pushed_and_passed() -> None:
    run = Scripted("stuck-door", DOOR, (), task("pass-through", "gate"))
    assert run.outcomes == ["succeeded"]
    assert run.requests == [
        "(look-at gate)",
        "(turn-handle gate)",
        "(turn-key gate)",
        "(turn-handle gate)",
        "(push gate)",
        "(push gate)",
        "(drive-through gate)",
    ]


def test_stuck_door_that_never_gives_way_is_given_up() -> None:
    stuck = Row(("push", "?door"), "door-stuck")
    run = Scripted(
        "stuck-door",
        [stuck],
        [("door-state", "gate", "stuck")],
        task("open-door", "gate"),
    )
    assert run.outcomes == ["failed"]
    assert run.requests == ["(push gate)"] * 2


def test_stuck_door_with_something_in_the_way_is_not_rammed_twice() -> None:
    blocked = Row(("drive-through", "?door"), "door-in-the-way")
    run = Scripted("stuck-door", [blocked], (), task("get-past", "gate"))
    assert run.outcomes == ["failed"]
    assert run.requests == ["(drive-through gate)"]


PLANTS: tuple[Fact, ...] = (("plant", "fern"), ("plant", "moss"), ("plant", "rose"))

GARDEN = (
    Row(("feel-soil", "moss"), asserts=(("felt", "moss"), ("moisture", "moss", "wet"))),
    Row(("feel-soil", "?p"), asserts=(("felt", "?p"), ("moisture", "?p", "dry"))),
    Row(
        ("pour-water", "?p"),
        times=1,
        asserts=(("moisture", "?p", "wet"), ("can", "empty")),
    ),
    Row(("pour-water", "?p"), asserts=(("moisture", "?p", "wet"),)),
    Row(("fill-can",), asserts=(("can", "full"),)),
)


def test_greenhouse_waters_what_is_dry_and_fills_the_can_between() -> None:
    dry: tuple[Fact, ...] = (("moisture", "fern", "dry"), ("moisture", "rose", "dry"))
    run = Scripted("greenhouse", GARDEN, (*PLANTS, *dry), task("water-plants", 10))
    assert run.outcomes == ["succeeded"]
    assert run.requests == ["(pour-water fern)", "(fill-can)", "(pour-water rose)"]


def test_greenhouse_stops_when_the_counter_is_used_up() -> None:
    dry: tuple[Fact, ...] = (("moisture", "fern", "dry"), ("moisture", "rose", "dry"))
    run = Scripted("greenhouse", GARDEN, (*PLANTS, *dry), task("water-plants", 1))
    assert run.outcomes == ["succeeded"]
    assert run.requests == ["(pour-water fern)"]


def test_greenhouse_feels_the_soil_in_time_and_waters_what_it_finds_dry() -> None:
    standing = (task("watch-soil"), task("keep-wet"))
    run = Scripted("greenhouse", GARDEN, PLANTS, *standing, until=130)
    assert run.reason == "until"
    assert run.interpreter.now == 130
    felt = [request for request in run.requests if request.startswith("(feel")]
    assert felt == ["(feel-soil fern)", "(feel-soil moss)", "(feel-soil rose)"]
    assert run.interpreter.memory.value("moisture", "fern") == "wet"
    assert run.interpreter.memory.value("moisture", "rose") == "wet"


def test_rock_order_knows_which_factory_wants_a_colour() -> None:
    run = Run(task("rock-order", "yellow", 2))
    assert run.outcomes == ["succeeded"]
    assert run.delivered == {("yellow", "factory-3"): 2}
    run.assert_honest()
