"""The agenda: the tasks that may run now, and which of them runs next.

Order of choice (T 3.2.4, semantics 4): higher priority; earlier latest start; tasks
none of whose methods has ended badly; the family on top of the stack; chance.
"""

from __future__ import annotations

import random
from bisect import bisect_left, insort

from rapc.runtime.task import Task

_Key = tuple[float, float, bool]


class _Group:
    """The eligible tasks that priority, latest start and failure do not tell apart."""

    __slots__ = ("families", "numbers")

    def __init__(self) -> None:
        self.numbers: list[int] = []
        self.families: dict[int, list[int]] = {}

    def add(self, task: Task) -> None:
        insort(self.numbers, task.number)
        insort(self.families.setdefault(task.family, []), task.number)

    def discard(self, task: Task) -> None:
        del self.numbers[bisect_left(self.numbers, task.number)]
        family = self.families[task.family]
        del family[bisect_left(family, task.number)]
        if not family:
            del self.families[task.family]


class Agenda:
    """The eligible tasks and the stack of families.

    Args:
        rng: the interpreter's random stream; drawn from once whenever more than one
            candidate is left.
    """

    def __init__(self, rng: random.Random) -> None:
        self.stack: list[tuple[int, int]] = []
        self.last_family: int | None = None
        self._rng = rng
        self._tasks: dict[int, Task] = {}
        self._groups: dict[_Key, _Group] = {}
        self._keys: list[_Key] = []

    def __len__(self) -> int:
        return len(self._tasks)

    def __contains__(self, task: Task) -> bool:
        return task.number in self._tasks

    def add(self, task: Task) -> None:
        """A task has become eligible."""
        task.key = (-task.priority, task.limit - task.duration, task.failed)
        group = self._groups.get(task.key)
        if group is None:
            group = self._groups[task.key] = _Group()
            insort(self._keys, task.key)
        group.add(task)
        self._tasks[task.number] = task

    def discard(self, task: Task) -> None:
        """A task that was eligible no longer is; others are left alone."""
        if self._tasks.pop(task.number, None) is None:
            return
        group = self._groups[task.key]
        group.discard(task)
        if not group.numbers:
            del self._groups[task.key]
            del self._keys[bisect_left(self._keys, task.key)]

    def choose(self) -> Task | None:
        """Take the next task off the agenda, or None if none is eligible."""
        if not self._keys:
            return None
        key = self._keys[0]
        priority = -int(key[0])
        stack = self.stack
        while stack and stack[-1][0] > priority:
            stack.pop()
        group = self._groups[key]
        numbers = group.numbers
        if stack:
            numbers = group.families.get(stack[-1][1], numbers)
        at = self._rng.randrange(len(numbers)) if len(numbers) > 1 else 0
        task = self._tasks[numbers[at]]
        self.discard(task)
        self._focus(task)
        return task

    def _focus(self, task: Task) -> None:
        stack = self.stack
        if not stack or task.priority > stack[-1][0]:
            stack.append((task.priority, task.family))
        elif stack[-1][1] != task.family:
            stack[-1] = (task.priority, task.family)
