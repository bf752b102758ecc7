"""Times of tasks: starts, monitors and deadlines.

One heap holds the times that tasks wait for, another heap holds the deadlines that they
state. Not here: the effect of a deadline on the order of choice
(`rapc.runtime.state.agenda`).
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterable

from rapc.runtime.state.task import Task
from rapc.world import Time

_CROWD = 256
"""The size of a heap above which stale entries are removed."""


class Times:
    """Times that tasks state, a heap by time and then by task number.

    An entry that its task does not state any more stays in the heap until its time
    comes, or until there are too many stale entries.

    Args:
        stated: returns the time that a task states now, or None.
    """

    __slots__ = ("_crowded", "_set", "_stated", "heap")

    def __init__(self, stated: Callable[[Task], float | None]) -> None:
        #: The entries; the first may be stale.
        self.heap: list[tuple[float, int, Task]] = []
        self._stated = stated
        self._set: set[tuple[float, int]] = set()
        self._crowded = _CROWD

    def add(self, time: float, task: Task) -> None:
        """Record that `task` states `time`."""
        if (time, task.number) not in self._set:
            self._set.add((time, task.number))
            heapq.heappush(self.heap, (time, task.number, task))
            if len(self.heap) > self._crowded:
                self.load([entry[2] for entry in self.heap])

    def load(self, tasks: Iterable[Task]) -> None:
        """Replace all entries by the times that `tasks` state."""
        found = {task: self._stated(task) for task in tasks}
        self.heap = [
            (time, task.number, task)
            for task, time in found.items()
            if time is not None
        ]
        self._set = {entry[:2] for entry in self.heap}
        heapq.heapify(self.heap)
        self._crowded = max(_CROWD, 2 * len(self.heap))

    def soonest(self) -> float | None:
        """Return the soonest time that a task states, or None."""
        while self.heap and self._stated(self.heap[0][2]) != self.heap[0][0]:
            self._pop()
        return self.heap[0][0] if self.heap else None

    def due(self, now: Time, *, passed: bool = False) -> list[Task]:
        """Remove and return, in order, the tasks whose time has come, or `passed`."""
        found = []
        while self.heap and (
            self.heap[0][0] < now or (self.heap[0][0] == now and not passed)
        ):
            stated = self._stated(self.heap[0][2]) == self.heap[0][0]
            task = self._pop()
            if stated:
                found.append(task)
        return found

    def _pop(self) -> Task:
        time, number, task = heapq.heappop(self.heap)
        self._set.discard((time, number))
        return task


def timer_of(task: Task) -> Time | None:
    """Return the time that a task waits for."""
    return None if task.wait is None else task.wait.timer


def deadline_of(task: Task) -> float | None:
    """Return the deadline that a live task states itself, unless missed."""
    wait = task.wait
    if wait is None or not task.live or wait.deadline in (math.inf, wait.missed):
        return None
    return wait.deadline
