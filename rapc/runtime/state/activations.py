"""Activations: sets of skills that are on for methods of tasks [S 3]. Tables only.

A request that has ended stands here too, as one without skills, while what was sent
under it may still come.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from rapc.base.values import Fact
from rapc.compiler.net_plan import WaitPlan
from rapc.runtime.fields import LEFT_OUT, Fields, Natural
from rapc.runtime.state.task import MethodRun, Task


class Activation:
    """What a method has switched on."""

    FIELDS: ClassVar[Fields] = {
        "ticket": Natural,
        "skills": tuple[Fact, ...],
        "owner": Natural,
        "task": Task | None,
        "run": LEFT_OUT,
    }
    __slots__ = tuple(FIELDS)

    def __init__(
        self,
        ticket: int,
        owner: int,
        task: Task | None,
        run: MethodRun | None,
        skills: tuple[Fact, ...],
    ) -> None:
        #: The number by which the world knows it.
        self.ticket = ticket
        #: The skills in memory names, in the order of the text.
        self.skills = skills
        #: The number of the task that it was begun for.
        self.owner = owner
        #: Whose rules hear its signals: the owner, or what is left above it.
        self.task = task
        #: The method that it is on for; None once it is off.
        self.run = run

    @property
    def waits(self) -> Sequence[WaitPlan]:
        """Return what ends its method, while it is on."""
        plan = None if self.run is None else self.run.plan.activation
        return () if plan is None else plan.waits

    @property
    def in_background(self) -> bool:
        """Whether it is on beside the steps of its method."""
        plan = None if self.run is None else self.run.plan.activation
        return plan is not None and plan.background

    def hearer(self) -> Task | None:
        """Return its owner, or the nearest ancestor that has not ended."""
        task = self.task
        while task is not None and not task.live:
            task = task.parent
        self.task = task
        return task


class Activations:
    """All activations of a run that are on, and those that may still be heard of."""

    FIELDS: ClassVar[Fields] = {
        "on": dict[int, Activation],
        "off": dict[int, Activation],
    }
    __slots__ = tuple(FIELDS)

    def __init__(self) -> None:
        #: Those that are on, by ticket: the oldest first.
        self.on: dict[int, Activation] = {}
        #: Those that went off since the world's messages were last taken in: what they
        #: had told by then is still to come.
        self.off: dict[int, Activation] = {}

    def begin(self, activation: Activation) -> None:
        """Add an activation that has come on."""
        self.on[activation.ticket] = activation

    def end(self, ticket: int) -> Activation:
        """Remove an activation, and return it."""
        activation = self.on.pop(ticket)
        activation.run = None
        self.off[ticket] = activation
        return activation

    def get(self, ticket: int) -> Activation | None:
        """Return an activation that is on, or whose signals may still come."""
        return self.on.get(ticket) or self.off.get(ticket)

    def forget(self, tickets: tuple[int, ...]) -> None:
        """Drop activations that are off, all of whose signals have been heard."""
        for ticket in tickets:
            self.off.pop(ticket, None)
