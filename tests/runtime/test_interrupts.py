"""A signal at any moment of a run leaves tasks that can be ended in order."""

from __future__ import annotations

import sys
from types import FrameType
from typing import Any

import rapc
from rapc.events import Event, TaskCreated, TaskFailed, TaskRemoved, TaskSucceeded

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
