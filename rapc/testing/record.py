"""What happened in a run, kept so that expectations can be judged by it.

A record listens to the events of one run. It knows nothing of what is expected.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from io import StringIO
from typing import Any

import msgspec

from rapc.base.values import Fact, format_atom
from rapc.ir.nodes import Goal
from rapc.runtime.events import events
from rapc.runtime.events.trace import TextTrace
from rapc.testing.patterns import goal_matches, read_value, split_goal
from rapc.world import Time

_LAST_CYCLES = 5
_LAST_LINES = 40


class TaskRecord:
    """What is known of a task: its goal as last told, and what has become of it.

    `selected` is the serial number of its first selection; `ended` how it ended:
    `succeeded`, `failed` or `removed`, None while it is live; `result` what its parent
    sees of a failure, `reason` why it failed or was removed; `time` is that of its end.
    """

    def __init__(self, number: int, text: str) -> None:
        self.number = number
        self.selected: int | None = None
        self.ended: str | None = None
        self.result = ""
        self.reason = ""
        self.time: Time = 0
        self.waits = ""
        self.told(text)

    def told(self, text: str) -> None:
        """The goal as an event prints it: the more is bound the later it is."""
        self.text = text
        self.inputs, self.outputs = split_goal(read_value(text))

    def end(self, how: str, event: events.Event, reason: str = "") -> None:
        """The task is over."""
        self.ended, self.time, self.reason = how, event.time, reason

    def state(self) -> str:
        """What has become of the task, in words."""
        at = f" at time {format_atom(self.time)}"
        if self.ended == "failed":
            return f"failed{at} ({self.reason}) - {self.result}"
        if self.ended == "removed":
            return f"was removed{at} ({self.reason})"
        if self.ended is not None:
            return f"{self.ended}{at}"
        return f"waits for {self.waits}" if self.waits else "is active"


class Record:
    """The events of a run and what follows from them: tasks, requests, facts."""

    def __init__(self) -> None:
        self.events: list[events.Event] = []
        self.tasks: dict[int, TaskRecord] = {}
        self.requests: list[tuple[Fact, events.PrimitiveRequested]] = []
        self.facts: dict[str, None] = {}

    def __call__(self, event: events.Event) -> None:
        """Take one event in."""
        self.events.append(event)
        number = getattr(event, "task", None)
        task = self.tasks.get(number) if number is not None else None
        if task is not None:
            self._follow(task, event)
        elif isinstance(event, events.TaskCreated):
            self.tasks[event.task] = TaskRecord(event.task, event.goal)
        elif isinstance(event, events.FactAsserted):
            self.facts[event.fact] = None
        elif isinstance(event, events.FactErased):
            self.facts.pop(event.fact, None)

    def _follow(self, task: TaskRecord, event: events.Event) -> None:
        match event:
            case events.TaskSelected():
                task.told(event.goal)
                task.waits = ""
                if task.selected is None:
                    task.selected = event.n
            case events.TaskBlocked():
                task.waits = event.on
            case events.TaskWoken():
                task.waits = ""
            case events.TaskSucceeded():
                task.told(event.goal)
                task.end("succeeded", event)
            case events.TaskFailed():
                task.told(event.goal)
                task.end("failed", event, event.reason)
                task.result = event.result
            case events.TaskRemoved():
                task.end("removed", event, event.cause)
            case events.PrimitiveRequested():
                request, _ = split_goal(read_value(event.request))
                self.requests.append((request, event))
            case _:
                pass

    def refresh(self, goals: Mapping[int, str]) -> None:
        """The goals of live tasks as they are now: inputs may have been bound."""
        for number, text in goals.items():
            self.tasks[number].told(text)

    def matching(self, goal: Goal) -> list[TaskRecord]:
        """The tasks made so far, at any level, that a goal means."""
        return [t for t in self.tasks.values() if goal_matches(goal, t.inputs)]

    def about(self, predicate: str) -> list[str]:
        """The facts of a name that are in memory now."""
        starts = (f"({predicate} ", f"({predicate})")
        return [fact for fact in self.facts if fact.startswith(starts)]

    def of_kind(self, name: str) -> list[tuple[int, dict[str, Any]]]:
        """The events of a name with their serial numbers, as plain data."""
        return [
            (event.n, msgspec.to_builtins(event))
            for event in self.events
            if event.__struct_config__.tag == name
        ]

    def last_lines(self, count: int) -> Iterator[str]:
        """The last cycles among the first `count` events, as a person reads them."""
        told = self.events[:count]
        first = (told[-1].cycle if told else 0) - _LAST_CYCLES
        stream = StringIO()
        trace = TextTrace(stream)
        for event in told:
            if event.cycle > first:
                trace(event)
        yield from stream.getvalue().splitlines()[-_LAST_LINES:]
