"""A linked library in executable form: RAPs, methods and steps ready to run.

A RAP is compiled when a task first needs it; its queries when they are first asked.
Everything keeps its IR node, so that what happens at run time can point at source.
"""

from __future__ import annotations

from rapc.compiler.compiler import Compiler, RequestPlan, variables_of
from rapc.compiler.net_plan import StepPlan, WindowPlan, steps_of, users_of
from rapc.compiler.query.query import Query
from rapc.compiler.query.term_value import TermValue
from rapc.compiler.watches import ANYTHING, Watch, watches
from rapc.ir import nodes
from rapc.ir.walk import subformulas


class MethodPlan:
    """A method. `choice` is `repeat-while` and context as one query.

    `name` is what the trace prints, and `index` the place in the order of choice.
    `users` are, for each variable, the positions of the steps whose inputs or windows
    use it; `raps` are what the `size` steps ask for, once they have been looked up.
    `conditions` says whether any step has some put on it, `computes` whether inputs are
    computed, `binds` whether steps may add to the method's environment, `dated` whether
    windows or `until`s ask how steps have ended. `key` tells the method from others of
    its RAP.
    """

    __slots__ = (
        "binds",
        "choice",
        "computes",
        "conditions",
        "dated",
        "index",
        "key",
        "name",
        "node",
        "notations",
        "raps",
        "request",
        "size",
        "steps",
        "users",
    )

    def __init__(
        self, compiler: Compiler, rap: nodes.DefineRap, node: nodes.Method, index: int
    ) -> None:
        self.node = node
        self.index = index
        self.key = (index,)
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
            self.steps = steps_of(compiler, node.body)
        self.users = users_of(self.steps)
        self.raps: tuple[RapPlan, ...] = ()
        self.binds = any(s.outputs or s.conditions or s.waits for s in self.steps)
        self.size = len(self.steps)
        self.conditions = any(step.conditions for step in self.steps)
        self.computes = any(step.computes for step in self.steps)
        windows = [window for step in self.steps for window in step.windows]
        self.dated = any(isinstance(window.reference, int) for window in windows)
        self.dated |= any(step.until for step in self.steps)


class RapPlan:
    """A RAP ready to be instantiated.

    `succeed` is None where no clause is given: `(last-result okay)`; `endless` is set
    where it can never hold. `identity` is that of a task without inputs, `known` the
    same if it need not be tested: only `recursive` RAPs can come up among their own
    subtasks. `only` is the one method if there is one and no `repeat-while`.
    `monitored` says whether there is a monitor clause, `ages` whether it asks how old
    beliefs are, `conditional` whether there are preconditions or constraints,
    `prepares` whether something is to be made of the inputs; `waits` if it is monitored
    or prepares.
    """

    __slots__ = (
        "ages",
        "conditional",
        "constraints",
        "duration",
        "endless",
        "identity",
        "inputs",
        "known",
        "methods",
        "monitor_state",
        "monitor_time",
        "monitored",
        "name",
        "node",
        "only",
        "outputs",
        "preconditions",
        "prepared_from",
        "prepares",
        "recursive",
        "repeat_while",
        "resources",
        "steady",
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
            self.watches = watches(node.monitor_state, compiler.signatures)
        #: Whether constraints depend on memory, resources and the clock alone.
        self.steady = _steady(compiler, node.constraints)
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
        self.recursive = compiler.recursion.covers(node.name)
        self.known = None if self.inputs or self.recursive else self.identity
        self.methods = tuple(
            MethodPlan(compiler, node, method, index)
            for index, method in enumerate(node.methods)
        )
        single = len(self.methods) == 1 and node.repeat_while is None
        self.only = self.methods[0] if single else None


def _steady(compiler: Compiler, constraints: nodes.Formula | None) -> bool:
    """Whether a formula can change its answer only by a change that is told of."""
    if constraints is None:
        return True
    asked = watches(constraints, compiler.signatures)
    return all(watch.key != ANYTHING for watch in asked) and not any(
        isinstance(part, nodes.HistoryTest) for part in subformulas(constraints)
    )


def _used(node: nodes.DefineRap) -> frozenset[str]:
    """The variables that resources, duration and delay of a RAP use."""
    used = [r.initial for r in node.resources if r.initial is not None]
    used += [node.duration] if node.duration is not None else []
    if node.monitor_time is not None:
        used += [node.monitor_time.start, node.monitor_time.stop]
    return variables_of(used)
