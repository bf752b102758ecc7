"""Things: the tables of holds, waits and obstacles [L 8].

A thing is a symbol or a name with values, `wheels` or `(arm left)`. A method holds
things from its start to its end. If a method would have to wait for a thing, its task
is blocked. Tables only: `rapc.runtime.tasks.hold_things` defines how tasks use them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar, NamedTuple

from rapc.base.values import Fact, format_atom, format_list
from rapc.runtime.fields import LEFT_OUT, Fields, Natural
from rapc.runtime.state.task import MethodRun, Task

Thing = Fact
"""A thing, filled in: its name, then its arguments."""

CONFLICT = "#"
"""The name of the shared thing of requests that a world reports to be in conflict."""


class Ask(NamedTuple):
    """A thing that a method requests."""

    thing: Thing
    #: The highest priority among the task and those ancestors that hold the thing.
    priority: int
    #: Whether the request of the method uses the thing; otherwise the method claims it.
    used: bool


class Hold:
    """A thing that a method holds."""

    FIELDS: ClassVar[Fields] = {
        "run": LEFT_OUT,
        "ask": Ask,
        "said": str,
        "outer": LEFT_OUT,
        "depth": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(
        self, method_run: MethodRun, ask: Ask, outer: Hold | None, said: str = ""
    ) -> None:
        self.run = method_run
        self.ask = ask
        #: The text for a thing without a name: the request that holds it.
        self.said = said
        #: The nearest ancestor's hold of the same thing, and the number of such holds.
        self.outer = outer
        self.depth: int = 0 if outer is None else outer.depth + 1


class ThingWait:
    """A wait of a blocked task, or of some `skills` of its method, for things."""

    FIELDS: ClassVar[Fields] = {
        "task": Task,
        "alternatives": tuple[tuple[Ask, ...], ...],
        "on": str,
        "holder": Natural,
        "woken": bool,
        "skills": tuple[int, ...],
    }
    __slots__ = tuple(FIELDS)

    def __init__(
        self,
        task: Task,
        alternatives: tuple[tuple[Ask, ...], ...],
        on: str,
        holder: int,
    ) -> None:
        self.task = task
        #: The things that the method would request, then those of each alternative
        #: choice.
        self.alternatives = alternatives
        #: The first obstacle when the task was blocked, as text, and the number of the
        #: task that held it.
        self.on = on
        self.holder = holder
        #: Whether the task has been woken and not yet been selected.
        self.woken = False
        #: The skills of the method that are off until then, while the task is running.
        self.skills: tuple[int, ...] = ()


class Things:
    """All holds and waits for things in a run."""

    FIELDS: ClassVar[Fields] = {
        "held": dict[int, tuple[Hold, ...]],
        "waits": dict[int, ThingWait],
        "to_test": dict[int, Task],
        "resumable": LEFT_OUT,
        "conflicts": Natural,
        "_holders": LEFT_OUT,
        "_waiters": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(self) -> None:
        # These three objects are never replaced: other objects refer to them.
        #: The things that each method holds, by the number of its task.
        self.held: dict[int, tuple[Hold, ...]] = {}
        #: The waits of blocked and woken tasks, by number.
        self.waits: dict[int, ThingWait] = {}
        #: The waiting tasks whose obstacles have changed since the last test.
        self.to_test: dict[int, Task] = {}
        #: The running tasks whose skills may start again, by number.
        self.resumable: dict[int, Task] = {}
        #: How often a world has refused a request because of a conflict.
        self.conflicts = 0
        self._holders: dict[Thing, dict[int, Hold]] = {}
        self._waiters: dict[Thing, dict[int, Task]] = {}

    # --- requests for things ------------------------------------------------------

    def ask(self, task: Task, thing: Thing, used: bool) -> Ask:
        """Return the request of a method of `task` for `thing`, with its priority."""
        outer = self._outer(task, thing)
        priority = task.priority
        if outer is not None:
            priority = max(priority, outer.ask.priority)
        return Ask(thing, priority, used)

    def in_the_way(self, task: Task, ask: Ask) -> list[Hold]:
        """Return the holds that keep a method of `task` from a thing.

        The holds are in the order of the task numbers. Holds of ancestors, and holds of
        a lower priority, are left out.
        """
        found = self._others(task, ask.thing)
        return [hold for hold in found if hold.ask.priority >= ask.priority]

    def lower_users(self, task: Task, ask: Ask) -> list[Hold]:
        """Return the uses of a thing at a lower priority than that of `task`."""
        found = self._others(task, ask.thing)
        return [h for h in found if h.ask.used and h.ask.priority < ask.priority]

    def obstacle(self, task: Task, asks: Iterable[Ask]) -> Hold | None:
        """Return the first hold that blocks any of the `asks`, or None."""
        for ask in asks:
            found = self.in_the_way(task, ask)
            if found:
                return found[0]
        return None

    def obstacle_of(self, wait: ThingWait) -> Hold | None:
        """Return the hold that blocks a waiting task; None if one choice is free."""
        task = wait.task
        obstacles = [
            self.obstacle(task, [self.ask(task, a.thing, a.used) for a in asks])
            for asks in wait.alternatives
        ]
        return obstacles[0] if None not in obstacles else None

    def _outer(self, task: Task, thing: Thing) -> Hold | None:
        """Return the hold of the nearest ancestor of `task` on `thing`."""
        holders = self._holders.get(thing)
        if not holders:
            return None
        above = task.parent
        while above is not None and above.number not in holders:
            above = above.parent
        return None if above is None else holders[above.number]

    def _others(self, task: Task, thing: Thing) -> list[Hold]:
        """Return the holds of `thing` by tasks that are no ancestors of `task`."""
        holders = self._holders.get(thing)
        if not holders:
            return []
        outer = self._outer(task, thing)
        if outer is not None and outer.depth + 1 == len(holders):
            return []
        above = set()
        while outer is not None:
            above.add(outer.run.task.number)
            outer = outer.outer
        return [
            holders[number]
            for number in sorted(holders)
            if number not in above and number != task.number
        ]

    def waited_for_above(self, task: Task) -> bool:
        """Return whether a task waits for a thing that an ancestor of `task` holds."""
        above = task.parent
        while above is not None:
            for hold in self.held.get(above.number, ()):
                if hold.ask.thing in self._waiters:
                    return True
            above = above.parent
        return False

    # --- holding ------------------------------------------------------------------

    def take(self, method_run: MethodRun, asks: Iterable[Ask], said: str = "") -> None:
        """Add the requested things to the things that a method holds.

        `said` is the text for a thing without a name.
        """
        number, holds = method_run.task.number, []
        for ask in asks:
            hold = Hold(method_run, ask, self._outer(method_run.task, ask.thing), said)
            self._holders.setdefault(ask.thing, {})[number] = hold
            holds.append(hold)
            self._changed(ask.thing)
        if holds:
            self.held[number] = (*self.held.get(number, ()), *holds)

    def release(self, task: Task) -> None:
        """Free all things of the method of `task`."""
        holds = self.held.pop(task.number, ())
        if holds:
            self._drop([hold.ask.thing for hold in holds], task.number)

    def hold_just(
        self, method_run: MethodRun, asks: Iterable[Ask], said: str = ""
    ) -> None:
        """Replace the things of a running method by the requested things.

        `said` is the text for new things without a name.
        """
        before = {
            h.ask.thing: h.said for h in self.held.get(method_run.task.number, ())
        }
        self.release(method_run.task)
        held = {ask.thing: ask for ask in asks}
        for thing, ask in held.items():
            new = said if thing[0] == CONFLICT else ""
            self.take(method_run, (ask,), before.get(thing, new))
        for thing in {**before, **held}:
            self._place_again(thing)

    def _place_again(self, thing: Thing) -> None:
        """Compute the holds of a thing again, ancestors (lower numbers) first."""
        for _, hold in sorted(self._holders.get(thing, {}).items()):
            task = hold.run.task
            hold.ask = self.ask(task, thing, hold.ask.used)
            hold.outer = self._outer(task, thing)
            hold.depth = 0 if hold.outer is None else hold.outer.depth + 1

    def _drop(self, things: Iterable[Thing], number: int) -> None:
        for thing in things:
            holders = self._holders[thing]
            del holders[number]
            if not holders:
                del self._holders[thing]
            self._changed(thing)

    def _changed(self, thing: Thing) -> None:
        self.to_test.update(self._waiters.get(thing, ()))

    # --- waiting ------------------------------------------------------------------

    def wait(self, wait: ThingWait) -> None:
        """Register a waiting task; a change of its obstacles leads to a test."""
        task = wait.task
        self.waits[task.number] = wait
        for asks in wait.alternatives:
            for ask in asks:
                self._waiters.setdefault(ask.thing, {})[task.number] = task

    def stop_waiting(self, task: Task) -> None:
        """Unregister a task from the things that it waits for, if any."""
        wait = self.waits.pop(task.number, None)
        if wait is None:
            return
        self.to_test.pop(task.number, None)
        self.resumable.pop(task.number, None)
        for ask in (ask for asks in wait.alternatives for ask in asks):
            waiters = self._waiters.get(ask.thing, {})
            waiters.pop(task.number, None)
            if not waiters:
                self._waiters.pop(ask.thing, None)

    # --- as a whole -----------------------------------------------------------------

    def take_up(self, other: Things, runs: Mapping[int, MethodRun]) -> None:
        """Replace all holds and waits by those of the saved tables.

        `runs` are the methods that hold things, by the numbers of their tasks.
        """
        held = [
            (runs[number], [(hold.ask, hold.said) for hold in holds])
            for number, holds in sorted(other.held.items())
        ]
        self._load(held, list(other.waits.values()))
        self.to_test.update(other.to_test)
        self.conflicts = other.conflicts

    def _load(
        self,
        held: Iterable[tuple[MethodRun, Iterable[tuple[Ask, str]]]],
        waits: Iterable[ThingWait],
    ) -> None:
        """Replace all holds and waits; the holds are in the order of task numbers."""
        self._holders, self._waiters = {}, {}
        self.held.clear()
        self.waits.clear()
        self.to_test.clear()
        self.resumable.clear()
        for method_run, holds in held:
            for ask, said in holds:
                self.take(method_run, (ask,), said)
        for wait in waits:
            self.wait(wait)

    def rename(self, lost: str, kept: str) -> None:
        """Rename an item in all things after a merge of two items."""
        held = [
            (holds[0].run, _renamed([(h.ask, h.said) for h in holds], lost, kept))
            for _, holds in sorted(self.held.items())
        ]
        waits = list(self.waits.values())
        for wait in waits:
            ways = [
                _renamed([(ask, "") for ask in asks], lost, kept)
                for asks in wait.alternatives
            ]
            wait.alternatives = tuple([tuple([a for a, _ in way]) for way in ways])
        self._load(held, waits)
        self.to_test.update((wait.task.number, wait.task) for wait in waits)

    def conflict(self) -> Thing:
        """Return a new thing for requests that a world reports to be in conflict."""
        self.conflicts += 1
        return (CONFLICT, self.conflicts)


def _renamed(
    asked: Iterable[tuple[Ask, str]], lost: str, kept: str
) -> list[tuple[Ask, str]]:
    """Return requests and their texts with an item renamed; each thing once."""
    found: dict[Thing, tuple[Ask, str]] = {}
    for ask, said in asked:
        name, *args = ask.thing
        thing = (name, *[kept if part == lost else part for part in args])
        other = found.get(thing, (ask, said))[0]
        priority, used = max(ask.priority, other.priority), ask.used or other.used
        found[thing] = Ask(thing, priority, used), said
    return list(found.values())


def words(hold: Hold) -> str:
    """Return the text for a held thing: the thing itself, or the request."""
    return hold.said or format_thing(hold.ask.thing)


def format_thing(thing: Thing) -> str:
    """Return a thing as RAP text."""
    return format_atom(thing[0]) if len(thing) == 1 else format_list(thing)
