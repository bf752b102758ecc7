"""Who has the body and who is to have it, read from what happens in a run."""

from __future__ import annotations

from collections.abc import Iterator

from rapc import events
from rapc.ir.nodes import DeclarePrimitive, DeclareSkill
from rapc.library.library import Library

Method = tuple[str, str]
"""The name of a RAP, and of a method of it."""


def claimants_of(library: Library, thing: str) -> frozenset[Method]:
    """Return the methods that claim a thing."""
    return frozenset(
        (rap.name, str(method.name or f"#{method.position}"))
        for rap in library.raps.values()
        for method in rap.methods
        if any(claim.name == thing for claim in method.claims)
    )


def users_of(library: Library, thing: str) -> frozenset[str]:
    """Return the names of the primitives and skills that use a thing."""
    declared: list[DeclarePrimitive | DeclareSkill] = []
    declared += library.primitives.values()
    declared += library.skills.values()
    return frozenset(
        one.name for one in declared if any(used.name == thing for used in one.uses)
    )


class Claims:
    """Counts who takes a thing from whom: a listener for all events of a run.

    Args:
        claimants: the methods that are to have the thing while they are at work.
        users: the primitives and skills that use it.
    """

    def __init__(self, claimants: frozenset[Method], users: frozenset[str]) -> None:
        self.claimants, self.users = claimants, users
        self.parents: dict[int, int | None] = {}
        self.priorities: dict[int, int] = {}
        self.working: set[int] = set()
        #: Tasks that were suspended and have not gone on.
        self.suspended: set[int] = set()
        self.times_suspended = 0
        #: Uses while another task of no lower priority was to have the thing.
        self.moved = 0
        #: Uses that took it from a claimant of lower priority.
        self.overruled = 0
        #: The task of each skill that uses the thing and is on.
        self.on: dict[str, int] = {}
        #: Skills that came on while those of another task were on.
        self.crossed = 0

    def __call__(self, event: events.Event) -> None:
        """Take an event of the run into account."""
        match event:
            case events.TaskCreated():
                self.parents[event.task] = event.parent
                self.priorities[event.task] = event.priority
            case events.MethodChosen():
                self.suspended.discard(event.task)
                if (event.rap, event.method) in self.claimants:
                    self.working.add(event.task)
            case events.MethodSuspended():
                self.times_suspended += 1
                self.suspended.add(event.task)
                self.working.discard(event.task)
            case events.MethodEnded():
                self.working.discard(event.task)
            case events.TaskRemoved() | events.TaskSucceeded() | events.TaskFailed():
                self.working.discard(event.task)
                self.suspended.discard(event.task)
            case events.PrimitiveRequested() if event.request[0] in self.users:
                self._use(event.task)
            case events.SkillEnabled() if event.what[0] in self.users:
                self._use(event.task)
                self.crossed += any(t != event.task for t in self.on.values())
                self.on[str(event.what)] = event.task
            case events.SkillDisabled():
                self.on.pop(str(event.what), None)

    def _use(self, task: int) -> None:
        above = set(self._up(task))
        mine = self.priorities[task]
        for other in self.working - above:
            if self.priorities[other] >= mine:
                self.moved += 1
            else:
                self.overruled += 1

    def _up(self, task: int | None) -> Iterator[int]:
        """Yield a task and all above it."""
        while task is not None:
            yield task
            task = self.parents[task]
