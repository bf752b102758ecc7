"""Timers: the times at which tasks are to be looked at again, soonest first.

A task waits for one time at once, `WaitState.timer`; a time that it does not wait for
any more stays in the heap until it comes, or until there are too many of these.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable

from rapc.runtime.state.task import Task
from rapc.world import Time

CROWD = 256
"""How many entries a heap may have before stale ones are looked for."""


class Timers:
    """The times that tasks wait for, a heap by time and then by task number."""

    __slots__ = ("_crowded", "_set", "heap")

    def __init__(self) -> None:
        #: The entries; the first may be one that nobody waits for any more.
        self.heap: list[tuple[Time, int, Task]] = []
        self._set: set[tuple[Time, int]] = set()
        self._crowded = CROWD

    def set(self, time: Time, task: Task) -> None:
        """Let `task` wait for `time`, and for no other."""
        assert task.wait is not None
        task.wait.timer = time
        if (time, task.number) not in self._set:
            self._set.add((time, task.number))
            heapq.heappush(self.heap, (time, task.number, task))
            if len(self.heap) > self._crowded:
                self.load([entry[2] for entry in self.heap if _awaited(entry)])

    def load(self, tasks: Iterable[Task]) -> None:
        """Take the times that `tasks` wait for, and no others."""
        self.heap = [
            (task.wait.timer, task.number, task)
            for task in tasks
            if task.wait is not None and task.wait.timer is not None
        ]
        self._set = {entry[:2] for entry in self.heap}
        heapq.heapify(self.heap)
        self._crowded = max(CROWD, 2 * len(self.heap))

    def next_time(self) -> Time | None:
        """Return the soonest time that a task waits for, or None."""
        while self.heap and not _awaited(self.heap[0]):
            self._pop()
        return self.heap[0][0] if self.heap else None

    def due(self, now: Time) -> list[Task]:
        """Take out and return the tasks whose time has come, in order."""
        found = []
        while self.heap and self.heap[0][0] <= now:
            awaited = _awaited(self.heap[0])
            task = self._pop()
            if awaited and task.wait is not None:
                task.wait.timer = None
                found.append(task)
        return found

    def _pop(self) -> Task:
        time, number, task = heapq.heappop(self.heap)
        self._set.discard((time, number))
        return task


def _awaited(entry: tuple[Time, int, Task]) -> bool:
    """Whether a task still waits for the time of an entry."""
    return entry[2].wait is not None and entry[2].wait.timer == entry[0]
