"""Tasks, running methods and steps: what each of them holds [L 3] to [L 6]."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rapc.base.resources import Value
from rapc.base.values import Fact, format_atom
from rapc.ir import nodes
from rapc.ir.printer import format_term
from rapc.world import Time

if TYPE_CHECKING:
    from tests.reference.things import Ask

_TIMES = ("now", "absolute")


class Place:
    """A step of a running method: its task, and how far it has come."""

    def __init__(self, step: nodes.Step) -> None:
        self.step = step
        self.task: Task | None = None
        self.ended: Time | None = None
        self.lapsed = False
        self.listens = False
        self.goes = True
        self.released = False

    def notes(self, kind: type[nodes.Annotation]) -> list[nodes.Annotation]:
        """Its annotations of one kind, in the order of the text."""
        return [note for note in self.step.annotations if isinstance(note, kind)]


class Running:
    """A method that runs: its bindings, its steps, what it notes and holds.

    `skills` are those of the method as filled in when it switched them on; `ticket` is
    that of those that are `on`; `off` are the places of those that a
    higher task has switched off, `back` what they ask for to come on again.
    `said` is what is told of the things among its `uses` that have no name: what it
    asked of a world that says that it is in conflict with others.
    `choice` is what the futile-loop detector knows of it; `first` whether its task had
    not tried it before.
    """

    def __init__(
        self, task: Task, method: nodes.Method, env: dict[str, Value], made: Time
    ) -> None:
        self.task = task
        self.method = method
        self.env = env
        self.made = made
        self.noted: list[Fact] = []
        self.uses: list[Fact] = []
        self.claims: list[Fact] = []
        self.said: dict[Fact, str] = {}
        self.asked: list[Ask] = []
        self.skills: list[Fact] = []
        self.ticket: int | None = None
        self.on: list[Fact] = []
        self.off: list[int] = []
        self.back: list[Ask] = []
        self.choice: tuple[object, ...] = ()
        self.first = False
        body = method.body
        steps = body.steps if isinstance(body, nodes.TaskNet) else ()
        self.places = [Place(step) for step in steps]

    def place(self, tag: str) -> Place:
        """The step with a tag."""
        return next(p for p in self.places if p.step.tag == tag)

    def followed(self, place: Place) -> list[Place]:
        """The steps a step is ordered after, by `for` and by `window`."""
        before = []
        for other in self.places:
            tags = [n.tag for n in other.step.annotations if isinstance(n, nodes.For)]
            if place.step.tag in tags:
                before.append(other)
        for note in place.step.annotations:
            if isinstance(note, nodes.Window) and note.reference not in _TIMES:
                before.append(self.place(note.reference))
        return before

    def conditions(self, place: Place) -> list[nodes.Formula]:
        """The formulas that `for` annotations put on a step."""
        return [
            note.formula
            for other in self.places
            for note in other.step.annotations
            if isinstance(note, nodes.For)
            and note.tag == place.step.tag
            and note.formula is not None
            and not other.lapsed
        ]


class Task:
    """A task on the agenda; what it remembers lasts as long as it lives.

    `wanted` is what it waits for a thing to ask for: one list for each method, one of
    which must be free of obstacles; `held_up` whether none is.
    """

    def __init__(
        self,
        number: int,
        rap: nodes.DefineRap,
        parent: Running | None,
        place: Place | None,
        made: Time,
    ) -> None:
        self.number = number
        self.rap = rap
        self.parent = parent
        self.place = place
        self.made = made
        self.priority = 0
        self.given_deadline: Time | None = None
        self.background = False
        self.live = True
        self.outcome: str | None = None
        self.args: list[Value | None] = []
        self.own: dict[str, Value] = {}
        self.bound_as: list[object] | None = None
        self.outputs: dict[str, Value] = {}
        self.broken = False
        self.compared = False
        self.allowed = False
        self.prepared = False
        self.duration: int | float = 0
        self.resources: dict[str, Value] = {}
        self.delay_from = made
        self.delay: tuple[Time, Time] | None = None
        self.windows: dict[int, tuple[Time, Time] | None] = {}
        self.missed: Time | None = None
        self.to_tell: list[Time] = []
        self.running: Running | None = None
        self.begun = False
        self.blocked = False
        self.blocked_on = ""
        self.once = False
        self.timers: list[Time] = []
        self.wanted: list[list[Ask]] = []
        self.held_up = False
        self.held_up_by: tuple[str, int] = ("", 0)
        self.failures: dict[int, int] = {}
        self.chosen: dict[tuple[object, ...], int] = {}
        self.times: dict[int, int] = {}
        self.has_failed = False
        self.last_result: str | None = None
        self.tried: dict[object, None] = {}
        self.results: dict[object, str] = {}
        self.symbol: str | None = None
        self.last_good: dict[str, Value] = {}

    @property
    def family(self) -> int:
        """The number of the top-level task."""
        return next(t.number for t in self.line() if t.parent is None)

    @property
    def monitored(self) -> bool:
        """Whether it has a monitor."""
        return self.rap.monitor_state is not None or self.rap.monitor_time is not None

    @property
    def full(self) -> bool:
        """Whether all inputs are bound."""
        return all(arg is not None for arg in self.args)

    def line(self) -> Iterator[Task]:
        """The task and its ancestors, nearest first."""
        task: Task | None = self
        while task is not None:
            yield task
            task = task.parent.task if task.parent is not None else None

    def goal(self) -> str:
        """The goal as the trace prints it."""
        words = [self.rap.name]
        terms = self.place.step.goal.args if self.place is not None else ()
        for position, value in enumerate(self.args):
            if value is not None:
                words.append(format_atom(value))
            else:
                env = self.parent.env if self.parent is not None else {}
                words.append(format_term(terms[position], env))
        if self.rap.outputs:
            words.append("=>")
            for variable in self.rap.outputs:
                value = self.outputs.get(variable.name)
                words.append(variable.name if value is None else format_atom(value))
        return f"({' '.join(words)})"


def method_name(method: nodes.Method) -> str:
    """A method as the trace names it: its name, or `#n` by position."""
    return f"#{method.position}" if method.name is None else format_atom(method.name)
