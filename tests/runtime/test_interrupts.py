"""A signal at any moment of a run leaves tasks that can be ended in order."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType
from typing import Any

import pytest

import rapc
from rapc.events import Event, TaskCreated, TaskFailed, TaskRemoved, TaskSucceeded
from rapc.runtime.planner import Planned, PlanRequest
from rapc.world import Kit, SimpleWorld, Time

LIBRARY = rapc.load("examples/rock-order.rap").program


def _interrupted(before: int) -> tuple[bool, list[Event]]:
    """Run with a signal before a line of rapc; return whether it came, and the events.

    Args:
        before: the number of lines of the runtime that are carried out before.
    """
    run = rapc.Interpreter(LIBRARY, rapc.open_world("truck", seed=7), 7)
    events: list[Event] = []
    run.listen(events.append)
    run.submit("(rock-order red 2)")
    left = before

    def traced(frame: FrameType, kind: str, value: Any) -> Any:
        nonlocal left
        if not frame.f_globals.get("__name__", "").startswith("rapc.runtime"):
            return None
        if kind == "line":
            left -= 1
            if left == 0 and not run.interrupt():
                raise KeyboardInterrupt
        return traced

    sys.settrace(traced)
    try:
        run.run(until=8)
    except KeyboardInterrupt:
        return True, events
    finally:
        sys.settrace(None)
        run.end("cancelled")
    return False, events


def test_interrupted_run_ends_in_order() -> None:
    """Steps of 61 lines come to all the places of a cycle."""
    moments = 0
    came, before = True, 1
    while came:
        came, events = _interrupted(before)
        made = {event.task for event in events if isinstance(event, TaskCreated)}
        ends = (TaskSucceeded, TaskFailed, TaskRemoved)
        ended = [event.task for event in events if isinstance(event, ends)]
        assert sorted(ended) == sorted(made)
        moments, before = moments + 1, before + 61
    assert moments > 60


LATE = """
(declare-memory-function look ())
(declare-memory-proposition done ())
(define-rap (go) (preconditions (= (look) 1)) (succeed (done)) (plan))
"""


class _Waiting(SimpleWorld):
    """A world that notes how long it is asked to wait."""

    def __init__(self, look: Callable[[], object]) -> None:
        kit = Kit(functions={"look": lambda memory: 1 if look() else 0})
        super().__init__(perform=lambda *_: None, kit=kit)
        self.waits: list[Time] = []

    def advance(self, to: Time) -> None:
        self.waits.append(to)
        super().advance(to)


def test_interrupt_just_before_a_wait_prevents_the_wait() -> None:
    """The host asks for a time, and interrupts the run when it comes."""
    world = _Waiting(bool)
    run = rapc.Interpreter(rapc.loads(LATE).program, world)
    run.submit("(go) :at 9")

    def interrupt() -> None:
        assert run.interrupt()

    run.call_at(3, interrupt)
    with pytest.raises(KeyboardInterrupt):
        run.run()
    assert world.waits == [3]
    assert run.run() == "done"


def test_interrupt_just_before_a_plan_prevents_the_search() -> None:
    asked: list[PlanRequest] = []

    def planner(request: PlanRequest) -> Planned:
        asked.append(request)
        return Planned("unsolvable", None, 0, 0)

    def look() -> bool:
        return run.interrupt()

    world = _Waiting(look)
    run = rapc.Interpreter(rapc.loads(LATE).program, world, planner=planner)
    run.submit("(go)")
    with pytest.raises(KeyboardInterrupt):
        run.run()
    assert not asked
    run.end("cancelled")
    assert run.reason == "cancelled"
