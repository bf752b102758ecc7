"""Listeners: the tasks to test after a change, found by the changed fact or word.

Not here: which changes a formula listens to (`rapc.compiler.watches`), and when the
marked tasks are tested (`rapc.runtime.monitors.monitors`) [L 5].
"""

from __future__ import annotations

from rapc.base.resources import Counter, Resource, SetResource
from rapc.base.values import Atom, Fact
from rapc.compiler.watches import ANYTHING, WatchKey
from rapc.runtime.state.states import RUNNING
from rapc.runtime.state.task import Task

_Found = dict[int, Task]
_Table = dict[object, "Task | _Found"]
"""The listeners by value; a table of tasks by number only for several tasks."""


class Listeners:
    """The tasks that listen, by the watched changes; an observer of memory.

    A listener to a fact is registered under the fact's name and one argument, or under
    the name alone, as position 0. Other changes have words or resources for keys.

    Args:
        to_test: receives the tasks that listen to a change, by number.
    """

    __slots__ = ("_names", "_others", "_to_test", "changes")

    def __init__(self, to_test: _Found) -> None:
        #: How often memory, a resource or the clock has changed in this process.
        self.changes = 0
        self._to_test = to_test
        self._names: dict[Atom, dict[int, _Table]] = {}
        self._others: _Table = {}

    def clear(self) -> None:
        """Remove all listeners."""
        self._names.clear()
        self._others.clear()

    def add(self, key: WatchKey, task: Task) -> None:
        """Register a task as a listener to a change."""
        table, value = self._place(key)
        there = table.get(value)
        if there is None or there is task:
            table[value] = task
        elif isinstance(there, dict):
            there[task.number] = task
        else:
            table[value] = {there.number: there, task.number: task}

    def drop(self, key: WatchKey, task: Task) -> None:
        """Unregister `task` from `key`, if registered."""
        table, value = self._place(key)
        there = table.get(value)
        if there is task:
            del table[value]
        elif isinstance(there, dict):
            there.pop(task.number, None)
            if not there:
                del table[value]

    def _place(self, key: WatchKey) -> tuple[_Table, object]:
        if isinstance(key, Counter | SetResource) or key == ANYTHING:
            return self._others, key
        places = self._names.setdefault(key[0], {})
        if len(key) == 1:
            return places.setdefault(0, {}), key[0]
        _, at, value = key
        assert isinstance(at, int)
        return places.setdefault(at, {}), value

    def fact_changed(self, fact: Fact, how: str) -> None:
        """Mark the tasks that listen to a fact of memory to be tested."""
        self.changes += 1
        places = self._names.get(fact[0])
        if places is not None:
            size = len(fact)
            for at, table in places.items():
                if at < size:
                    there = table.get(fact[at])
                    if there is not None:
                        _join(there, self._to_test)
        if self._others:
            self._mark(self._others.get(ANYTHING))

    def other_changed(self, word: str) -> None:
        """Mark the tasks that listen to a change that concerns no fact to be tested."""
        self.changes += 1
        self._mark(self._names.get(word, {}).get(0, {}).get(word))
        self._mark(self._others.get(ANYTHING))

    def resource_changed(self, resource: Resource) -> None:
        """Mark the tasks that listen to a set or counter to be tested."""
        self.changes += 1
        self._mark(self._others.get(resource))

    def _mark(self, there: Task | _Found | None) -> None:
        if there is not None:
            _join(there, self._to_test)


def _join(there: Task | _Found, found: _Found) -> None:
    """Add listeners to `found`; leave out a single task that is RUNNING.

    The running task is tested anyway, when its method ends.
    """
    if isinstance(there, dict):
        found.update(there)
    elif there.state is not RUNNING:
        found[there.number] = there
