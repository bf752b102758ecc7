"""A linked library in executable form: RAPs, methods and steps.

A RAP is compiled when a task first needs it; its queries are compiled at their first
use. Each plan keeps its IR node, so that run-time events can name the source position.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rapc.base.source import Span
from rapc.compiler.compiler import Compiler, RequestPlan
from rapc.compiler.net_plan import StepPlan, WaitPlan, WindowPlan, steps_of, steps_using
from rapc.compiler.query.formulas import watches
from rapc.compiler.query.named import parts_of
from rapc.compiler.query.query import Query
from rapc.compiler.query.term_value import TermValue
from rapc.compiler.rules import memory_rules
from rapc.compiler.watches import ANYTHING, Watch
from rapc.ir import clauses, nodes
from rapc.ir.walk import substitute, variable_names


class ThingPlan:
    """A thing with arguments to compute; `used` by the request, or else claimed."""

    def __init__(self, plan: RequestPlan, used: bool) -> None:
        self.plan = plan
        self.used = used


def things_of(compiler: Compiler, method: nodes.Method) -> tuple[ThingPlan, ...]:
    """Return the things of `method`: used by its request, then claimed."""
    found = [
        (thing, True)
        for asked in requests_of(method)
        for thing in _used_by(compiler, asked)
    ]
    found += [(thing, False) for thing in method.claims]
    return tuple(
        [
            ThingPlan(compiler.assertion(one, "use" if used else "claim"), used)
            for one, used in found
        ]
    )


def _used_by(compiler: Compiler, asked: nodes.Pattern) -> Iterator[nodes.Thing]:
    """Yield the declared things of a request or a skill."""
    declared: nodes.DeclarePrimitive | nodes.DeclareSkill | None
    if isinstance(asked, nodes.Skill):
        declared = compiler.library.skills.get(asked.name)
    else:
        declared = compiler.library.primitives.get(asked.name)
    if declared is None:
        return
    names = [arg.variable.name for arg in declared.args]
    given = dict(zip(names, asked.args, strict=False))
    for thing in declared.uses:
        yield substitute(thing, given)


def requests_of(method: nodes.Method) -> tuple[nodes.Pattern, ...]:
    """Return the requests of a method to the world: a request, or skills."""
    if isinstance(method.body, nodes.Primitive):
        return (method.body.request,)
    if isinstance(method.body, nodes.Skills):
        return method.body.enable
    return method.skills


class UsesPlan:
    """The things of a skill, over the arguments of its declaration."""

    def __init__(self, compiler: Compiler, name: str) -> None:
        declared = compiler.library.skills.get(name)
        #: The names of the declared arguments.
        self.args: tuple[str, ...] = ()
        #: The things, to be computed with the values of these arguments.
        self.things: tuple[RequestPlan, ...] = ()
        if declared is not None:
            self.args = tuple([arg.variable.name for arg in declared.args])
            things = [compiler.assertion(one, "use") for one in declared.uses]
            self.things = tuple(things)


class ActivationPlan:
    """A set of skills that are active together."""

    def __init__(
        self,
        compiler: Compiler,
        enabled: tuple[nodes.Skill, ...],
        waits: tuple[nodes.WaitFor, ...],
        background: bool,
    ) -> None:
        #: The skills, with arguments to compute, in the order of the text.
        self.skills = tuple([compiler.assertion(one, "skill") for one in enabled])
        #: The declared things of each skill.
        self.uses = tuple([UsesPlan(compiler, one.name) for one in enabled])
        #: The signals that end the method: the first that matches counts.
        self.waits = tuple(
            [WaitPlan(wait, compiler.place("wait-for", wait.span)) for wait in waits]
        )
        #: Whether the activation runs beside the steps of its method: the `skills` of a
        #: method.
        self.background = background
        #: The names of the events to report: all signals that the skills may send
        #: (rules receive signals that no task awaits), then the other awaited signals.
        self.events = _events(compiler, self.skills, self.waits)


def _events(
    compiler: Compiler, skills: tuple[RequestPlan, ...], waits: tuple[WaitPlan, ...]
) -> tuple[str, ...]:
    found: dict[str, None] = {}
    for skill in skills:
        declared = compiler.library.skills.get(skill.name)
        if declared is not None:
            found.update(dict.fromkeys(declared.events or ()))
    found.update(dict.fromkeys(wait.signal for wait in waits))
    return tuple(found)


def activation_of(compiler: Compiler, method: nodes.Method) -> ActivationPlan | None:
    """Return the activation of a method, or None if it activates nothing."""
    body = method.body
    if isinstance(body, nodes.Skills):
        return ActivationPlan(compiler, body.enable, body.waits, background=False)
    if method.skills:
        return ActivationPlan(compiler, method.skills, (), background=True)
    return None


class MethodPlan:
    """A method of a RAP, ready for choice and execution."""

    def __init__(
        self, compiler: Compiler, rap: nodes.DefineRap, node: nodes.Method, index: int
    ) -> None:
        self.node = node
        #: Its position in the order of choice.
        self.index = index
        #: Identifies the method among the methods of its RAP.
        self.key = (index,)
        #: The name in the trace.
        self.name = f"#{index + 1}" if node.name is None else str(node.name)
        context = _without_otherwise(node.context)
        #: Whether the context requires that the context of no preceding method holds.
        self.otherwise = context is not node.context
        #: `repeat-while` and context, without `otherwise`, as one query.
        self.choice = _choice(
            compiler, (rap.repeat_while, context), self.name, node.span
        )
        #: The constraint on all descendant tasks while the method is active.
        self.constraints: Query | None = None
        if node.constraints is not None:
            what = f"constraints of method `{self.name}`"
            self.constraints = compiler.query(node.constraints, what, node.span)
        self.notations = tuple(
            compiler.assertion(p, "notation") for p in node.notations
        )
        self.request: RequestPlan | None = None
        self.steps: tuple[StepPlan, ...] = ()
        if isinstance(node.body, nodes.Primitive):
            self.request = compiler.assertion(node.body.request, "primitive")
        elif isinstance(node.body, nodes.TaskNet):
            self.steps = steps_of(compiler, node.body)
        #: The skills that the method activates.
        self.activation: ActivationPlan | None = activation_of(compiler, node)
        #: The things that the method requests before it starts.
        self.things: tuple[ThingPlan, ...] = things_of(compiler, node)
        #: Whether the requested things depend on the solution of the choice [L 8.30].
        self.things_vary = bool(self.things) and _depends_on_choice(rap, node)
        #: Whether the end of the method releases anything except things: notations,
        #: skills, the goal key of a task for the test of recursion.
        self.gives_back = (
            bool(self.notations)
            or self.activation is not None
            or compiler.recursion.covers(rap.name)
        )
        self._sum_up_steps()

    def _sum_up_steps(self) -> None:
        """Compute properties of all steps together, to avoid loops at run time."""
        #: The positions of the steps whose inputs or windows use a variable.
        self.steps_by_variable = steps_using(self.steps)
        #: The steps with their RAPs, once these have been looked up.
        self.goals: tuple[tuple[StepPlan, RapPlan], ...] = ()
        #: Whether inputs of steps create values, once the RAPs are known.
        self.makes = False
        #: Whether the goal key of each step's task is constant, as above.
        self.static_goals = False
        #: Whether steps may add to the environment of the method.
        self.binds = any(s.outputs or s.conditions or s.waits for s in self.steps)
        self.binds |= self.activation is not None and bool(self.activation.waits)
        #: The positions of the steps without predecessor, or with windows to fix.
        self.first_steps = tuple(
            [s.position for s in self.steps if s.windows or not s.before]
        )
        #: Whether any step is the target of `for` formulas.
        self.conditions = any(step.conditions for step in self.steps)
        #: Whether any step has time windows.
        self.windows = any(step.windows for step in self.steps)
        #: Whether inputs of steps are computed.
        self.computes = any(step.computes for step in self.steps)
        #: Whether anything depends on the time and the kind of the ends of steps.
        self.tracks_step_ends = any(step.until for step in self.steps) or any(
            isinstance(window.reference, int)
            for step in self.steps
            for window in step.windows
        )


class RapPlan:
    """A RAP ready to be instantiated."""

    def __init__(self, compiler: Compiler, node: nodes.DefineRap) -> None:
        self.node = node
        self.name = node.name
        self.inputs = tuple(v.name for v in node.inputs)
        #: Whether any input or output has a declared kind.
        self.kinds = bool(node.kinds)
        self.outputs = tuple(v.name for v in node.outputs)
        #: Whether a task remembers more than the result of a successful method.
        self.notes_success = bool(node.outputs or node.plan)
        #: The goal key of a task without inputs: see `Task.goal_key`.
        self.goal_key = (node.name,)
        #: The clauses of the RAP, by keyword.
        self.clauses = {
            clause.word: compiler.query(formula, clause.word, node.span)
            for clause, formula in clauses.held(clauses.RAP, node)
        }
        #: None without a clause: `(last-result okay)`.
        self.succeed = self.clauses.get("succeed")
        #: Whether `succeed` can never hold.
        self.never_succeeds = (
            isinstance(node.succeed, nodes.Truth) and not node.succeed.value
        )
        self.preconditions = self.clauses.get("preconditions")
        self.constraints = self.clauses.get("constraints")
        self.repeat_while = self.clauses.get("repeat-while")
        self.monitor_state = self.clauses.get("monitor-state")
        self.watches: tuple[Watch, ...] = ()
        #: Whether `monitor-state` depends on the age of beliefs.
        self.ages = False
        if node.monitor_state is not None:
            asked = parts_of(node.monitor_state, compiler.signatures)
            self.ages = any(isinstance(part, nodes.Believe) for part in asked)
            self.watches = watches(node.monitor_state, compiler.signatures)
        #: Whether constraints depend only on memory, resources and the clock.
        self.steady = _steady(compiler, node.constraints)
        #: The rules that run at the end of its task, and at a signal.
        self.finish_rules = memory_rules(compiler, node.name, "finish")
        self.event_rules = memory_rules(compiler, node.name, "event")
        self.monitor_time: WindowPlan | None = None
        if node.monitor_time is not None:
            time = node.monitor_time
            where = compiler.place("monitor-time", time.span)
            start, stop = TermValue(time.start, where), TermValue(time.stop, where)
            self.monitor_time = WindowPlan(time.reference, start, stop)
        where = compiler.place("duration", node.span)
        self.duration = TermValue(node.duration, where) if node.duration else None
        self.resources = _resources(compiler, node)
        #: Whether the duration has variables of the preconditions.
        self.duration_asks = bool(
            node.duration
            and node.preconditions
            and set(variable_names(node.duration)).difference(
                self.inputs, [one.variable.name for one in node.resources]
            )
        )
        self.prepared_from = _used(node)
        #: Whether there is a monitor clause.
        self.monitored = bool(node.monitor_state or node.monitor_time)
        #: Whether there are preconditions or constraints.
        self.conditional = bool(node.preconditions or node.constraints)
        #: Whether resources, a duration or a monitor time depend on the inputs.
        self.needs_setup = bool(node.resources or node.duration or node.monitor_time)
        #: Whether its tasks need a record of their wait conditions.
        self.needs_wait_state = self.monitored or self.needs_setup
        #: Whether the RAP can occur among its own subtasks.
        self.recursive = compiler.recursion.covers(node.name)
        #: The goal key, if it is constant and needs no test.
        self.static_goal_key = None if self.inputs or self.recursive else self.goal_key
        self.methods = tuple(
            MethodPlan(compiler, node, method, index)
            for index, method in enumerate(node.methods)
        )
        #: The only method, if its choice depends on its context alone.
        self.sole: MethodPlan | None = None
        if (
            len(self.methods) == 1
            and node.plan is None
            and self.repeat_while is None
            and not self.methods[0].things_vary
        ):
            self.sole = self.methods[0]


def _resources(
    compiler: Compiler, node: nodes.DefineRap
) -> tuple[tuple[nodes.Resource, TermValue | None], ...]:
    """Return the resources of a RAP, each with its initial value, if any."""
    return tuple(
        (r, TermValue(r.initial, compiler.place("resources", r.span)))
        if r.initial is not None
        else (r, None)
        for r in node.resources
    )


def _choice(
    compiler: Compiler,
    formulas: Sequence[nodes.Formula | None],
    method: str,
    span: Span,
) -> Query | None:
    """Return the conjunction of the formulas that are not None."""
    parts = [formula for formula in formulas if formula is not None]
    if not parts:
        return None
    formula = parts[0] if len(parts) == 1 else nodes.And(tuple(parts))
    return compiler.query(formula, f"context of method `{method}`", span)


def _depends_on_choice(rap: nodes.DefineRap, method: nodes.Method) -> bool:
    """Return whether claims, request or skills use variables that the choice binds."""
    given = {one.name for one in rap.inputs}
    given.update(one.variable.name for one in rap.resources)
    chosen = (rap.repeat_while, method.context)
    bound = set(variable_names(*[one for one in chosen if one is not None])) - given
    asked: tuple[nodes.Pattern, ...] = (*method.claims, *method.skills)
    if isinstance(method.body, nodes.Primitive):
        asked += (method.body.request,)
    elif isinstance(method.body, nodes.Skills):
        asked += method.body.enable
    return not bound.isdisjoint(variable_names(*asked))


def _without_otherwise(context: nodes.Formula | None) -> nodes.Formula | None:
    """Return a context, without `otherwise` if that is one of its conjuncts."""
    if isinstance(context, nodes.Otherwise):
        return None
    if not isinstance(context, nodes.And):
        return context
    kept = [_without_otherwise(part) for part in context.parts]
    if all(one is part for one, part in zip(kept, context.parts, strict=True)):
        return context
    return nodes.And(tuple([one for one in kept if one is not None]), span=context.span)


def _steady(compiler: Compiler, constraints: nodes.Formula | None) -> bool:
    """Return whether each change of the formula's result is reported to watches."""
    if constraints is None:
        return True
    asked = watches(constraints, compiler.signatures)
    return all(watch.key != ANYTHING for watch in asked) and not any(
        isinstance(part, nodes.HistoryTest)
        for part in parts_of(constraints, compiler.signatures)
    )


def _used(node: nodes.DefineRap) -> frozenset[str]:
    """Return the variables in resources, duration and delay of a RAP."""
    used = [r.initial for r in node.resources if r.initial is not None]
    used += [node.duration] if node.duration is not None else []
    if node.monitor_time is not None:
        used += [node.monitor_time.start, node.monitor_time.stop]
    return frozenset(variable_names(*used))
