"""Choosing a method and starting it: steps 6 to 9 of [L 3]."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import msgspec

from rapc import events
from rapc.base.resources import frozen
from rapc.base.values import Fact, format_atom
from rapc.ir import nodes
from rapc.ir.walk import variables
from tests.reference.endings import (
    fail,
    method_badly,
    method_well,
    repeats,
)
from tests.reference.giving_way import ask_world, give_way
from tests.reference.primitives import claim
from tests.reference.run import Run
from tests.reference.skills import skills_of
from tests.reference.tasks import Place, Running, Task, method_name
from tests.reference.terms import Bindings
from tests.reference.things import Obstacle, asks, obstacles
from tests.reference.waking import hold_up, let_go, read_inputs, read_windows

Held = list[tuple[nodes.Method, Bindings]]
"""Methods that hold, with their first bindings."""

# --- steps 6 to 8 ----------------------------------------------------------------


def holding(run: Run, task: Task) -> Held:
    """The methods of a task that hold now."""
    held: Held = []
    for method in run.methods[task.rap.name]:
        context = plain(method.context)
        if context is not method.context and held:
            continue  # `otherwise`: a method before this one holds
        parts = [f for f in (task.rap.repeat_while, context) if f is not None]
        clause = f"context of method `{method_name(method)}`"
        where = parts[0] if len(parts) == 1 else method
        found = run.holds(task, nodes.And(tuple(parts)), task.own, clause, where)
        if found is not None:
            held.append((method, found))
    return held


def plain(formula: nodes.Formula | None) -> nodes.Formula | None:
    """A context itself or, if `otherwise` is among its conjuncts, what else it asks."""
    if isinstance(formula, nodes.Otherwise):
        return None
    if not isinstance(formula, nodes.And):
        return formula
    parts = [plain(part) for part in formula.parts]
    if all(one is other for one, other in zip(parts, formula.parts, strict=True)):
        return formula
    return nodes.And(tuple(p for p in parts if p is not None), span=formula.span)


def solve(run: Run, task: Task) -> bool:
    """Ask the problem solver of a RAP; whether it returned any method."""
    solver = run.solvers.get(task.rap.name)
    if solver is None:
        return False
    known = run.methods[task.rap.name]
    returned = list(solver((task.rap.name, *task.args), run.memory))
    for method in returned:
        if not any(same(method, other) for other in known):
            known.append(msgspec.structs.replace(method, position=len(known) + 1))
    run.tell(
        events.SolverCalled,
        task=task.number,
        goal=task.goal(),
        methods=len(returned),
    )
    return bool(returned)


SAYS = ("name", "context", "notations", "body", "constraints", "claims", "skills")
"""What a method says, wherever it stands."""


def same(one: nodes.Method, other: nodes.Method) -> bool:
    """Whether two methods are one, wherever they stand."""
    return all(getattr(one, field) == getattr(other, field) for field in SAYS)


def choose_method(run: Run, task: Task) -> None:
    """Step 6: the methods that hold; failed least, chosen least, free, then chance."""
    held = holding(run, task)
    if not held and solve(run, task):
        held = holding(run, task)
    if not held:
        fail(run, task, "no-method")
        return
    least = min(task.failures.get(method.position, 0) for method, _ in held)
    held = [row for row in held if task.failures.get(row[0].position, 0) == least]
    least = min(tries(task, method) for method, _ in held)
    held = [row for row in held if tries(task, row[0]) == least]
    free, waiting = [], []
    for row in held:
        before: Held = []
        for one in solutions(run, task, *row):
            if not in_the_way(run, task, *one):
                free.append(one)
                break
            before.append(one)
        waiting += before
    held = free or held
    drawn = held[0]
    if len(held) > 1:
        drawn = held[run.random.randrange(len(held))]
    method, found = drawn
    for seen in list(task.chosen)[: -run.limits.max_choices]:
        del task.chosen[seen]
    times = task.chosen.get(choice(method, found), 0)
    if times >= run.limits.futile_limit:
        fail(run, task, "futile-loop")
        return
    running = Running(task, method, dict(found), run.time)
    running.choice = choice(method, found)
    if any(repeats(run, running, place) for place in running.places):
        fail(run, task, "futile-loop")
    elif free:
        task.chosen[running.choice] = times + 1
        task.times[method.position] = tries(task, method) + 1
        start(run, running)
    else:
        put_back(run, task, drawn, waiting)


def solutions(
    run: Run, task: Task, method: nodes.Method, found: Bindings
) -> Iterator[tuple[nodes.Method, Bindings]]:
    """The first solution of a choice and, if its things vary with them, all others."""
    yield method, found
    parts = [task.rap.repeat_while, plain(method.context)]
    formula = nodes.And(tuple(part for part in parts if part is not None))
    asking = [*method.claims, *method.skills]
    if isinstance(method.body, nodes.Primitive):
        asking.append(method.body.request)
    elif isinstance(method.body, nodes.Skills):
        asking += method.body.enable
    given = {*(one.name for one in task.rap.inputs)}
    given |= {one.variable.name for one in task.rap.resources}
    names = {one.name for one in variables(formula)} - given
    if not names & {one.name for pattern in asking for one in variables(pattern)}:
        return
    clause = f"context of method `{method_name(method)}`"
    where = formula.parts[0] if len(formula.parts) == 1 else method
    others = run.every(task, formula, task.own, clause, where)
    yield from ((method, other) for other in islice(others, 1, None))


def in_the_way(
    run: Run, task: Task, method: nodes.Method, env: Bindings
) -> list[Obstacle]:
    """What stands in the way of a method now."""
    return obstacles(run, task, asks(run, task, method, env) or [])


def put_back(
    run: Run, task: Task, drawn: tuple[nodes.Method, Bindings], pool: Held
) -> None:
    """Nothing was chosen; the task waits for what it would have asked for."""
    task.wanted = []
    for row in (drawn, *pool):
        wanted = asks(run, task, *row) or []
        if wanted not in task.wanted:
            task.wanted.append(wanted)
    hold_up(run, task, obstacles(run, task, task.wanted[0])[0])


def tries(task: Task, method: nodes.Method) -> int:
    """How often a task has chosen a method, whatever was bound."""
    return task.times.get(method.position, 0)


def choice(method: nodes.Method, env: Bindings) -> tuple[object, ...]:
    """A method and every binding alive, as the futile-loop detector sees them."""
    bound = sorted(zip(env, frozen(env.values()), strict=True))
    return (method.position, *bound)


# --- step 9 ----------------------------------------------------------------


def start(run: Run, running: Running) -> None:
    """The method starts, and what is lower and uses what it takes gives way."""
    task, method, env = running.task, running.method, running.env
    wanted = asks(run, task, method, env)
    give_way(run, task, wanted or [])
    running.asked = wanted or []
    running.uses = [ask.thing for ask in running.asked if ask.used]
    running.claims = [ask.thing for ask in running.asked if not ask.used]
    task.running = running
    running.first = method.name not in task.tried
    task.tried[method.name] = None
    run.tell(
        events.MethodChosen,
        task=task.number,
        rap=task.rap.name,
        method=method_name(method),
        bindings={n: format_atom(env[n]) for n in in_order(task, method, env)},
    )
    if not claim(run, running) or not note(run, running):
        method_badly(run, running, "interference", "sibling-failed")
    elif isinstance(method.body, nodes.Primitive):
        ask_world(run, running)
    elif skills_of(method) and not ask_world(run, running):
        method_badly(run, running, "interference", "sibling-failed")
    elif task.running is not running:
        return
    elif isinstance(method.body, nodes.Skills):
        if not method.body.waits:
            method_well(run, running)
    elif not running.places:
        method_well(run, running)
    else:
        spawn(run, running)


def in_order(task: Task, method: nodes.Method, env: Bindings) -> list[str]:
    """The names of bindings as the trace orders them: what a formula binds by text."""
    found = list(task.own)
    for formula in (task.rap.repeat_while, method.context):
        if formula is not None:
            places = sorted((v.span.start, v.name) for v in variables(formula))
            found += [name for _, name in places if name in env]
    return list(dict.fromkeys(found))


def note(run: Run, running: Running) -> bool:
    """Assert the notations, all or none; False if one is unbound."""
    facts: list[Fact] = []
    for pattern in running.method.notations:
        fact = run.ground(running.task, pattern, running.env, "notation")
        if fact is None:
            return False
        facts.append(fact)
    for fact in facts:
        run.memory.note(fact, running)
        running.noted.append(fact)
    return True


def spawn(run: Run, running: Running) -> None:
    """The subtasks join the agenda, in the order of the text."""
    for place in running.places:
        create(run, run.library.raps[place.step.goal.name], running, place)
    for place in running.places:
        if place.task is not None:
            read_windows(run, place.task)
            let_go(run, place)


def create(
    run: Run, rap: nodes.DefineRap, running: Running | None, place: Place | None
) -> Task:
    """A task is made."""
    task = Task(len(run.tasks) + 1, rap, running, place, run.time)
    run.tasks.append(task)
    if running is not None and place is not None:
        place.task = task
        task.priority = running.task.priority + place.step.priority
        announce(run, task)
    return task


def announce(run: Run, task: Task) -> None:
    """Read a task's inputs and trace that it was made."""
    if task.parent is not None and task.place is not None:
        task.args = run.inputs(task.parent, task.place.step.goal.args)
    run.tell(
        events.TaskCreated,
        task=task.number,
        goal=task.goal(),
        parent=None if task.parent is None else task.parent.task.number,
        family=task.family,
        priority=task.priority,
        step=None if task.place is None else task.place.step.tag,
    )
    read_inputs(run, task)
    task.compared = task.bound_as is not None
