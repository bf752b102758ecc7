"""The agenda: the eligible tasks and the order of their selection.

The agenda prefers, in this order [T 3.2.4; L 4]: higher priority; earlier latest start;
tasks without a failed method; the family on top of the stack; chance. A sole task on
the agenda is not sorted in.
"""

from __future__ import annotations

import math
import random
from bisect import bisect_left, insort
from typing import ClassVar

from rapc.base.chance import below
from rapc.runtime.fields import LEFT_OUT, Fields, Limit
from rapc.runtime.state.task import Task

_Entry = tuple[float, float, bool, int]
"""The sort key of a task: priority, negated; latest start; failure; number."""


class Agenda:
    """The eligible tasks and the stack of families.

    Args:
        rng: the interpreter's random stream; drawn from once whenever more than one
            candidate is left.
    """

    FIELDS: ClassVar[Fields] = {
        "stack": list[tuple[int, int]],
        "last_family": int | None,
        "_focused": LEFT_OUT,
        "_only": Task | None,
        "_tasks": dict[int, tuple[Task, tuple[Limit, Limit, bool, int]]],
        "_order": LEFT_OUT,
        "_families": LEFT_OUT,
        "_rng": LEFT_OUT,
    }

    def __init__(self, rng: random.Random) -> None:
        #: Priorities and families, each of a higher priority than the one below.
        self.stack: list[tuple[int, int]] = []
        #: The priority and the family of the task that was chosen last.
        self._focused: tuple[int, int] | None = None
        self.last_family: int | None = None
        self._rng = rng
        self._only: Task | None = None
        self._tasks: dict[int, tuple[Task, _Entry]] = {}
        #: The entries of all tasks but a sole one, and those of each family, sorted.
        self._order: list[_Entry] = []
        self._families: dict[int, list[_Entry]] = {}

    def __len__(self) -> int:
        return len(self._tasks) + (self._only is not None)

    def __contains__(self, task: Task) -> bool:
        return task is self._only or task.number in self._tasks

    def add(self, task: Task) -> None:
        """Add a task that has become eligible."""
        if self._only is None and not self._tasks:
            self._only = task
            return
        if self._only is not None:
            only, self._only = self._only, None
            self._insert(only)
        self._insert(task)

    def _insert(self, task: Task) -> None:
        """Sort a task in by its current latest start and history."""
        wait, history = task.wait, task.history
        latest = task.limit if wait is None else task.limit - wait.duration
        failed = history is not None and bool(history.failures)
        entry = (-task.priority, latest, failed, task.number)
        self._tasks[task.number] = task, entry
        insort(self._order, entry)
        insort(self._families.setdefault(task.family, []), entry)

    def entries(self) -> tuple[int | None, list[tuple[int, float, bool]]]:
        """Return the number of the sole task, and the sorted entries of the others.

        Each entry has the number of a task, its latest start, and whether it had
        failed.
        """
        sole = None if self._only is None else self._only.number
        return sole, [(t.number, key[1], key[2]) for t, key in self._tasks.values()]

    def take_up(self, other: Agenda) -> None:
        """Take over the saved fields of another agenda."""
        self.stack, self.last_family = other.stack, other.last_family
        self._focused = self.stack[-1] if self.stack else None
        self._only = other._only
        self._tasks = {
            task.number: (task, (-task.priority, latest, failed, task.number))
            for task, (_, latest, failed, _) in other._tasks.values()
        }
        self._order = sorted(entry for _, entry in self._tasks.values())
        self._families = {}
        for entry in self._order:
            family = self._tasks[entry[3]][0].family
            self._families.setdefault(family, []).append(entry)

    def discard(self, task: Task) -> None:
        """Remove a task that was eligible, if the agenda contains it."""
        if task is self._only:
            self._only = None
        elif task.number in self._tasks:
            self._take_out(task.number)

    def _take_out(self, number: int) -> Task:
        task, entry = self._tasks.pop(number)
        order, family = self._order, self._families[task.family]
        del order[bisect_left(order, entry)]
        del family[bisect_left(family, entry)]
        if not family:
            del self._families[task.family]
        return task

    def choose(self) -> Task | None:
        """Take the next task off the agenda, or None if none is eligible."""
        task = self._only
        if task is not None:
            self._only = None
        elif self._order:
            task = self._pick()
        else:
            return None
        if self._focused != (task.priority, task.family):
            self._focus(task)
        return task

    def _pick(self) -> Task:
        """Return the next of several tasks."""
        entries = self._order
        priority, latest, failed, number = entries[0]
        behind = (priority, latest, failed, math.inf)
        size = bisect_left(entries, behind)
        if size == 1:
            return self._take_out(number)
        stack = self.stack
        while stack and stack[-1][0] > -priority:
            stack.pop()  # nothing of this family is eligible at or above its priority
        if stack:
            family = self._families.get(stack[-1][1], [])
            same = bisect_left(family, behind)
            if same:
                entries, size = family, same
        at = below(self._rng, size) if size > 1 else 0
        return self._take_out(entries[at][3])

    def _focus(self, task: Task) -> None:
        stack, priority = self.stack, task.priority
        while stack and stack[-1][0] >= priority:
            stack.pop()
        self._focused = priority, task.family
        stack.append(self._focused)
