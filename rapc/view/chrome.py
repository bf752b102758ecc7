"""A run as a Chrome trace: the JSON form that Perfetto and `chrome://tracing` open.

Each family of tasks is a process. Its tasks and methods are asynchronous slices, its
requests and skills complete slices, in as many threads as overlap. A time unit of the
run is a second.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

Json = Mapping[str, Any]

_UNIT = 1_000_000
"""The microseconds in a time unit."""

_ENDS = {
    "task-succeeded": "succeeded",
    "task-failed": "failed",
    "task-removed": "removed",
}
_METHOD_ENDS = ("method-ended", "method-suspended")
_REQUEST_ENDS = ("primitive-ended", "primitive-cancelled", "request-refused")
_INSTANTS = ("signal", "data-received", "deadlock", "deadline-missed", "query-faulted")
_RUN = 0
"""The process of events without a task."""


def chrome_trace(records: Iterable[Json]) -> dict[str, Any]:
    """Return the Chrome trace of the events of a run, each as in its trace."""
    made = _Trace()
    for one in records:
        made.add(one)
    made.close()
    names = [
        _metadata("process_name", pid, 0, name) for pid, name in made.processes.items()
    ]
    names += [
        _metadata("thread_name", pid, lane, f"requests {lane}")
        for pid, lanes in made.lanes.items()
        for lane in range(1, len(lanes) + 1)
    ]
    return {"traceEvents": [*names, *made.entries], "displayTimeUnit": "ms"}


class _Trace:
    """The entries of a Chrome trace so far."""

    def __init__(self) -> None:
        self.entries: list[dict[str, Any]] = []
        self.processes = {_RUN: "run"}
        #: For each process the lanes of its requests: whether each is in use.
        self.lanes: dict[int, list[bool]] = {}
        #: The family and goal of each live task, and its method under way.
        self._tasks: dict[int, tuple[int, str]] = {}
        self._methods: dict[int, str] = {}
        #: The slices that have begun: the entry of a request or skill.
        self._open: list[dict[str, Any]] = []
        self._now = 0.0

    def add(self, one: Json) -> None:
        kind: str = one["event"]
        task: Any = one.get("task")
        self._now = one["time"] * _UNIT
        if kind == "task-created":
            self._create(one)
        elif kind == "method-chosen":
            self._methods[task] = one["method"]
            self._asynchronous("b", task, one["method"], {"bindings": one["bindings"]})
        elif kind in _METHOD_ENDS:
            self._end_method(task, one.get("result", "suspended"))
        elif kind in _ENDS:
            self._end(one, task)
        elif kind == "primitive-requested":
            self._begin(one["request"], task, "request", {"sent": one["sent"]})
        elif kind in _REQUEST_ENDS:
            given = {"result": one.get("result", kind.rpartition("-")[2])}
            self._finish(one["request"], task, given)
        elif kind == "skill-enabled":
            self._begin(one["what"], task, "skill", {})
        elif kind == "skill-disabled":
            self._finish(one["what"], task, {})
        elif kind in _INSTANTS:
            self._instant(one, task)
        elif kind == "run-ended":
            self._instant({**one, "what": f"run ended: {one['reason']}"}, None)

    def close(self) -> None:
        """End what has not ended: the trace was cut off."""
        for one in self._open:
            one["dur"] = self._now - one["ts"]
        for task in [*self._tasks]:
            self._end_method(task, "unfinished")
            self._end({"event": "unfinished"}, task)

    def _create(self, one: Json) -> None:
        task, family, goal = one["task"], one["family"], one["goal"]
        self._tasks[task] = family, goal
        if one["parent"] is None:
            self.processes[family] = f"[{task}] {goal}"
        given = {key: one[key] for key in ("parent", "step", "priority")}
        self._asynchronous("b", task, goal, {"task": task, **given})

    def _end(self, one: Json, task: int) -> None:
        self._end_method(task, "unfinished")
        outcome = _ENDS.get(one["event"], one["event"])
        given = {"outcome": outcome, "result": one.get("result", one.get("cause"))}
        if task in self._tasks:
            self._asynchronous("e", task, self._tasks[task][1], given)
            del self._tasks[task]

    def _end_method(self, task: int, result: str) -> None:
        if task in self._methods:
            method = self._methods.pop(task)
            self._asynchronous("e", task, method, {"result": result})

    def _asynchronous(self, phase: str, task: int, name: str, args: Json) -> None:
        family = self._tasks.get(task, (_RUN, ""))[0]
        self.entries.append(
            {
                "ph": phase,
                "cat": "task",
                "name": name,
                "id": str(task),
                "ts": self._now,
                "pid": family,
                "tid": 0,
                "args": dict(args),
            }
        )

    def _begin(self, name: str, task: int, kind: str, args: Json) -> None:
        family = self._tasks.get(task, (_RUN, ""))[0]
        lanes = self.lanes.setdefault(family, [])
        lane = lanes.index(False) if False in lanes else len(lanes)
        lanes[lane : lane + 1] = [True]
        entry = {
            "ph": "X",
            "cat": kind,
            "name": name,
            "ts": self._now,
            "dur": 0,
            "pid": family,
            "tid": lane + 1,
            "args": {"task": task, **args},
        }
        self._open.append(entry)
        self.entries.append(entry)

    def _finish(self, name: str, task: int | None, args: Json) -> None:
        """End the oldest slice of a name; that of the task, if the task is known."""
        same = [one for one in self._open if one["name"] == name]
        own = [one for one in same if one["args"]["task"] == task]
        for one in (own or same)[:1]:
            one["dur"] = self._now - one["ts"]
            one["args"].update(args)
            self.lanes[one["pid"]][one["tid"] - 1] = False
            self._open.remove(one)

    def _instant(self, one: Json, task: int | None) -> None:
        what = one.get("what", one.get("data", one.get("deadline", "")))
        family = self._tasks.get(task or 0, (_RUN, ""))[0]
        self.entries.append(
            {
                "ph": "i",
                "s": "p",
                "cat": one["event"],
                "name": f"{one['event']} {what}".strip(),
                "ts": self._now,
                "pid": family,
                "tid": 0,
            }
        )


def _metadata(kind: str, pid: int, tid: int, name: str) -> dict[str, Any]:
    return {"ph": "M", "name": kind, "pid": pid, "tid": tid, "args": {"name": name}}
