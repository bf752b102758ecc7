"""The agenda: the tasks that may run now, and which of them runs next.

Order of choice [T 3.2.4; L 4]: higher priority; earlier latest start; tasks
none of whose methods has ended badly; the family on top of the stack; chance. A task
that is alone on the agenda is neither sorted nor grouped.
"""

from __future__ import annotations

import random
from bisect import bisect_left, insort
from collections.abc import Iterable

from rapc.base.chance import below
from rapc.runtime.state.task import Task

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
        self._only: Task | None = None
        self._tasks: dict[int, tuple[Task, _Key]] = {}
        self._groups: dict[_Key, _Group] = {}
        self._keys: list[_Key] = []

    def __len__(self) -> int:
        return len(self._tasks) + (self._only is not None)

    def __contains__(self, task: Task) -> bool:
        return task is self._only or task.number in self._tasks

    def add(self, task: Task) -> None:
        """Add a task that has become eligible."""
        only = self._only
        if only is not None:
            self._only = None
            self._insert(only)
        elif not self._tasks:
            # fast twin of sorting it in: holds while it is alone
            self._only = task
            return
        self._insert(task)

    def _insert(self, task: Task) -> None:
        wait = task.wait
        latest = task.limit if wait is None else task.limit - wait.duration
        self._place(task, (-task.priority, latest, task.failed))

    def _place(self, task: Task, key: _Key) -> None:
        group = self._groups.get(key)
        if group is None:
            group = self._groups[key] = _Group()
            insort(self._keys, key)
        group.add(task)
        self._tasks[task.number] = task, key

    def entries(self) -> tuple[int | None, list[tuple[int, float, bool]]]:
        """Return the number of the sole task, and the others as they are sorted in.

        Each of these has its number, its latest start, and whether it had failed.
        """
        sole = None if self._only is None else self._only.number
        return sole, [(n, key[1], key[2]) for n, (_, key) in self._tasks.items()]

    def load(
        self, sole: Task | None, others: Iterable[tuple[Task, float, bool]]
    ) -> None:
        """Hold these tasks and no others, as `entries` told of them."""
        self._only = sole
        self._tasks, self._groups, self._keys = {}, {}, []
        for task, latest, failed in others:
            self._place(task, (-task.priority, latest, failed))

    def discard(self, task: Task) -> None:
        """Remove a task that was eligible; others are left alone."""
        if task is self._only:
            self._only = None
        elif task.number in self._tasks:
            self._take_out(task.number)

    def _take_out(self, number: int) -> Task:
        task, key = self._tasks.pop(number)
        group = self._groups[key]
        group.discard(task)
        if not group.numbers:
            del self._groups[key]
            del self._keys[bisect_left(self._keys, key)]
        return task

    def choose(self) -> Task | None:
        """Take the next task off the agenda, or None if none is eligible."""
        task = self._only
        if task is not None:
            self._only = None
        elif self._keys:
            task = self._pick()
        else:
            return None
        stack = self.stack
        if not stack or stack[-1] != (task.priority, task.family):
            self._focus(task)
        return task

    def _pick(self) -> Task:
        """The next of several."""
        key = self._keys[0]
        group = self._groups[key]
        numbers = group.numbers
        if len(numbers) == 1:
            del self._groups[key]
            del self._keys[0]
            return self._tasks.pop(numbers[0])[0]
        self._drop_above(-int(key[0]))
        if self.stack:
            numbers = group.families.get(self.stack[-1][1], numbers)
        at = below(self._rng, len(numbers)) if len(numbers) > 1 else 0
        return self._take_out(numbers[at])

    def _drop_above(self, priority: int) -> None:
        """Pop what has nothing eligible at or above its priority."""
        stack = self.stack
        while stack and stack[-1][0] > priority:
            stack.pop()

    def _focus(self, task: Task) -> None:
        stack, priority = self.stack, task.priority
        while stack and stack[-1][0] >= priority:
            stack.pop()
        stack.append((priority, task.family))


class SortingAgenda(Agenda):
    """An agenda that sorts in a task that is alone, too."""

    def add(self, task: Task) -> None:
        """Add a task that has become eligible."""
        self._insert(task)
