"""Deadlines: those that tasks state themselves, soonest first, and which were missed.

A deadline is missed once the clock has passed it; that is told once for each. What a
deadline does to the order of choice is in `rapc.runtime.state.agenda`.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable

from rapc.runtime.monitors.timers import CROWD
from rapc.runtime.state.task import Task
from rapc.world import Time


class Deadlines:
    """The deadlines stated by tasks, a heap by time and then by task number."""

    __slots__ = ("_crowded", "_set", "heap", "missed")

    def __init__(self) -> None:
        #: The entries; a task may meanwhile state another deadline, or have ended.
        self.heap: list[tuple[float, int, Task]] = []
        #: Deadlines that were missed and not yet told of, by task number.
        self.missed: dict[int, list[float]] = {}
        self._set: set[tuple[float, int]] = set()
        self._crowded = CROWD

    def state(self, task: Task) -> float:
        """Take up the deadline that `task` states now; return it."""
        deadline = stated(task)
        inherited = task.parent.limit if task.parent is not None else math.inf
        task.limit = min(inherited, deadline)
        if deadline < math.inf and (deadline, task.number) not in self._set:
            self._set.add((deadline, task.number))
            heapq.heappush(self.heap, (deadline, task.number, task))
            if len(self.heap) > self._crowded:
                self.load([task for _, _, task in self.heap if task.live])
        return deadline

    def load(self, tasks: Iterable[Task]) -> None:
        """Take the deadlines that `tasks` state, and no others."""
        waits = {task: task.wait for task in tasks if task.wait is not None}
        self.heap = [
            (wait.deadline, task.number, task)
            for task, wait in waits.items()
            if wait.deadline < math.inf and wait.deadline != wait.missed
        ]
        self._set = {entry[:2] for entry in self.heap}
        heapq.heapify(self.heap)
        self._crowded = max(CROWD, 2 * len(self.heap))

    def look(self, now: Time) -> bool:
        """Note which live tasks have missed a deadline by `now`; whether any has."""
        found = False
        while self.heap and self.heap[0][0] < now:
            deadline, number, task = heapq.heappop(self.heap)
            self._set.discard((deadline, number))
            found = (task.live and self.note(task, now)) or found
        return found

    def note(self, task: Task, now: Time) -> bool:
        """Note that the clock has passed the deadline of `task`, once for each.

        Whether it has, and this was not noted before.
        """
        wait, deadline = task.wait, stated(task)
        if wait is None or deadline >= now or deadline == wait.missed:
            return False
        wait.missed = deadline
        self.missed.setdefault(task.number, []).append(deadline)
        return True

    def take_missed(self) -> dict[int, list[float]]:
        """Return what was missed, by task number; it counts as told from now on."""
        missed, self.missed = self.missed, {}
        return missed


def stated(task: Task) -> float:
    """Return the deadline that `task` states itself, infinite without one."""
    return math.inf if task.wait is None else task.wait.deadline
