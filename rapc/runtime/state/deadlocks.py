"""Deadlocks: circles of waiting tasks in which each task blocks the next.

A method that holds a thing waits for the tasks below it. If one of these tasks waits
for a thing, and so on back to the first task, no task of the circle can go on by itself
[L 8.27].
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain

from rapc.runtime.state.task import Task
from rapc.runtime.state.things import Ask, Hold, Things, ThingWait, words

Circle = tuple[tuple[ThingWait, Hold], ...]
"""The waiting tasks, each with its blocking hold; the next task is below the holder."""


def deadlocks(things: Things) -> list[Circle]:
    """Return the deadlocks of a run, by the lowest task number in each."""
    waits = things.waits.items()
    stuck = _Stuck(things, {n: wait for n, wait in waits if _is_blocked(wait)})
    found: list[Circle] = []
    while stuck.waits:
        circle = stuck.circle_through(stuck.one_in_a_circle())
        found.append(circle)
        stuck.leave_out(wait.task.number for wait, _ in circle)
    return sorted(found, key=lambda circle: circle[0][0].task.number)


def deadlock_of(things: Things, wait: ThingWait) -> Circle:
    """Return the deadlock that a task has closed by beginning to wait; or nothing."""
    if not things.waited_for_above(wait.task):
        return ()
    stuck = _Stuck(things, _reachable(things, wait))
    number = wait.task.number
    return stuck.circle_through(number) if number in stuck.waits else ()


def in_words(circle: Circle) -> tuple[str, ...]:
    """Return a line for each task of a deadlock."""
    return tuple(
        f"{wait.task.goal()} [{wait.task.number}] waits for {held(hold)}"
        for wait, hold in circle
    )


def held(hold: Hold) -> str:
    """Return a held thing and its holder, in words."""
    task = hold.run.task
    return f"{words(hold)}, held by {task.goal()} [{task.number}]"


def _is_blocked(wait: ThingWait) -> bool:
    """Return whether the task itself waits, not only skills of its method."""
    return not (wait.woken or wait.skills)


def _all_asks(wait: ThingWait) -> list[Ask]:
    return [ask for asks in wait.alternatives for ask in asks]


def _in_the_way(things: Things, wait: ThingWait, asks: Iterable[Ask]) -> Iterator[Hold]:
    for ask in asks:
        now = things.ask(wait.task, ask.thing, ask.used)
        yield from things.in_the_way(wait.task, now)


def _reachable(things: Things, wait: ThingWait) -> dict[int, ThingWait]:
    """Return `wait` and the waits that block `wait`, directly or indirectly."""
    found = {wait.task.number: wait}
    looked: set[int] = set()
    todo = [wait]
    while todo:
        one = todo.pop()
        for hold in _in_the_way(things, one, _all_asks(one)):
            holder = hold.run.task
            if holder.number in looked:
                continue
            looked.add(holder.number)
            for below in _below(holder):
                other = things.waits.get(below.number)
                if other and below.number not in found and _is_blocked(other):
                    found[below.number] = other
                    todo.append(other)
    return found


def _below(task: Task) -> Iterator[Task]:
    """Yield the live tasks below `task`."""
    todo = [task]
    while todo:
        method_run = todo.pop().run
        if method_run is not None:
            steps = [step for step in method_run.steps if step.number and step.live]
            yield from steps
            todo += steps


class _Stuck:
    """The largest set of waits in which each wait depends on another of the set."""

    def __init__(self, things: Things, waits: Mapping[int, ThingWait]) -> None:
        self.waits = dict(waits)
        #: The holds that block each alternative of a wait, by task number.
        self._ways: dict[int, list[list[Hold]]] = {}
        #: The numbers of the waits that a task blocks, by its number.
        self._before: dict[int, set[int]] = {}
        #: The numbers of the waiting tasks below a task, by its number.
        self._below: dict[int, set[int]] = {}
        for number, wait in self.waits.items():
            for above in _above(wait):
                self._below.setdefault(above, set()).add(number)
            ways = [list(_in_the_way(things, wait, one)) for one in wait.alternatives]
            self._ways[number] = ways
            for hold in chain(*ways):
                self._before.setdefault(hold.run.task.number, set()).add(number)
        self.leave_out([])

    def leave_out(self, numbers: Iterable[int]) -> None:
        """Remove waits, then all waits that have a free alternative without them."""
        for number in numbers:
            self._remove(number)
        todo = list(self.waits)
        while todo:
            number = todo.pop()
            if number in self.waits and not all(map(self._keeps, self._ways[number])):
                todo += self._remove(number)

    def _remove(self, number: int) -> list[int]:
        """Remove a wait; return the waits that can end as a result."""
        freed: list[int] = []
        for above in _above(self.waits.pop(number)):
            below = self._below[above]
            below.discard(number)
            freed += () if below else self._before.get(above, ())
        return freed

    def _keeps(self, way: Iterable[Hold]) -> bool:
        return any(self._below.get(hold.run.task.number) for hold in way)

    def _followers(self, number: int) -> dict[int, Hold]:
        """Return the waits below the holders that block a wait, each with the hold."""
        found: dict[int, Hold] = {}
        for hold in chain(*self._ways[number]):
            for other in self._below.get(hold.run.task.number, ()):
                found.setdefault(other, hold)
        return found

    def one_in_a_circle(self) -> int:
        """Return the lowest task of a circle of waits."""
        passed: dict[int, None] = {}
        number = min(self.waits)
        while number not in passed:
            passed[number] = None
            number = min(self._followers(number))
        on_the_way = list(passed)
        return min(on_the_way[on_the_way.index(number) :])

    def circle_through(self, start: int) -> Circle:
        """Return the shortest circle through a task, the lowest numbers first."""
        came: dict[int, tuple[int, Hold]] = {}
        todo = deque([start])
        while todo and start not in came:
            number = todo.popleft()
            for other, hold in sorted(self._followers(number).items(), key=_first):
                if other not in came:
                    came[other] = number, hold
                    todo.append(other)
        found: list[tuple[ThingWait, Hold]] = []
        number = start
        while start in came and (not found or number != start):
            number, hold = came[number]
            found.append((self.waits[number], hold))
        return tuple(reversed(found))


def _first(pair: tuple[int, Hold]) -> int:
    return pair[0]


def _above(wait: ThingWait) -> Iterable[int]:
    above = wait.task.parent
    while above is not None:
        yield above.number
        above = above.parent
