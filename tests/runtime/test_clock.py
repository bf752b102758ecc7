"""The clock of a run, and worlds whose clock does not do what a clock does."""

from __future__ import annotations

import math

import pytest

from rapc.errors import PortError
from rapc.runtime.events.events import Event, RunEnded
from rapc.runtime.interpreter import Interpreter
from rapc.runtime.settings import Settings
from rapc.runtime.task_request import read_task_request
from rapc.world import Reply, Time
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld
from tests.runtime.helpers import ANY, compiled

WAIT = """
(define-rap (wait) (succeed (go)) (monitor-state (go)) (method (primitive (look a))))
"""
LOOK = "(define-rap (once) (method (primitive (look a))))"


class _Clock(ScriptedWorld):
    """A world whose clock and next time are what a test says."""

    def __init__(self, library: object) -> None:
        super().__init__(ANY, (), declared=library)  # type: ignore[arg-type]
        self.coming: Time | None = None
        self.takes: list[Time] = []
        self.shown: Time | None = None

    def next_time(self) -> Time | None:
        return self.coming

    def now(self) -> Time:
        return super().now() if self.shown is None else self.shown

    def perform(self, ticket: int, request: tuple[object, ...]) -> Reply:
        if self.takes:
            self.shown = self.takes.pop(0)
        return Reply("okay")


class _Stuck(_Clock):
    """A world whose clock stands still, however it is moved on."""

    def advance(self, to: Time) -> None:
        return None


def _run(
    kind: type[_Clock], text: str, task: str, **told: object
) -> tuple[Interpreter, _Clock, list[Event]]:
    library = compiled(text)
    world = kind(library.library)
    for name, value in told.items():
        setattr(world, name, value)
    run = Interpreter(library, world, settings=Settings(idle_cycles=50))
    events: list[Event] = []
    run.listen(events.append)
    run.submit(read_task_request(task))
    return run, world, events


@pytest.mark.parametrize("coming", [math.nan, math.inf])
def test_a_next_time_that_is_none_is_laid_at_the_worlds_door(coming: float) -> None:
    run, _, _ = _run(_Clock, WAIT, "(wait)", coming=coming)
    with pytest.raises(PortError, match=f"the next time of the world .* is `{coming}`"):
        run.run()


@pytest.mark.parametrize(
    ("coming", "said"), [(0, "sent nothing"), (7, "did not move its clock on to 7")]
)
def test_a_clock_that_does_not_move_is_laid_at_the_worlds_door(
    coming: Time, said: str
) -> None:
    run, _, _ = _run(_Stuck, WAIT, "(wait)", coming=coming)
    with pytest.raises(PortError, match=said):
        run.run()


def test_a_clock_that_goes_back_is_laid_at_the_worlds_door() -> None:
    run, _, _ = _run(_Clock, LOOK, "(once)", takes=[-1])
    with pytest.raises(PortError, match="clock back, from 0 to -1"):
        run.run()


def test_a_clock_that_says_no_time_is_laid_at_the_worlds_door() -> None:
    run, _, _ = _run(_Clock, LOOK, "(once)", takes=[math.nan])
    with pytest.raises(PortError, match="is `nan`"):
        run.run()


def test_a_whole_time_is_an_integer_whatever_the_world_says() -> None:
    run, _, events = _run(_Clock, LOOK, "(once)", takes=[136.0])
    assert run.run() == "done"
    assert repr(run.now) == "136"
    assert isinstance(events[-1], RunEnded)
    assert repr(events[-1].time) == "136"


def test_rows_that_take_a_whole_float_leave_an_integer() -> None:
    library = compiled(LOOK)
    world = ScriptedWorld([Row(("look", "a"), takes=2.0)], (), declared=library.library)
    run = Interpreter(library, world)
    run.submit(read_task_request("(once)"))
    run.run()
    assert repr(run.now) == "2"
