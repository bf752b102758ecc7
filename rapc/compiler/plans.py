"""A linked library in executable form: RAPs, methods and steps ready to run.

A RAP is compiled when a task first needs it; its queries when they are first asked.
Everything keeps its IR node, so that what happens at run time can point at source.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from rapc.compiler.dependencies import Watch, watches
from rapc.compiler.query import Query, TermValue
from rapc.compiler.recursion import recursive
from rapc.compiler.vocabulary import Vocabulary
from rapc.ir import nodes
from rapc.ir.walk import subformulas, subterms
from rapc.library import Library
from rapc.source import Span


class StepPlan:
    """A step: what its task asks for, and how it is ordered among its siblings.

    `before` counts the steps that must have ended first, `after` are the positions of
    those that wait for this one, each once; `conditions`
    the `for` formulas that point at this step, each with the position of the step
    that carries it; both in the order of the text. `rap` is the RAP it asks for, once
    that has been looked up. `timed` says whether more than order decides when it runs,
    or its start ends others.
    """

    __slots__ = (
        "after",
        "args",
        "before",
        "computes",
        "conditions",
        "effects",
        "node",
        "outputs",
        "position",
        "priority",
        "rap",
        "timed",
        "until",
        "waits",
        "windows",
    )

    def __init__(self, compiler: Compiler, node: nodes.Step, position: int) -> None:
        self.node = node
        self.position = position
        self.priority = node.priority
        where = compiler.place(f"step `{node.tag}`", node.span)
        self.args = tuple(TermValue(arg, where) for arg in node.goal.args)
        self.computes = any(isinstance(arg, nodes.Call) for arg in node.goal.args)
        self.outputs = tuple(ReceiverPlan(out, where) for out in node.goal.outputs)
        self.before = 0
        self.after: list[int] = []
        self.conditions: list[tuple[int, Query]] = []
        self.until: list[tuple[int, bool]] = []
        self.windows: tuple[WindowPlan, ...] = ()
        self.effects: list[EffectPlan] = []
        self.waits: list[WaitPlan] = []
        self.rap: RapPlan | None = None
        self.timed = False


class ReceiverPlan:
    """What a value that arrives meets: it binds a variable or is compared."""

    __slots__ = ("anonymous", "term", "variable")

    def __init__(self, term: nodes.Term, where: str) -> None:
        self.term = TermValue(term, where)
        self.variable = term.name if isinstance(term, nodes.Var) else None
        self.anonymous = isinstance(term, nodes.Var) and term.anonymous


class WaitPlan:
    """A `wait-for` of a step: the signal, what it brings, and what it does."""

    __slots__ = ("args", "mode", "pattern", "signal")

    def __init__(self, node: nodes.WaitFor, where: str) -> None:
        self.signal = node.signal
        self.pattern = nodes.Pattern(node.signal, node.args)
        self.mode = node.mode
        self.args = tuple(ReceiverPlan(arg, where) for arg in node.args)


class WindowPlan:
    """A time window: `reference` is `now`, `absolute` or the position of a step.

    `uses` are the variables in its times.
    """

    __slots__ = ("reference", "start", "stop", "uses")

    def __init__(self, reference: str | int, start: TermValue, stop: TermValue) -> None:
        self.reference = reference
        self.start = start
        self.stop = stop
        self.uses = variables_of((start.term, stop.term))


class EffectPlan:
    """An effect of a step on a resource."""

    __slots__ = ("amount", "node", "resource")

    def __init__(self, compiler: Compiler, node: nodes.ResourceEffect) -> None:
        where = compiler.place(f"effect `{node.op}`", node.span)
        self.node = node
        self.resource = TermValue(node.resource, where)
        self.amount = TermValue(node.amount, where)


class MethodPlan:
    """A method. `choice` is `repeat-while` and context as one query.

    `name` is what the trace prints, and `index` the place in the order of choice.
    `users` are, for each variable, the positions of the steps whose inputs or windows
    use it. `binds` says whether steps may add to the method's environment, `dated`
    whether windows are reckoned from the ends of steps.
    """

    __slots__ = (
        "binds",
        "choice",
        "dated",
        "index",
        "name",
        "node",
        "notations",
        "request",
        "steps",
        "users",
    )

    def __init__(
        self, compiler: Compiler, rap: nodes.DefineRap, node: nodes.Method, index: int
    ) -> None:
        self.node = node
        self.index = index
        self.name = f"#{index + 1}" if node.name is None else str(node.name)
        parts = [f for f in (rap.repeat_while, node.context) if f is not None]
        self.choice: Query | None = None
        if parts:
            formula = parts[0] if len(parts) == 1 else nodes.And(tuple(parts))
            what = f"context of method `{self.name}`"
            self.choice = compiler.query(formula, what, node.span)
        self.notations = tuple(
            compiler.assertion(p, "notation") for p in node.notations
        )
        self.request: RequestPlan | None = None
        self.steps: tuple[StepPlan, ...] = ()
        if isinstance(node.body, nodes.Primitive):
            self.request = compiler.assertion(node.body.request, "primitive")
        elif isinstance(node.body, nodes.TaskNet):
            self.steps = _steps(compiler, node.body)
        self.users = _users(self.steps)
        self.binds = any(s.outputs or s.conditions or s.waits for s in self.steps)
        windows = [window for step in self.steps for window in step.windows]
        self.dated = any(isinstance(window.reference, int) for window in windows)


class RequestPlan:
    """A proposition to be filled in: a primitive's request or a notation.

    `bare` is all of it where there are no arguments.
    """

    __slots__ = ("args", "bare", "name", "node", "where")

    def __init__(
        self, node: nodes.Pattern, args: Sequence[nodes.Term], where: str
    ) -> None:
        self.node = node
        self.name = node.name
        self.bare = (node.name,)
        self.where = where
        self.args = tuple(TermValue(arg, where) for arg in args)


class RapPlan:
    """A RAP ready to be instantiated.

    `succeed` is None where no clause is given: `(last-result okay)`; `endless` is set
    where it can never hold. `identity` is that of a task without inputs; only
    `recursive` RAPs can come up among their own subtasks. `monitored` says whether
    there is a monitor clause, `ages` whether it asks how old beliefs are,
    `conditional` whether there are preconditions or constraints, `prepares` whether
    something is to be made of the inputs; `waits` if it is monitored or prepares.
    """

    __slots__ = (
        "ages",
        "conditional",
        "constraints",
        "duration",
        "endless",
        "identity",
        "inputs",
        "methods",
        "monitor_state",
        "monitor_time",
        "monitored",
        "name",
        "node",
        "outputs",
        "preconditions",
        "prepared_from",
        "prepares",
        "recursive",
        "repeat_while",
        "resources",
        "succeed",
        "waits",
        "watches",
    )

    def __init__(self, compiler: Compiler, node: nodes.DefineRap) -> None:
        self.node = node
        self.name = node.name
        self.inputs = tuple(v.name for v in node.inputs)
        self.outputs = tuple(v.name for v in node.outputs)
        self.identity = (node.name,)
        self.succeed = compiler.clause(node.succeed, "succeed", node)
        self.endless = isinstance(node.succeed, nodes.Truth) and not node.succeed.value
        self.preconditions = compiler.clause(node.preconditions, "preconditions", node)
        self.constraints = compiler.clause(node.constraints, "constraints", node)
        self.repeat_while = compiler.clause(node.repeat_while, "repeat-while", node)
        self.monitor_state = compiler.clause(node.monitor_state, "monitor-state", node)
        self.watches: tuple[Watch, ...] = ()
        self.ages = False
        if node.monitor_state is not None:
            asked = subformulas(node.monitor_state)
            self.ages = any(isinstance(part, nodes.Believe) for part in asked)
            self.watches = watches(node.monitor_state, compiler.vocabulary)
        self.monitor_time: WindowPlan | None = None
        if node.monitor_time is not None:
            time = node.monitor_time
            where = compiler.place("monitor-time", time.span)
            start, stop = TermValue(time.start, where), TermValue(time.stop, where)
            self.monitor_time = WindowPlan(time.reference, start, stop)
        where = compiler.place("duration", node.span)
        self.duration = TermValue(node.duration, where) if node.duration else None
        self.resources = tuple(
            (r, TermValue(r.initial, compiler.place("resources", r.span)))
            if r.initial is not None
            else (r, None)
            for r in node.resources
        )
        self.prepared_from = _used(node)
        self.monitored = bool(node.monitor_state or node.monitor_time)
        self.conditional = bool(node.preconditions or node.constraints)
        self.prepares = bool(node.resources or node.duration or node.monitor_time)
        self.waits = self.monitored or self.prepares
        self.recursive = node.name in compiler.recursive
        self.methods = tuple(
            MethodPlan(compiler, node, method, index)
            for index, method in enumerate(node.methods)
        )


def _used(node: nodes.DefineRap) -> frozenset[str]:
    """The variables that resources, duration and delay of a RAP use."""
    used = [r.initial for r in node.resources if r.initial is not None]
    used += [node.duration] if node.duration is not None else []
    if node.monitor_time is not None:
        used += [node.monitor_time.start, node.monitor_time.stop]
    return variables_of(used)


def variables_of(terms: Iterable[nodes.Term]) -> frozenset[str]:
    """The variables in some terms."""
    parts = (part for term in terms for part in subterms(term))
    return frozenset(part.name for part in parts if isinstance(part, nodes.Var))


class Compiler:
    """What compiling shares: the vocabulary, and places to print in faults."""

    def __init__(self, library: Library) -> None:
        self.library = library
        self.vocabulary = Vocabulary.of(library)

    @cached_property
    def recursive(self) -> frozenset[str]:
        """The RAPs that may come up among their own subtasks."""
        return recursive(self.library)

    def place(self, what: str, span: Span) -> str:
        """A clause's name with the row it stands in: `succeed at arms.rap:12`."""
        source = self.library.files.get(span.file)
        if source is None:
            return what
        return f"{what} at {span.file}:{source.position(span.start).row}"

    def query(self, formula: nodes.Formula, what: str, span: Span) -> Query:
        """A formula of the clause `what` as a query."""
        span = formula.span if formula.span.file else span
        return Query(formula, self.vocabulary, self.place(what, span))

    def clause(
        self, formula: nodes.Formula | None, what: str, node: nodes.DefineRap
    ) -> Query | None:
        """A clause that need not be there."""
        return None if formula is None else self.query(formula, what, node.span)

    def assertion(self, pattern: nodes.Pattern, what: str) -> RequestPlan:
        """A proposition whose arguments are filled in at run time."""
        relation = self.vocabulary.relations.get(pattern.name)
        args = pattern.args
        if relation is not None and what == "notation":
            args = relation.full(args)
        return RequestPlan(pattern, args, self.place(what, pattern.span))


def _steps(compiler: Compiler, net: nodes.TaskNet) -> tuple[StepPlan, ...]:
    plans = tuple(StepPlan(compiler, step, at) for at, step in enumerate(net.steps))
    at_tag = {step.tag: at for at, step in enumerate(net.steps)}
    for plan in plans:
        for annotation in plan.node.annotations:
            _annotate(compiler, plans, at_tag, plan, annotation)
    for plan in plans:
        plan.timed = bool(plan.windows or plan.waits or plan.until)
    return plans


def _annotate(
    compiler: Compiler,
    plans: Sequence[StepPlan],
    at_tag: Mapping[str, int],
    plan: StepPlan,
    annotation: nodes.Annotation,
) -> None:
    if isinstance(annotation, nodes.For):
        target = plans[at_tag[annotation.tag]]
        _order(plan, target)
        if annotation.formula is not None:
            what = f"`for {annotation.tag}` formula"
            query = compiler.query(annotation.formula, what, annotation.span)
            target.conditions.append((plan.position, query))
    elif isinstance(annotation, nodes.UntilEnd | nodes.UntilStart):
        ended = isinstance(annotation, nodes.UntilEnd)
        target = plans[at_tag[annotation.tag]]
        if target is not plan:
            target.until.append((plan.position, ended))
    elif isinstance(annotation, nodes.Window):
        reference: str | int = annotation.reference
        if annotation.reference not in ("now", "absolute"):
            reference = at_tag[annotation.reference]
            _order(plans[reference], plan)
        where = compiler.place("window", annotation.span)
        start = TermValue(annotation.start, where)
        stop = TermValue(annotation.stop, where)
        plan.windows += (WindowPlan(reference, start, stop),)
    elif isinstance(annotation, nodes.WaitFor):
        where = compiler.place("wait-for", annotation.span)
        plan.waits.append(WaitPlan(annotation, where))
    elif isinstance(annotation, nodes.ResourceEffect):
        plan.effects.append(EffectPlan(compiler, annotation))


def _users(steps: Sequence[StepPlan]) -> Mapping[str, Sequence[int]]:
    users: dict[str, list[int]] = {}
    for step in steps:
        used = variables_of(step.node.goal.args)
        for name in used.union(*(window.uses for window in step.windows)):
            users.setdefault(name, []).append(step.position)
    return users


def _order(first: StepPlan, then: StepPlan) -> None:
    if then.position not in first.after:
        first.after.append(then.position)
        then.before += 1


class CompiledLibrary:
    """A checked library in executable form: what the interpreter is given.

    Args:
        library: linked, and free of findings of severity error.
        name: what traces call it.
    """

    def __init__(self, library: Library, name: str = "library") -> None:
        self.library = library
        self.name = name
        self._compiler = Compiler(library)
        self._plans: dict[str, RapPlan] = {}

    @property
    def vocabulary(self) -> Vocabulary:
        """What the declarations say."""
        return self._compiler.vocabulary

    @property
    def compiler(self) -> Compiler:
        """For compiling what comes later: methods of problem solvers."""
        return self._compiler

    def rap(self, name: str) -> RapPlan | None:
        """The plan of a RAP, compiled the first time it is asked for."""
        plan = self._plans.get(name)
        if plan is None:
            node = self.library.raps.get(name)
            if node is None:
                return None
            plan = self._plans[name] = RapPlan(self._compiler, node)
        return plan
