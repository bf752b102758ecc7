"""Record of a run, for the evaluation of expectations.

A record listens to the events of one run. It does not depend on expectations.
"""

from __future__ import annotations

from collections.abc import Mapping

from rapc import events
from rapc.base.values import Fact, format_list, readable
from rapc.ir import nodes
from rapc.runtime.events.report import MendedFailures
from rapc.runtime.events.trace import text_lines
from rapc.testing.patterns import goal_matches
from rapc.world import Time

_LAST_CYCLES = 5
_LAST_LINES = 40


Asked = events.PrimitiveRequested | events.SkillEnabled


class TaskStory:
    """State of a task: its goal in the latest event, and its end.

    `selected` is the serial number of its first selection. `ended` is `succeeded`,
    `failed` or `removed`, or None while the task is live. `result` is the failure as
    the parent sees it, `reason` why the task failed or was removed, `because` the
    detailed cause of the failure; `time` is the time of the end.
    """

    def __init__(self, number: int, goal: events.Goal) -> None:
        self.number = number
        self.selected: int | None = None
        self.ended: str | None = None
        self.result = ""
        self.reason = ""
        self.because: events.Cause | None = None
        self.time: Time = 0
        self.waits = ""
        self.update(goal)

    def update(self, goal: events.Goal) -> None:
        """Update the goal from an event; later events have more variables bound."""
        self.text = str(goal)
        self.inputs: Fact = (goal.name, *goal.inputs)
        self.outputs: Fact = goal.outputs

    def end(self, how: str, event: events.Event, reason: str = "") -> None:
        """Record how the task ended, at the time of `event`, and why."""
        self.ended, self.time, self.reason = how, event.time, reason

    def state(self) -> str:
        """Return the state of the task as text."""
        at = f" at time {readable(self.time)}"
        if self.ended == "failed":
            return f"failed{at} ({self.reason}) - {self.result}"
        if self.ended == "removed":
            return f"was removed{at} ({self.reason})"
        if self.ended is not None:
            return f"{self.ended}{at}"
        return f"waits for {self.waits}" if self.waits else "is active"


class Record:
    """The events of a run, with the tasks, requests and facts in these events."""

    def __init__(self) -> None:
        self.events: list[events.Event] = []
        self.tasks: dict[int, TaskStory] = {}
        #: All requests to the world, and skills that were enabled.
        self.requests: list[tuple[Fact, Asked]] = []
        self.facts: dict[Fact, None] = {}
        self.mended = MendedFailures()

    def __call__(self, event: events.Event) -> None:
        """Process one event."""
        self.events.append(event)
        self.mended(event)
        number = getattr(event, "task", None)
        task = self.tasks.get(number) if number is not None else None
        if task is not None:
            self._follow(task, event)
        elif isinstance(event, events.TaskCreated):
            self.tasks[event.task] = TaskStory(event.task, event.goal)
        elif isinstance(event, events.FactAsserted):
            self.facts[event.fact] = None
        elif isinstance(event, events.FactErased):
            self.facts.pop(event.fact, None)

    def _follow(self, task: TaskStory, event: events.Event) -> None:
        match event:
            case events.TaskSelected():
                task.update(event.goal)
                task.waits = ""
                if task.selected is None:
                    task.selected = event.n
            case events.TaskBlocked():
                task.waits = event.on
            case events.MethodSuspended():
                task.waits = event.for_
            case events.TaskWoken():
                task.waits = ""
            case events.TaskSucceeded():
                task.update(event.goal)
                task.end("succeeded", event)
            case events.TaskFailed():
                task.update(event.goal)
                task.end("failed", event, event.reason)
                task.result = event.result
                task.because = event.because
            case events.TaskRemoved():
                task.end("removed", event, event.cause)
            case events.PrimitiveRequested():
                self.requests.append((event.request, event))
            case events.SkillEnabled():
                self.requests.append((event.what, event))
            case _:
                pass

    def refresh(self, goals: Mapping[int, events.Goal]) -> None:
        """Update the goals of live tasks: inputs may have been bound."""
        for number, goal in goals.items():
            self.tasks[number].update(goal)

    def matching(self, goal: nodes.Goal) -> list[TaskStory]:
        """Return the tasks so far, at any level, that match a goal."""
        return [t for t in self.tasks.values() if goal_matches(goal, t.inputs)]

    def about(self, predicate: str) -> list[str]:
        """Return the facts with a name that are in memory now, as text."""
        return [format_list(fact) for fact in self.facts if fact[0] == predicate]

    def of_kind(self, name: str) -> list[events.Event]:
        """Return the events with a name."""
        return [e for e in self.events if e.__struct_config__.tag == name]

    def last_lines(self, count: int) -> list[str]:
        """Return the last cycles among the first `count` events, for people."""
        told = self.events[:count]
        first = (told[-1].cycle if told else 0) - _LAST_CYCLES
        lines = text_lines(event for event in told if event.cycle > first)
        return lines[-_LAST_LINES:]
