"""Why tasks failed: the cause that was told then, down to the first one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from rapc import events
from rapc.debug.history import History
from rapc.debug.log import ToldEvent
from rapc.errors import ArgumentError
from rapc.events import Cause
from rapc.world import Time


class TaskFailure(msgspec.Struct, frozen=True):
    """How a task or its last method failed."""

    task: int
    goal: str
    cycle: int
    time: Time
    #: `failed`, `method ended`, or `removed`.
    what: str
    result: str
    because: Cause | None


def why_failed(history: History, number: int | None = None) -> TaskFailure:
    """Return why a task failed, or the last one that did.

    Raises:
        ArgumentError: if none has, or this one has not.
    """
    known = history.run.machine.state.numbers

    def wanted(told: ToldEvent) -> bool:
        if told.kind is events.TaskFailed:
            return number is None or told.keys["task"] == number
        if told.keys["task"] != number:
            return False
        return told.kind is events.TaskRemoved or told.keys["result"] != "okay"

    kinds = (events.TaskFailed, events.MethodEnded, events.TaskRemoved)
    told = history.last(*kinds, want=wanted)
    if told is None:
        if number is None:
            raise ArgumentError("no task has failed")
        if not 0 < number <= known:
            raise ArgumentError(f"there is no task [{number}]")
        raise ArgumentError(
            f"task [{number}] has not failed, and no method of it has ended badly"
        )
    keys = told.keys
    what = {events.TaskFailed: "failed", events.MethodEnded: "method ended"}.get(
        told.kind, "removed"
    )
    result = keys.get("result") or keys.get("cause", "")
    return TaskFailure(
        keys["task"],
        _goal(history, keys),
        told.cycle,
        told.time,
        what,
        result,
        keys.get("because"),
    )


def _goal(history: History, keys: Mapping[str, Any]) -> str:
    if "goal" in keys:
        return str(keys["goal"])
    made = history.last(
        events.TaskCreated, want=lambda told: told.keys["task"] == keys["task"]
    )
    return "" if made is None else str(made.keys["goal"])
