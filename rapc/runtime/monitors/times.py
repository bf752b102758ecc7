"""The times at which tasks are to be looked at: for a start, a monitor or a deadline.

One kind of heap holds the times that tasks wait for, and another of the same kind the
deadlines that they state. What a deadline does to the order of choice is in
`rapc.runtime.state.agenda`.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterable

from rapc.runtime.state.task import Task
from rapc.world import Time

_CROWD = 256
"""How many entries a heap may have before stale ones are looked for."""


class Times:
    """Times that tasks state, a heap by time and then by task number.

    A time that its task does not state any more stays in the heap until it comes, or
    until there are too many of these.

    Args:
        stated: returns the time that a task states now, or None.
    """

    __slots__ = ("_crowded", "_set", "_stated", "heap")

    def __init__(self, stated: Callable[[Task], float | None]) -> None:
        #: The entries; the first may be one that its task states no more.
        self.heap: list[tuple[float, int, Task]] = []
        self._stated = stated
        self._set: set[tuple[float, int]] = set()
        self._crowded = _CROWD

    def add(self, time: float, task: Task) -> None:
        """Note that `task` states `time`."""
        if (time, task.number) not in self._set:
            self._set.add((time, task.number))
            heapq.heappush(self.heap, (time, task.number, task))
            if len(self.heap) > self._crowded:
                self.load([entry[2] for entry in self.heap])

    def load(self, tasks: Iterable[Task]) -> None:
        """Hold the times that `tasks` state, and no others."""
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
        """Take out and return, in order, the tasks whose time has come, or `passed`."""
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
    """Return the deadline that a live task states itself and that was not missed."""
    wait = task.wait
    if wait is None or not task.live or wait.deadline in (math.inf, wait.missed):
        return None
    return wait.deadline
