"""Why a task has failed or a method ended badly: found out afterwards, told as a chain.

What a failure is called (`interference`, `no-method`) says which rule failed it [L 3];
the cause says which clause, where it stands, and which part of it had no solution. It
is found by asking anew, at once and before anything changes, through a context that
tells nobody: so the run is the same with and without it. Nothing is done unless events
tell of causes (`Recorder.tells_causes`).

Not here: why a method has ended badly by itself (`rapc.runtime.tasks.method_causes`),
and the words in which a cause is printed (`rapc.runtime.events.report`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import islice
from typing import NamedTuple

import msgspec

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.source import Span
from rapc.base.values import format_atom
from rapc.compiler.query.query import Query
from rapc.compiler.rap_plan import MethodPlan
from rapc.events import Cause
from rapc.ir import clauses, nodes
from rapc.ir.printer import format_goal, format_term
from rapc.ir.walk import subterms
from rapc.runtime.machine import Machine
from rapc.runtime.query_context import NotingContext, time_of
from rapc.runtime.state.task import Env, MethodRun, Task

LONGEST = 16
"""How many links a chain of causes may have before its middle is left out."""


# --- steps 1 to 4: what keeps a task from trying --------------------------------


def of_inputs(machine: Machine, task: Task) -> Cause | None:
    """Return why a task whose inputs are not all bound has failed."""
    step, run = task.step, task.within
    if not machine.recorder.tells_causes or step is None or run is None:
        return None
    values = zip(step.node.goal.args, task.goal_args, strict=True)
    unbound = [format_term(term) for term, value in values if value is None]
    return Cause(
        clause=f"inputs of step `{step.node.tag}` of `{run.task.plan.name}`",
        place=file_and_line(machine, step.node.span),
        part=format_goal(step.node.goal),
        note=f"{', '.join(unbound)} not bound",
        bindings=told_of(run.env, variables_in(step.node.goal.args)),
    )


def of_set_up(machine: Machine, task: Task) -> Cause | None:
    """Return why no resources or times could be made for a task."""
    if not machine.recorder.tells_causes:
        return None
    context = context_of(machine, task)
    for resource, initial in task.plan.resources:
        made = task.env.get(resource.variable.name)
        if initial is not None and not isinstance(made, Counter | SetResource):
            initial.needed(context, task.env)
            return Cause(
                clause=f"resources of `{task.plan.name}`",
                place=file_and_line(machine, resource.span),
                part=format_term(initial.term),
                note=context.noted or f"is no {resource.kind}",
                bindings=told_of(task.env, variables_in([initial.term])),
            )
    return _of_times(machine, task, context)


def _of_times(machine: Machine, task: Task, context: NotingContext) -> Cause | None:
    """Return which time of a task's windows or monitor is none."""
    context.task = task.parent
    env = {} if task.within is None else task.within.env
    step = task.step
    for window in () if step is None else step.windows:
        for time in (window.start, window.stop):
            if step is not None and time_of(context, time, env) is None:
                return Cause(
                    clause=f"window of step `{step.node.tag}`",
                    place=file_and_line(machine, step.node.span),
                    part=format_term(time.term),
                    note=context.noted,
                    bindings=told_of(env, variables_in([time.term])),
                )
    context.task = task
    delay, node = task.plan.monitor_time, task.plan.node.monitor_time
    for time in () if delay is None else (delay.start, delay.stop):
        if node is not None and time_of(context, time, task.env) is None:
            return Cause(
                clause=f"monitor-time of `{task.plan.name}`",
                place=file_and_line(machine, node.span),
                part=format_term(time.term),
                note=context.noted,
                bindings=told_of(task.env, variables_in([time.term])),
            )
    return None


def of_conditions(machine: Machine, task: Task) -> Cause | None:
    """Return which condition of a task does not hold now: the first, as they are asked.

    The order is that of step 4: `for` formulas, preconditions, constraints upwards.
    """
    if not machine.recorder.tells_causes:
        return None
    for clause, query, asker, env in conditions(task):
        found = _of_query(machine, clause, query, asker, env)
        if found is not None:
            return found
    return None


Condition = tuple[str, Query, Task, Env]
"""A clause in words, its query, the task that asks, and what is bound then."""


def conditions(task: Task) -> Iterator[Condition]:
    """Iterate over the conditions of a task in the order in which they are asked."""
    run, step, plan = task.within, task.step, task.plan
    if run is not None and step is not None:
        for carrier, query in step.conditions:
            if not run.was_ended_by_until(carrier):
                words = f"`for` formula of step `{run.plan.steps[carrier].node.tag}`"
                words += f" of `{run.task.plan.name}`"
                yield words, query, run.task, run.env
    for clause in clauses.RAP:
        own = clause.when == "select" and clause.required and not clause.inherited
        if own and clause.word in plan.clauses:
            words = f"{clause.word} of `{plan.name}`"
            yield words, plan.clauses[clause.word], task, task.env
    stated = task if plan.constraints is not None else task.constrained
    while stated is not None:
        if isinstance(stated, MethodRun):
            stated = stated.constrained_above
            continue
        if stated.plan.constraints is not None:
            words = f"constraints of `{stated.plan.name}`"
            yield words, stated.plan.constraints, stated, stated.env
        stated = stated.constrained


def of_method_constraints(machine: Machine, run: MethodRun) -> Cause | None:
    """Return why the constraints of a method do not hold."""
    if not machine.recorder.tells_causes or run.plan.constraints is None:
        return None
    clause = f"constraints of method `{run.plan.name}` of `{run.task.plan.name}`"
    return _of_query(machine, clause, run.plan.constraints, run.task, run.env)


# --- steps 5 to 9: what becomes of methods --------------------------------------


def of_no_method(machine: Machine, task: Task) -> Cause | None:
    """Return what ruled out each method of a task, and how the last one ended."""
    if not machine.recorder.tells_causes:
        return None
    plan = task.plan
    before = _last(task)
    if plan.repeat_while is not None:
        clause = f"repeat-while of `{plan.name}`"
        found = _of_query(machine, clause, plan.repeat_while, task, task.env)
        if found is not None:
            return following(found, before)
    ruled_out = []
    for method in machine.state.methods(plan):
        if method.choice is not None:
            clause = f"context of method `{method.name}`"
            found = _of_query(machine, clause, method.choice, task, task.env)
            if found is not None:
                ruled_out.append(found)
    asked = plan.name in machine.solvers
    cause = Cause(
        clause=f"methods of `{plan.name}`",
        place=file_and_line(machine, plan.node.name_span),
        note="none, from the solver neither" if asked else "" if ruled_out else "none",
        methods=tuple(ruled_out),
    )
    return following(cause, before)


def of_futile_choice(
    machine: Machine, task: Task, method: MethodPlan, found: Env
) -> Cause | None:
    """Return which choice a task has made as often as it may."""
    if not machine.recorder.tells_causes:
        return None
    env = {**task.env, **found}
    cause = Cause(
        clause=f"method `{method.name}` of `{task.plan.name}`",
        place=file_and_line(machine, method.node.span),
        note=f"chosen {machine.settings.futile_limit} times with the same bindings",
        bindings=told_of(env, env),
    )
    return following(cause, _last(task))


def of_recursion(machine: Machine, step: Task) -> Cause | None:
    """Return which ancestor has the goal that a step's task repeats."""
    if not machine.recorder.tells_causes or step.step is None:
        return None
    above = step.parent
    while above is not None and above.identity != step.identity:
        above = above.parent
    node = step.step.node
    who = "a task above it" if above is None else f"{above.goal()} [{above.number}]"
    return Cause(
        clause=f"step `{node.tag}`",
        place=file_and_line(machine, node.span),
        part=format_goal(node.goal),
        note=f"repeats {who}",
        bindings=told_of(
            step.within.env if step.within else {}, variables_in(node.goal.args)
        ),
    )


# --- ends of steps ----------------------------------------------------------------


def of_step_end(
    machine: Machine, task: Task, outputs: Mapping[str, object]
) -> Cause | None:
    """Return why a task whose `succeed` holds fails: its outputs or its effects."""
    step, run = task.step, task.within
    if not machine.recorder.tells_causes or step is None or run is None:
        return None
    bound = dict(run.env)
    for name, receiver in zip(task.plan.outputs, step.outputs, strict=False):
        value = outputs.get(name)
        if value is None or receiver.anonymous:
            continue
        if receiver.variable is not None and receiver.variable not in bound:
            bound[receiver.variable] = value  # type: ignore[assignment]  # a value
        elif receiver.term.needed(context_of(machine, run.task), bound) != value:
            return Cause(
                clause=f"outputs of step `{step.node.tag}` of `{run.task.plan.name}`",
                place=file_and_line(machine, step.node.span),
                part=format_term(receiver.term.term),
                note=f"is not `{format_atom(value)}`",
                bindings=told_of(bound, variables_in([receiver.term.term])),
            )
    names = [
        n for e in step.effects for n in variables_in([e.node.resource, e.node.amount])
    ]
    return Cause(
        clause=f"effects of step `{step.node.tag}` of `{run.task.plan.name}`",
        place=file_and_line(machine, step.node.span),
        note="one of them cannot be made",
        bindings=told_of(bound, names),
    )


def of_signal(machine: Machine, task: Task) -> Cause | None:
    """Return which step a signal has failed."""
    if not machine.recorder.tells_causes or task.step is None:
        return None
    node = task.step.node
    return Cause(
        clause=f"wait-for of step `{node.tag}`",
        place=file_and_line(machine, node.span),
        note="its signal came",
    )


def of_child(
    machine: Machine, task: Task, result: str, because: Cause | None
) -> Cause | None:
    """Return why a method has ended badly one of whose steps has failed."""
    step = task.step
    if not machine.recorder.tells_causes or step is None or task.parent is None:
        return None
    link = Cause(
        clause=f"step `{step.node.tag}` of `{task.parent.plan.name}`",
        place=file_and_line(machine, step.node.span),
        part=str(task.goal()),
        note=f"failed: {result}",
        task=task.number,
    )
    return following(link, because)


# --- chains and parts -------------------------------------------------------------


def following(link: Cause, because: Cause | None) -> Cause:
    """Return a cause with what it came from; a long chain loses its middle."""
    if because is None:
        return link
    chain = [because]
    while chain[-1].because is not None:
        chain.append(chain[-1].because)
    if len(chain) < LONGEST:
        return msgspec.structs.replace(link, because=because)
    skipped = len(chain) - 1 + sum(one.skipped for one in chain)
    return msgspec.structs.replace(link, because=chain[-1], skipped=skipped)


def _last(task: Task) -> Cause | None:
    """Return why the last method of a task has ended badly, if it has."""
    return None if task.history is None else task.history.because


def _of_query(
    machine: Machine, clause: str, query: Query, asker: Task, env: Env
) -> Cause | None:
    """Return which part of a query has no solution; None if all of it has one."""
    bound: Mapping[str, object] = env
    for part, text, found in ask_in_parts(machine, query, asker, env, most=1):
        if not found:
            names = [n for n in Query.names(part) if n in bound]
            given_up = machine.context.told_if_given_up(query.where)
            return Cause(
                clause=clause,
                place=file_and_line(machine, part.span)
                or file_and_line(machine, query.formula.span),
                part=text,
                note=given_up or machine.noting.noted,
                bindings=told_of(bound, names),
            )
        bound = {**env, **found[0]}
    return None


class PartAsked(NamedTuple):
    """A conjunct of a query, and solutions of all conjuncts up to it."""

    part: nodes.Formula
    text: str
    solutions: list[dict[str, Value]]


def ask_in_parts(
    machine: Machine, query: Query, asker: Task | None, env: Env, most: int
) -> Iterator[PartAsked]:
    """Ask a query conjunct by conjunct, to the first without a solution.

    It leaves no mark on the run. What is wrong with a conjunct that fails, where there
    is more to say, is in `machine.noting.noted`.

    Args:
        machine: the run's.
        query: what is asked.
        asker: the task that would ask; None for a user.
        env: what is bound beforehand.
        most: how many solutions are looked for.
    """
    context = context_of(machine, asker)
    for part, up_to_it, text in query.beginnings():
        context.go_on()
        if most == 1:
            first = up_to_it.first(context, env)
            found = [] if first is None else [first]
        else:
            found = list(islice(up_to_it.solutions(context, env), most))
        yield PartAsked(part, text, found)
        if not found:
            return


def context_of(machine: Machine, asker: Task | None) -> NotingContext:
    """Return what asks as a task would, and tells nobody."""
    context = machine.noting
    context.begin(asker)
    return context


def file_and_line(machine: Machine, span: Span) -> str:
    """Return the file and line of `span`, or nothing for one that has none."""
    return machine.library.compiler.row(span)


def variables_in(terms: Iterable[nodes.Term]) -> list[str]:
    """Return the names of the variables in `terms`."""
    parts = (part for term in terms for part in subterms(term))
    return [part.name for part in parts if isinstance(part, nodes.Var)]


def told_of(env: Mapping[str, object], names: Iterable[str]) -> Mapping[str, str]:
    """Return the values that variables have, as text."""
    return {name: format_atom(env[name]) for name in names if name in env}
