"""Causes: why a task or a method has failed, computed afterwards, as a chain.

The name of a failure (`interference`, `no-method`) states the rule that failed the task
[L 3]. The cause states the clause, its position, and its part without a solution. To
find the cause, the interpreter evaluates the clause again, at once and before anything
changes, in a context without listeners: the run is the same with and without causes.
The interpreter computes causes only if events report them (`Recorder.tells_causes`).

Not here: the text of a cause (`rapc.runtime.events.report`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import islice
from typing import Concatenate, NamedTuple, ParamSpec

import msgspec

from rapc.base.resources import Counter, SetResource, Value
from rapc.base.source import Span
from rapc.base.values import format_atom
from rapc.compiler.compiler import RequestPlan
from rapc.compiler.query.query import Query
from rapc.compiler.query.term_value import TermValue
from rapc.compiler.rap_plan import MethodPlan
from rapc.errors import FactError
from rapc.events import Cause, KnownFact
from rapc.ir import clauses, nodes
from rapc.ir.printer import format_formula, format_goal, format_node, format_term
from rapc.ir.walk import subterms
from rapc.runtime.memory.access import Evidence
from rapc.runtime.query_context import QueryContext, time_of
from rapc.runtime.run import Run
from rapc.runtime.state.task import Env, MethodRun, Task
from rapc.runtime.tasks.evidence import opposing

LONGEST = 16
"""The highest number of links in a chain of causes; longer chains lose their middle."""

_Args = ParamSpec("_Args")

_Find = Callable[Concatenate[Run, _Args], Cause | None]


def _if_told(find: _Find[_Args]) -> _Find[_Args]:
    """Return `find` as a function that runs only if events report causes."""

    def found(run: Run, /, *args: _Args.args, **more: _Args.kwargs) -> Cause | None:
        return find(run, *args, **more) if run.recorder.tells_causes else None

    return found


# --- steps 1 to 4: inputs, resources and conditions -----------------------------


@_if_told
def of_inputs(run: Run, task: Task) -> Cause | None:
    """Return the cause of a failure by unbound inputs."""
    step, method_run = task.step, task.within
    if step is None or method_run is None:
        return None
    goal = step.node.goal
    values = zip(goal.args, task.goal_args, strict=True)
    unbound = [format_term(term) for term, value in values if value is None]
    clause = f"inputs of step `{step.node.tag}` of `{method_run.task.plan.name}`"
    note = f"{', '.join(unbound)} not bound"
    part = format_goal(goal)
    return _cause(run, clause, step.node.span, part, note, method_run.env, goal.args)


@_if_told
def of_set_up(run: Run, task: Task) -> Cause | None:
    """Return the reason why a task has no resources or times."""
    context, env, name = context_of(run, task), task.env, task.plan.name
    if task.wait is not None and task.wait.over_limit:
        first, most = task.plan.node.resources[0], run.settings.max_resources
        note = f"more than {most} sets and counters (`rapc.max-resources`)"
        part = format_node(first)
        return _cause(run, f"resources of `{name}`", first.span, part, note, env)
    for resource, initial in task.plan.resources:
        made = env.get(resource.variable.name)
        if initial is not None and not isinstance(made, Counter | SetResource):
            initial.needed(context, env)
            note = context.noted or f"is no {resource.kind}"
            clause = f"resources of `{name}`"
            return _of_term(run, clause, resource.span, initial, note, env)
    context.task = task.parent
    above: Env = {} if task.within is None else task.within.env
    step = task.step
    for window in () if step is None else step.windows:
        for time in (window.start, window.stop):
            if step is not None and time_of(context, time, above) is None:
                clause, span = f"window of step `{step.node.tag}`", step.node.span
                return _of_term(run, clause, span, time, context.noted, above)
    context.task = task
    delay, node = task.plan.monitor_time, task.plan.node.monitor_time
    for time in () if delay is None else (delay.start, delay.stop):
        if node is not None and time_of(context, time, env) is None:
            clause = f"monitor-time of `{name}`"
            return _of_term(run, clause, node.span, time, context.noted, env)
    return None


def _of_term(
    run: Run, clause: str, span: Span, value: TermValue, note: str, env: Env
) -> Cause:
    part = format_term(value.term)
    return _cause(run, clause, span, part, note, env, [value.term])


@_if_told
def of_conditions(run: Run, task: Task) -> Cause | None:
    """Return the first condition of a task that does not hold now.

    The order is that of step 4: `for` formulas, preconditions, constraints upwards.
    """
    for clause, query, asker, env in conditions(task):
        found = _of_query(run, clause, query, asker, env)
        if found is not None:
            return found
    return None


Condition = tuple[str, Query, Task, Env]
"""A clause as text, its query, the task that evaluates it, and the bindings."""


def conditions(task: Task) -> Iterator[Condition]:
    """Iterate over the conditions of a task in the order of evaluation."""
    method_run, step, plan = task.within, task.step, task.plan
    if method_run is not None and step is not None:
        for carrier, query in step.conditions:
            if not method_run.was_ended_by_until(carrier):
                words = (
                    f"`for` formula of step `{method_run.plan.steps[carrier].node.tag}`"
                )
                words += f" of `{method_run.task.plan.name}`"
                yield words, query, method_run.task, method_run.env
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


@_if_told
def of_method_constraints(run: Run, method_run: MethodRun) -> Cause | None:
    """Return the reason why the constraints of a method do not hold."""
    plan, task = method_run.plan, method_run.task
    if plan.constraints is None:
        return None
    clause = f"constraints of method `{plan.name}` of `{task.plan.name}`"
    return _of_query(run, clause, plan.constraints, task, method_run.env)


# --- steps 5 to 9: methods --------------------------------------------------------


@_if_told
def of_no_method(run: Run, task: Task) -> Cause | None:
    """Return the obstacles of each method of a task, and the last method's failure."""
    plan, before = task.plan, _last(task)
    if plan.repeat_while is not None:
        clause = f"repeat-while of `{plan.name}`"
        found = _of_query(run, clause, plan.repeat_while, task, task.env)
        if found is not None:
            return following(found, before)
    methods = _excluded(run, task)
    asked = plan.name in run.solvers
    note = "none, from the solver neither" if asked else "" if methods else "none"
    if run.planned is not None and run.planned[0] is task:
        planned = run.planned[1]
        missing = ", ".join(planned.unreachable)
        reason = f"nothing brings about {missing}" if missing else planned.outcome
        note = f"no plan: {reason}"
    cause = _cause(run, f"methods of `{plan.name}`", plan.node.name_span, note=note)
    return following(msgspec.structs.replace(cause, methods=methods), before)


def _excluded(run: Run, task: Task) -> tuple[Cause, ...]:
    """Return the reason against each method of a task whose context does not hold."""
    found = []
    for method in run.state.methods(task.plan):
        if method.choice is not None:
            clause = f"context of method `{method.name}`"
            found.append(_of_query(run, clause, method.choice, task, task.env))
    return tuple([one for one in found if one is not None])


@_if_told
def of_futile_choice(
    run: Run, task: Task, method: MethodPlan, found: Env
) -> Cause | None:
    """Return the choice that a task has repeated too often, with excluded methods."""
    clause = f"method `{method.name}` of `{task.plan.name}`"
    note = f"chosen {run.settings.futile_limit} times with the same bindings"
    env = {**task.env, **found}
    cause = _cause(run, clause, method.node.span, note=note, env=env)
    methods = _excluded(run, task)
    return following(msgspec.structs.replace(cause, methods=methods), _last(task))


@_if_told
def of_recursion(run: Run, step: Task) -> Cause | None:
    """Return the ancestor whose goal a step's task repeats."""
    if step.step is None:
        return None
    above = step.parent
    while above is not None and above.goal_key != step.goal_key:
        above = above.parent
    node = step.step.node
    who = "a task above it" if above is None else f"{above.goal()} [{above.number}]"
    clause, note, part = f"step `{node.tag}`", f"repeats {who}", format_goal(node.goal)
    env = step.within.env if step.within else {}
    return _cause(run, clause, node.span, part, note, env, node.goal.args)


# --- ends of steps ----------------------------------------------------------------


@_if_told
def of_step_end(run: Run, task: Task, outputs: Mapping[str, Value]) -> Cause | None:
    """Return the cause of a failure in the outputs or effects of a successful task."""
    step, method_run = task.step, task.within
    if step is None or method_run is None:
        return None
    where = f"of step `{step.node.tag}` of `{method_run.task.plan.name}`"
    bound = dict(method_run.env)
    for name, receiver in zip(task.plan.outputs, step.outputs, strict=False):
        value = outputs.get(name)
        if value is None or receiver.anonymous:
            continue
        if receiver.variable is not None and receiver.variable not in bound:
            bound[receiver.variable] = value
        elif receiver.term.needed(context_of(run, method_run.task), bound) != value:
            clause, note = f"outputs {where}", f"is not `{format_atom(value)}`"
            span = step.node.span
            return _of_term(run, clause, span, receiver.term, note, bound)
    terms = [t for e in step.effects for t in (e.node.resource, e.node.amount)]
    clause, note = f"effects {where}", "one of them cannot be made"
    return _cause(run, clause, step.node.span, "", note, bound, terms)


@_if_told
def of_signal(run: Run, task: Task) -> Cause | None:
    """Return the step that a signal has failed."""
    if task.step is None:
        return None
    node = task.step.node
    clause = f"wait-for of step `{node.tag}`"
    return _cause(run, clause, node.span, note="its signal came")


@_if_told
def of_child(run: Run, task: Task, result: str, because: Cause | None) -> Cause | None:
    """Return the cause of a method's failure by a failed step."""
    step = task.step
    if step is None or task.parent is None:
        return None
    clause = f"step `{step.node.tag}` of `{task.parent.plan.name}`"
    goal, note = str(task.goal()), f"failed: {result}"
    link = _cause(run, clause, step.node.span, goal, note)
    return following(msgspec.structs.replace(link, task=task.number), because)


# --- methods that end by themselves -----------------------------------------------


@_if_told
def of_bad_start(run: Run, method_run: MethodRun) -> Cause | None:
    """Return the notation of a method that cannot be asserted, or the invalid claim."""
    for plan in method_run.plan.notations:
        note = _unfilled(run, method_run, plan) or _refusal(run, method_run, plan)
        if note:
            return _of_method(run, method_run, "notation", plan.node, note)
    for asked in method_run.plan.things:
        note = "" if asked.used else _unfilled(run, method_run, asked.plan)
        if note:
            what = f"claims of method `{method_run.plan.name}`"
            return _of_method(run, method_run, what, asked.plan.node, note)
    return None


@_if_told
def of_result(run: Run, method_run: MethodRun, result: str) -> Cause | None:
    """Return the cause of the failure of a method with a request or skills.

    The cause is a request or a skill that cannot be filled in, the result from the
    world, or an event that fails the primitive.
    """
    plan, skills = method_run.plan.request, method_run.plan.activation
    asked = [] if skills is None else list(skills.skills)
    asked += [] if plan is None else [plan]
    for one in asked if method_run.ticket is None else ():
        note = _unfilled(run, method_run, one, sent=True)
        if note:
            what = "request" if one is plan else "skill"
            return _of_method(run, method_run, what, one.node, note)
    if plan is not None:
        note = f"the world answered `{result}`"
        return _of_method(run, method_run, "primitive", plan.node, note)
    body = method_run.plan.node.body
    for wait in body.waits if isinstance(body, nodes.Skills) else ():
        if wait.mode == "fail" and wait.signal == f":{result}":
            signal = nodes.Signal(wait.signal, wait.args, span=wait.span)
            return _of_method(run, method_run, "wait-for", signal, "its event came")
    return None


@_if_told
def of_refusal(run: Run, method_run: MethodRun, reason: str) -> Cause | None:
    """Return the world's refusal in a conflict that the method cannot wait for."""
    plan, skills = method_run.plan.request, method_run.plan.activation
    asked = plan if skills is None else skills.skills[0]
    if asked is None:
        return None
    what = "primitive" if skills is None else "skill"
    note = "the world refused it, and nothing could be waited for"
    if reason:
        note = f"the world refused it: {reason}"
    return _of_method(run, method_run, what, asked.node, note)


def _of_method(
    run: Run, method_run: MethodRun, what: str, node: nodes.Pattern, note: str
) -> Cause:
    clause, part = f"{what} of `{method_run.task.plan.name}`", format_formula(node)
    return _cause(run, clause, node.span, part, note, method_run.env, node.args)


def _unfilled(
    run: Run, method_run: MethodRun, plan: RequestPlan, sent: bool = False
) -> str:
    """Return the obstacle to filling in a clause; empty if there is none.

    With `sent` its items need sensor names.
    """
    context, items = context_of(run, method_run.task), run.beliefs.items
    for arg in plan.args:
        value = arg.needed(context, method_run.env)
        if value is None:
            return context.noted
        if isinstance(value, Counter | SetResource):
            return f"{format_term(arg.term)} is a resource"
        if sent and isinstance(value, str) and items.sensor_of(value) is None:
            return f"`{format_atom(value)}` has no sensor name now"
    return ""


def _refusal(run: Run, method_run: MethodRun, plan: RequestPlan) -> str:
    """Return the reason why memory refuses a notation that is filled in, if any."""
    context = context_of(run, method_run.task)
    filled = [arg.needed(context, method_run.env) for arg in plan.args]
    try:
        run.beliefs.checked((plan.name, *filled))  # type: ignore[arg-type]  # atoms
    except FactError as error:
        return str(error)
    return ""


# --- chains and parts -------------------------------------------------------------


def _cause(
    run: Run,
    clause: str,
    span: Span,
    part: str = "",
    note: str = "",
    env: Mapping[str, Value] = {},  # read only
    terms: Iterable[nodes.Term] | None = None,
) -> Cause:
    """Return a cause with the values of the variables of `terms`, or of all."""
    names: Iterable[str] = env
    if terms is not None:
        parts = [inner for term in terms for inner in subterms(term)]
        names = [inner.name for inner in parts if isinstance(inner, nodes.Var)]
    return Cause(
        clause=clause,
        place=run.library.compiler.row(span),
        part=part,
        note=note,
        bindings=_as_text(env, names),
    )


def following(link: Cause, because: Cause | None) -> Cause:
    """Return a cause with the cause before; a long chain loses its middle."""
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
    """Return the cause of the failure of the last method of a task, if any."""
    return None if task.history is None else task.history.because


def _of_query(
    run: Run, clause: str, query: Query, asker: Task, env: Env
) -> Cause | None:
    """Return the part of a query without a solution; None if a solution exists."""
    bound, row = env, run.library.compiler.row
    for part, text, found, note in ask_in_parts(run, query, asker, env, most=1):
        if not found:
            given_up = run.context.told_if_given_up(query.where)
            return Cause(
                clause=clause,
                place=row(part.span) or row(query.formula.span),
                part=text,
                note=given_up or note,
                bindings=_as_text(bound, Query.names(part)),
                facts=_known(run, opposing(run, part, bound)),
                inside=_inside(run, part, asker, bound),
            )
        bound = {**env, **found[0]}
    return None


def _inside(run: Run, part: nodes.Formula, asker: Task, env: Env) -> tuple[Cause, ...]:
    """Return the causes inside a part: of a named query, or of the branches of `or`."""
    found = [
        _of_query(run, words, query, asker, inner)
        for words, query, inner in run.library.opened(part, env)
    ]
    return tuple([one for one in found if one is not None])


def _known(run: Run, found: Evidence) -> tuple[KnownFact, ...]:
    """Return facts with their ages."""
    now = run.recorder.time
    return tuple([KnownFact.at(now, *one) for one in found.items()])


def _as_text(env: Mapping[str, Value], names: Iterable[str]) -> Mapping[str, str]:
    """Return the values of variables as text."""
    return {name: format_atom(env[name]) for name in names if name in env}


class PartAsked(NamedTuple):
    """A conjunct of a query, and solutions of all conjuncts up to the conjunct."""

    part: nodes.Formula
    text: str
    solutions: list[dict[str, Value]]
    #: The reason for a failure of the evaluation; may be empty.
    note: str


def ask_in_parts(
    run: Run, query: Query, asker: Task | None, env: Env, most: int
) -> Iterator[PartAsked]:
    """Evaluate a query conjunct by conjunct, to the first without a solution.

    The evaluation does not change the run.

    Args:
        run: the run.
        query: the query.
        asker: the task that evaluates the query; None for a user.
        env: the bindings before the evaluation.
        most: the highest number of solutions to find.
    """
    context = context_of(run, asker)
    for part, up_to_it, text in query.beginnings():
        context.next_part()
        if most == 1:
            first = up_to_it.first(context, env)
            found = [] if first is None else [first]
        else:
            found = list(islice(up_to_it.solutions(context, env), most))
        yield PartAsked(part, text, found, context.noted)
        if not found:
            return


def context_of(run: Run, asker: Task | None) -> QueryContext:
    """Return a context that evaluates queries for a task, without listeners."""
    context = run.explaining_context
    context.begin(asker)
    return context
