"""Tables of activations: the sets of active skills of methods [S 3].

The table also contains requests that have ended, as activations without skills, while
messages sent under these requests may still come.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from rapc.base.values import Fact
from rapc.compiler.net_plan import WaitPlan
from rapc.runtime.fields import LEFT_OUT, Fields, Natural
from rapc.runtime.state.task import MethodRun, Task


class Activation:
    """A set of skills that a method has switched on."""

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
        method_run: MethodRun | None,
        skills: tuple[Fact, ...],
    ) -> None:
        #: The ticket: the number of the activation in the world.
        self.ticket = ticket
        #: The skills in memory names, in the order of the text.
        self.skills = skills
        #: The number of the task whose method began the activation.
        self.owner = owner
        #: The task whose rules receive the signals: the owner, or its nearest live
        #: ancestor.
        self.task = task
        #: The method of the activation; None once the activation has ended.
        self.run = method_run

    @property
    def waits(self) -> Sequence[WaitPlan]:
        """Return the waits that end the method, while the activation is on."""
        plan = None if self.run is None else self.run.plan.activation
        return () if plan is None else plan.waits

    @property
    def in_background(self) -> bool:
        """Return whether the activation runs beside the steps of its method."""
        plan = None if self.run is None else self.run.plan.activation
        return plan is not None and plan.background

    def hearer(self) -> Task | None:
        """Return the owner, or the nearest ancestor that has not ended."""
        task = self.task
        while task is not None and not task.live:
            task = task.parent
        self.task = task
        return task


class Activations:
    """The active activations of a run, and ended ones with outstanding signals."""

    FIELDS: ClassVar[Fields] = {
        "on": dict[int, Activation],
        "off": dict[int, Activation],
    }
    __slots__ = tuple(FIELDS)

    def __init__(self) -> None:
        #: The active activations by ticket, oldest first.
        self.on: dict[int, Activation] = {}
        #: The activations that ended since the last intake of messages; their earlier
        #: signals are still to come.
        self.off: dict[int, Activation] = {}

    def begin(self, activation: Activation) -> None:
        """Add an activation that has started."""
        self.on[activation.ticket] = activation

    def end(self, ticket: int) -> Activation:
        """Remove an activation and return it."""
        activation = self.on.pop(ticket)
        activation.run = None
        self.off[ticket] = activation
        return activation

    def get(self, ticket: int) -> Activation | None:
        """Return an active activation, or an ended one with outstanding signals."""
        return self.on.get(ticket) or self.off.get(ticket)

    def forget(self, tickets: tuple[int, ...]) -> None:
        """Drop ended activations without outstanding signals."""
        for ticket in tickets:
            self.off.pop(ticket, None)
