"""The state of a run, its clock, its trace, and asking with faults traced.

What happens in a run is in `interpreter`, `waking`, `cycle`, `signals` and `endings`.
"""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from rapc import events
from rapc.base.resources import Counter, SetResource, Value
from rapc.base.source import NOWHERE, Span
from rapc.base.values import Atom, Fact, format_atom
from rapc.ir import nodes
from rapc.library.library import Library
from rapc.world import Time, World
from tests.reference.memory import Memory
from tests.reference.queries import Asker
from tests.reference.tasks import Running, Task
from tests.reference.terms import Bindings, Fault, Functions


class Limits:
    """What bounds a run, and its other settings, as `Settings` of rapc has them."""

    def __init__(
        self,
        until: Time | None = None,
        cycles: int | None = None,
        futile_limit: int = 2,
        idle_cycles: int = 100_000,
        cycle_cost: Time = 0,
        query_steps: int = 1_000_000,
        idle_waits: int = 100_000,
        max_choices: int = 1000,
        *,
        max_resources: int = 1_000_000,
    ) -> None:
        self.until = until
        self.cycles = cycles
        self.futile_limit = futile_limit
        self.idle_cycles = idle_cycles
        self.cycle_cost = cycle_cost
        self.query_steps = query_steps
        self.idle_waits = idle_waits
        self.max_choices = max_choices
        self.max_resources = max_resources


class Run:
    """Everything that changes while a library runs in a world."""

    def __init__(
        self,
        library: Library,
        world: World,
        seed: int,
        limits: Limits,
        functions: Functions,
        solvers: Functions,
    ) -> None:
        self.library = library
        self.world = world
        self.random = random.Random(f"{seed}:interpreter")
        self.limits = limits
        self.functions = functions
        self.solvers = solvers
        self.methods = {name: list(r.methods) for name, r in library.raps.items()}
        self.appointments: list[tuple[Time, Callable[[], None]]] = []
        self.memory = Memory(library, lambda: self.time, self.changed)
        self.handlers = world.kit.handlers
        self.time: Time = 0
        self.late = False
        self.cycle = 0
        self.events: list[events.Event] = []
        self.tasks: list[Task] = []
        self.given: list[Task] = []
        self.tickets: dict[int, tuple[Fact, Task | None]] = {}
        self.owners: dict[int, Task] = {}
        self.switched: dict[int, Running] = {}
        self.stack: list[tuple[int, int]] = []
        self.last_family: int | None = None
        self.conflicts = 0
        self.idle = 0
        self.waits = 0

    # --- the trace ----------------------------------------------------------------

    def tell(self, kind: type[events.Event], **keys: Any) -> None:
        """Add an event to the trace."""
        self.events.append(
            kind(n=len(self.events), cycle=self.cycle, time=self.time, **keys)
        )

    def changed(self, kind: str, fact: str, by: str) -> None:
        """Memory has changed."""
        self.tell(getattr(events, kind), fact=fact, by=by)

    def fault(
        self, task: Task | None, clause: str, node: nodes.Node, message: str
    ) -> None:
        """A query, or a term by itself, met what it cannot use."""
        span: Span = getattr(node, "span", NOWHERE)
        source = self.library.files.get(span.file)
        if source is not None:
            clause = f"{clause} at {span.file}:{source.position(span.start).row}"
        what = f"{clause}: {message}"
        number = None if task is None else task.number
        self.tell(events.QueryFaulted, task=number, what=what)

    def look_at_clock(self) -> None:
        """Take the time from the world; a run goes no further than `until`."""
        now, until = self.world.now(), self.limits.until
        self.late = until is not None and now > until
        self.time = until if self.late and until is not None else now

    def keep_appointments(self) -> None:
        """Do what the host wants done by now, in the order of time."""
        for entry in sorted(self.appointments, key=lambda entry: entry[0]):
            if entry[0] <= self.time:
                self.appointments.remove(entry)
                entry[1]()

    # --- asking -------------------------------------------------------------------

    def asker(self, task: Task | None) -> Asker:
        """Someone to ask, on behalf of a task."""
        return Asker(self.memory, self.functions, task, self.limits.query_steps)

    def holds(
        self,
        task: Task | None,
        formula: nodes.Formula | None,
        env: Bindings,
        clause: str,
        where: nodes.Node | None = None,
    ) -> Bindings | None:
        """The first solution of a formula that a task states, faults traced.

        No formula means no condition. `where` is what a fault points at, if not the
        formula.
        """
        if formula is None:
            return env
        asker = self.asker(task)
        found = asker.first(formula, env)
        for within, message in asker.faults:
            self.fault(task, within + clause, where or formula, message)
        return found

    def every(
        self,
        task: Task,
        formula: nodes.Formula,
        env: Bindings,
        clause: str,
        where: nodes.Node,
    ) -> Iterator[Bindings]:
        """All solutions of a formula that a task states, faults traced as they come."""
        asker = self.asker(task)
        found: Bindings | None
        for found in itertools.chain(asker.every(formula, env), [None]):
            for within, message in asker.faults:
                self.fault(task, within + clause, where, message)
            asker.faults.clear()
            if found is not None:
                yield found

    def value(
        self, task: Task | None, term: nodes.Term, env: Bindings
    ) -> tuple[Value | None, str]:
        """What a term is worth, or None and why it is worth nothing."""
        try:
            return self.asker(task).term(term, env), ""
        except Fault as fault:
            return None, str(fault)

    def ground(
        self, task: Task | None, pattern: nodes.Pattern, env: Bindings, clause: str
    ) -> Fact | None:
        """A pattern that a task states, as a fact; None if a term has no value.

        What the term met is then traced as a fault of the clause.
        """
        values: list[Atom] = []
        for term in pattern.args:
            value, why = self.value(task, term, env)
            if value is None or isinstance(value, Counter | SetResource):
                why = why or f"`{format_atom(value)}` is not a symbol, number or string"
                self.fault(task, clause, pattern, why)
                return None
            values.append(value)
        return (pattern.name, *values)

    # --- tasks --------------------------------------------------------------------

    def live(self) -> list[Task]:
        """The tasks on the agenda, by number."""
        return [task for task in self.tasks if task.live]

    def inputs(self, running: Running, terms: Sequence[nodes.Term]) -> list[Any]:
        """Terms in the bindings of a method; None for those without a value."""
        return [self.value(running.task, term, running.env)[0] for term in terms]


def unbound(term: nodes.Term | None, env: Mapping[str, object]) -> bool:
    """Whether a term uses a variable that has no value."""
    if isinstance(term, nodes.Var):
        return term.name not in env
    if isinstance(term, nodes.Call):
        return any(unbound(arg, env) for arg in term.args)
    return False
