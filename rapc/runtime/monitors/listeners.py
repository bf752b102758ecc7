"""Who listens to which change, found from what has changed without looking at others.

What a formula listens to is said by `rapc.compiler.watches`; when its task is
tested is for `rapc.runtime.monitors.monitors` to say [L 5].
"""

from __future__ import annotations

from rapc.base.resources import Counter, SetResource
from rapc.base.values import Atom, Fact
from rapc.compiler.watches import ANYTHING, WatchKey
from rapc.runtime.state.states import RUNNING
from rapc.runtime.state.task import Task

_Found = dict[int, Task]
_Table = dict[object, "Task | _Found"]
"""Who listens, by a value; a table of tasks by number only where they are several."""


class Listeners:
    """The tasks that listen, by what they listen to.

    A listener to a fact stands under its name and one argument, or under its name
    alone, as position 0; other changes have words or resources for keys.
    """

    __slots__ = ("_names", "_others")

    def __init__(self) -> None:
        self._names: dict[Atom, dict[int, _Table]] = {}
        self._others: _Table = {}

    def add(self, key: WatchKey, task: Task) -> None:
        """A task listens to a change from now on."""
        table, value = self._place(key)
        there = table.get(value)
        if there is None or there is task:
            table[value] = task
        elif isinstance(there, dict):
            there[task.number] = task
        else:
            table[value] = {there.number: there, task.number: task}

    def drop(self, key: WatchKey, task: Task) -> None:
        """Unregister `task` from `key`; do nothing if it was not registered."""
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
            return places.setdefault(0, {}), None
        _, at, value = key
        assert isinstance(at, int)
        return places.setdefault(at, {}), value

    def of_fact(self, fact: Fact, found: _Found) -> None:
        """Add to `found` the tasks registered for `fact`, which has changed."""
        places = self._names.get(fact[0])
        if places is not None:
            size = len(fact)
            for at, table in places.items():
                if at < size:
                    there = table.get(fact[at] if at else None)
                    if there is not None:
                        _join(there, found)
        if self._others:
            self.of(ANYTHING, found)

    def of_word(self, word: str, found: _Found) -> None:
        """Add to `found` the tasks registered for the change named `word`, no fact."""
        there = self._names.get(word, {}).get(0, {}).get(None)
        if there is not None:
            _join(there, found)
        self.of(ANYTHING, found)

    def of(self, key: WatchKey, found: _Found) -> None:
        """Add to `found` the tasks registered for a resource, or for any change."""
        there = self._others.get(key)
        if there is not None:
            _join(there, found)


def _join(there: Task | _Found, found: _Found) -> None:
    """Add listeners to `found`; leave out a single task that is RUNNING.

    The running task is tested anyway, when its method ends.
    """
    if isinstance(there, dict):
        found.update(there)
    elif there.state is not RUNNING:
        found[there.number] = there
