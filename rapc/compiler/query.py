"""Compiled queries and terms: what the interpreter asks in a cycle.

A `Query` is made once for a clause and compiled, lazily, once for each set of
variables that is bound when it is asked; nothing reads the IR afterwards.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Protocol

from rapc.compiler import builtin, formulas
from rapc.compiler.emitter import Emitter, Scope
from rapc.compiler.terms import Clause
from rapc.compiler.vocabulary import Vocabulary
from rapc.ir import nodes
from rapc.resources import Value
from rapc.terms import Fact, Number

Bindings = Mapping[str, Value]


class Context(Protocol):
    """What generated code asks of memory and of the task whose clause it is."""

    @property
    def values(self) -> Any:
        """The asserted fact of each property, by all of it but the value."""

    @property
    def buckets(self) -> Any:
        """The facts of each index key, oldest assertion first."""

    @property
    def stamps(self) -> Any:
        """The time of each fact's last assertion."""

    @property
    def functions(self) -> Mapping[str, Callable[..., Any]]:
        """The registered functions."""

    @property
    def view(self) -> object:
        """Memory to be read, as functions are given it."""

    def fault(self, where: str, what: str) -> None:
        """Trace that a clause met an unbound variable or an ill-typed value."""

    def young(self, fact: Fact, limit: Number) -> bool:
        """Whether a fact was asserted less than `limit` time units ago."""

    def age(self, fact: Fact) -> Number:
        """Time units since a fact was last asserted."""

    def is_here(self, fact: Fact | None, place: object) -> bool:
        """Whether `place` is `external` and a location fact says it of an item."""

    def facts_at(self, place: object) -> Iterator[Fact]:
        """Location facts of a place, `external` among them, oldest first."""

    def method_tried(self, name: object) -> bool:
        """Whether the task has tried a method of that name."""

    def last_result(self, method: object = None) -> str | None:
        """The result of the last method, or of the last one so named, or None."""

    def accessible_items(self) -> Sequence[str]:
        """The items with a sensor name, in the order of introduction."""

    def is_accessible(self, item: object) -> bool:
        """Whether an item has a sensor name."""

    def count(self, kind: object, place: object) -> Number:
        """How many items of a class memory holds at a place."""


class Query:
    """A formula ready to be asked.

    Args:
        formula: what is asked.
        vocabulary: the declarations that say what its names mean.
        where: the clause's name for faults, with its place in the source.
    """

    __slots__ = ("_plans", "_vocabulary", "formula", "variables", "where")

    def __init__(
        self, formula: nodes.Formula, vocabulary: Vocabulary, where: str
    ) -> None:
        self.formula = formula
        self.where = where
        self.variables = formulas.variables(formula)
        self._vocabulary = vocabulary
        self._plans: dict[tuple[bool, ...], _Plan] = {}

    def solutions(self, ctx: Context, env: Bindings) -> Iterator[dict[str, Value]]:
        """The new bindings of each solution, in order, found one at a time."""
        plan = self._plan(env)
        for solution in plan.start(ctx, *[env[n] for n in plan.inputs]):
            yield {
                name: value
                for name, value in zip(plan.outputs, solution, strict=True)
                if value is not builtin.UNBOUND
            }

    def first(self, ctx: Context, env: Bindings) -> dict[str, Value] | None:
        """The new bindings of the first solution, or None."""
        plan = self._plan(env)
        solution = next(plan.start(ctx, *[env[n] for n in plan.inputs]), None)
        if solution is None:
            return None
        return {
            name: value
            for name, value in zip(plan.outputs, solution, strict=True)
            if value is not builtin.UNBOUND
        }

    def holds(self, ctx: Context, env: Bindings) -> bool:
        """Whether there is a solution."""
        plan = self._plan(env)
        found = next(plan.start(ctx, *[env[n] for n in plan.inputs]), None)
        return found is not None

    def extended(self, ctx: Context, values: Sequence[Any]) -> Iterator[list[Any]]:
        """The values of all variables for each solution, given those known so far.

        `values` are in the order of `variables`, UNBOUND where one is not known.
        """
        pairs = zip(self.variables, values, strict=True)
        env = {name: value for name, value in pairs if value is not builtin.UNBOUND}
        plan = self._plan(env)
        for solution in plan.start(ctx, *[env[n] for n in plan.inputs]):
            found = {**env, **dict(zip(plan.outputs, solution, strict=True))}
            yield [found.get(name, builtin.UNBOUND) for name in self.variables]

    def _later(self, part: nodes.Formula) -> Query:
        return Query(part, self._vocabulary, self.where)

    def _plan(self, env: Bindings) -> _Plan:
        key = tuple([name in env for name in self.variables])
        plan = self._plans.get(key)
        if plan is None:
            plan = self._plans[key] = self._compile(key)
        return plan

    def _compile(self, key: tuple[bool, ...]) -> _Plan:
        inputs = [n for n, bound in zip(self.variables, key, strict=True) if bound]
        emitter = Emitter()
        scope = Scope(emitter, "query", inputs)
        clause = Clause(emitter, self._vocabulary, self.where, self._later)
        formulas.write(clause, scope, self.formula)
        outputs = [
            n
            for n in self.variables
            if n in scope.bound | scope.maybe and n not in inputs
        ]
        scope.finish(outputs)
        scope.close()
        namespace = emitter.namespace
        source = "\n\n".join(emitter.functions)
        code = compile(source, f"<{self.where}>", "exec")
        exec(code, namespace)  # noqa: S102  # generated here; no program text is in it
        return _Plan(namespace["query"], tuple(inputs), tuple(outputs), source)


class _Plan:
    """A formula compiled for one set of bound variables."""

    __slots__ = ("inputs", "outputs", "source", "start")

    def __init__(
        self,
        start: Any,
        inputs: tuple[str, ...],
        outputs: tuple[str, ...],
        source: str,
    ) -> None:
        self.start: Callable[..., Iterator[tuple[Any, ...]]] = start
        self.inputs = inputs
        self.outputs = outputs
        self.source = source


class TermValue:
    """A term ready to be computed in an environment."""

    __slots__ = ("_compute", "term", "where")

    def __init__(self, term: nodes.Term, where: str) -> None:
        self.term = term
        self.where = where
        self._compute = _compile_term(term)

    def value(self, ctx: Context, env: Bindings) -> Value | None:
        """The value, or None while a variable is unbound or of the wrong kind."""
        try:
            return self._compute(ctx, env)
        except builtin.Fault:
            return None

    def needed(self, ctx: Context, env: Bindings) -> Value | None:
        """As `value`, but what is unbound or of the wrong kind is traced."""
        try:
            return self._compute(ctx, env)
        except builtin.Fault as fault:
            ctx.fault(self.where, str(fault))
            return None


def _compile_term(term: nodes.Term) -> Callable[[Context, Bindings], Value]:
    if isinstance(term, nodes.Const):
        constant = term.value
        return lambda ctx, env: constant
    if isinstance(term, nodes.Var):
        return _compile_variable(term.name)
    parts = [_compile_term(arg) for arg in term.args]
    builtin_function = builtin.FUNCTIONS.get(term.function)
    name = term.function

    def compute(ctx: Context, env: Bindings) -> Value:
        args = [part(ctx, env) for part in parts]
        if builtin_function is not None:
            return builtin_function(args)
        return builtin.as_value(ctx.functions[name](ctx.view, *args))

    return compute


def _compile_variable(name: str) -> Callable[[Context, Bindings], Value]:
    def look_up(ctx: Context, env: Bindings) -> Value:
        value = env.get(name)
        if value is None:
            raise builtin.Fault(f"{name} is not bound")
        return value

    return look_up
