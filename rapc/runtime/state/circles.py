"""Circles of waiting: each task waits for a thing that the next one's method holds.

A method that holds a thing waits for the tasks below it; where one of these waits in
turn for a thing, and so on back to the first, none of them can go on by itself.
"""

from __future__ import annotations

from collections.abc import Iterable

from rapc.runtime.state.things import Ask, Hold, Things, ThingWait

Circle = tuple[tuple[ThingWait, Hold], ...]
"""Who waits, each with what is in its way; the last waits for the first."""


def circles(things: Things) -> list[Circle]:
    """Return the circles of waiting in a run, by the lowest number in each."""
    stuck = _Stuck(things)
    stuck.leave_out_who_can_go_on()
    found: list[Circle] = []
    while stuck.waits:
        path: dict[int, tuple[ThingWait, Hold]] = {}
        number = min(stuck.waits)
        while number not in path:
            wait = stuck.waits[number]
            hold = stuck.kept_by(wait, wait.alternatives[0])
            assert hold is not None
            path[number] = wait, hold
            number = min(stuck.below[hold.run.task.number])
        on_the_way = list(path)
        found.append(tuple([path[n] for n in on_the_way[on_the_way.index(number) :]]))
        for visited in path:
            stuck.leave_out(visited)
        stuck.leave_out_who_can_go_on()
    return sorted(found, key=lambda circle: min(wait.task.number for wait, _ in circle))


class _Stuck:
    """Tasks that wait for things, as long as each waits for others among them."""

    def __init__(self, things: Things) -> None:
        self._things = things
        waits = things.waits.items()
        self.waits = {n: w for n, w in waits if not (w.woken or w.skills)}
        #: The numbers of those that are below a task, by its number.
        self.below: dict[int, set[int]] = {}
        for number, wait in self.waits.items():
            for above in _above(wait):
                self.below.setdefault(above, set()).add(number)

    def leave_out_who_can_go_on(self) -> None:
        """Leave out, again and again, all that wait for nobody among the others."""
        count = -1
        while count != len(self.waits):
            count = len(self.waits)
            for number, wait in list(self.waits.items()):
                if not all(self.kept_by(wait, asks) for asks in wait.alternatives):
                    self.leave_out(number)

    def leave_out(self, number: int) -> None:
        """Leave a task out."""
        for above in _above(self.waits.pop(number)):
            self.below[above].discard(number)

    def kept_by(self, wait: ThingWait, asks: Iterable[Ask]) -> Hold | None:
        """Return what is in the way and held by one that waits for one of these."""
        for ask in asks:
            for hold in self._things.in_the_way(wait.task, ask):
                if self.below.get(hold.run.task.number):
                    return hold
        return None


def _above(wait: ThingWait) -> Iterable[int]:
    above = wait.task.parent
    while above is not None:
        yield above.number
        above = above.parent
