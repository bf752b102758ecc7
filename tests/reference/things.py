"""Things: what methods ask for, who holds it, and what stands in the way (section 10).

Everything is found anew whenever it is asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rapc.base.resources import Counter, SetResource
from rapc.base.values import Fact, format_atom, format_list
from rapc.ir import nodes
from tests.reference.run import Run
from tests.reference.tasks import Running, Task
from tests.reference.terms import Bindings


class Ask(NamedTuple):
    """A thing that a method asks for; its request uses it, or else it claims it."""

    thing: Fact
    used: bool


class Obstacle(NamedTuple):
    """What stands in the way of a method, and the task that holds it."""

    thing: Fact
    holder: Task

    @property
    def words(self) -> str:
        """The thing or, if a world alone says what it is, the holder's request."""
        running = self.holder.running
        said = {} if running is None else running.said
        return said.get(self.thing) or written(self.thing)


# --- asking -----------------------------------------------------------------------


def asks(run: Run, task: Task, method: nodes.Method, env: Bindings) -> list[Ask] | None:
    """What a method would ask for: what its request uses, then what it claims.

    None if its request or a claim cannot be filled in: then it asks for nothing.
    """
    found: list[Ask] = []
    body = method.body
    asked: Sequence[nodes.Pattern] = method.skills
    if isinstance(body, nodes.Primitive):
        asked = [body.request]
    elif isinstance(body, nodes.Skills):
        asked = body.enable
    for one in asked:
        uses = used(run, task, one, env)
        if uses is None:
            return None
        found += [Ask(thing, True) for thing in uses]
    for thing in method.claims:
        made = filled(run, task, thing, env)
        if made is None:
            return None
        found.append(Ask(made, False))
    return found


def used(
    run: Run, task: Task, asked: nodes.Pattern, env: Bindings
) -> list[Fact] | None:
    """What a request or a skill uses; None if it cannot be filled in."""
    sent = filled(run, task, asked, env)
    return None if sent is None else used_once_filled(run, task, sent)


def used_once_filled(run: Run, task: Task, sent: Fact) -> list[Fact] | None:
    """What a request or a skill uses that has values; None if a thing has none."""
    name, library = str(sent[0]), run.library
    declared = library.skills.get(name) or library.primitives[name]
    names = [argument.variable.name for argument in declared.args]
    given = dict(zip(names, sent[1:], strict=True))
    found = []
    for thing in declared.uses:
        made = filled(run, task, thing, given)
        if made is None:
            return None
        found.append(made)
    return found


def filled(run: Run, task: Task, pattern: nodes.Pattern, env: Bindings) -> Fact | None:
    """A name with its terms by value, untraced; None if one of them has none."""
    values = []
    for term in pattern.args:
        value, _ = run.value(task, term, env)
        if value is None or isinstance(value, Counter | SetResource):
            return None
        values.append(value)
    return (pattern.name, *values)


# --- holding ----------------------------------------------------------------------


def holders(run: Run, thing: Fact) -> Iterator[Running]:
    """The methods that hold a thing, by task number."""
    for task in run.live():
        if task.running is not None and holds(task.running, thing):
            yield task.running


def holds(running: Running, thing: Fact) -> bool:
    """Whether a method holds a thing, for its request or by a claim."""
    return thing in running.uses or thing in running.claims


def rank(task: Task, thing: Fact) -> int:
    """The highest priority among a task and those ancestors that hold a thing."""
    _, *above = task.line()
    holding = [t for t in above if t.running is not None and holds(t.running, thing)]
    return max(t.priority for t in (task, *holding))


def obstacles(run: Run, task: Task, wanted: Sequence[Ask]) -> list[Obstacle]:
    """What stands in the way of a task's method, in the order that it asks."""
    line = list(task.line())
    return [
        Obstacle(ask.thing, running.task)
        for ask in wanted
        for running in holders(run, ask.thing)
        if running.task not in line
        and rank(running.task, ask.thing) >= rank(task, ask.thing)
    ]


def giving_way(run: Run, task: Task, wanted: Sequence[Ask]) -> list[tuple[Task, Fact]]:
    """The lower tasks whose requests use what a task asks for, by number, with it."""
    line = list(task.line())
    found: dict[int, tuple[Task, Fact]] = {}
    for ask in wanted:
        for running in holders(run, ask.thing):
            if running.task not in line and ask.thing in running.uses:
                found.setdefault(running.task.number, (running.task, ask.thing))
    return [found[number] for number in sorted(found)]


def written(thing: Fact) -> str:
    """A thing as the trace has it: `wheels`, or `(arm left)`."""
    return format_list(thing) if len(thing) > 1 else format_atom(thing[0])
