"""Compiled queries: what the interpreter asks in a cycle.

A `Query` is made once for a clause. It is compiled, lazily, once for each set of
variables that is bound when it is asked, and meets each memory once (`Query.on`);
nothing reads the IR afterwards.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, Protocol

from rapc.base.resources import Value
from rapc.compiler.query import builtin, formulas
from rapc.compiler.query.code import Emitter, Ending, Scope, made
from rapc.compiler.query.context import Bindings, Context
from rapc.compiler.query.plan_steps import Step
from rapc.compiler.query.term_code import Clause
from rapc.compiler.vocabulary import Vocabulary
from rapc.ir import nodes


class Asking(Context, Protocol):
    """A context that keeps the queries which have met its memory."""

    @property
    def asked(self) -> Meetings:
        """These queries."""


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
        self._plans: dict[tuple[tuple[str, ...], Ending, bool], Plan] = {}

    def on(self, ctx: Asking) -> Asked:
        """The query as it is asked of one memory, again and again."""
        return ctx.asked[self]

    def first(self, ctx: Asking, env: Bindings) -> dict[str, Value] | None:
        """The new bindings of the first solution, or None."""
        return ctx.asked[self].first(env)

    def holds(self, ctx: Asking, env: Bindings) -> bool:
        """Whether there is a solution."""
        return ctx.asked[self].holds(env)

    def solutions(self, ctx: Asking, env: Bindings) -> Iterator[dict[str, Value]]:
        """The new bindings of each solution, in order, found one at a time."""
        return ctx.asked[self].solutions(env)

    def extended(self, ctx: Asking, values: Sequence[Any]) -> Iterator[list[Any]]:
        """The values of all variables for each solution, given those known so far.

        `values` are in the order of `variables`, UNBOUND where one is not known.
        """
        pairs = zip(self.variables, values, strict=True)
        env = {name: value for name, value in pairs if value is not builtin.UNBOUND}
        for solution in self.solutions(ctx, env):
            found = {**env, **solution}
            yield [found.get(name, builtin.UNBOUND) for name in self.variables]

    def plan(
        self, inputs: tuple[str, ...], ending: Ending, given: bool = False
    ) -> Plan:
        """The formula compiled for some bound variables, all of them its own.

        Its function takes an environment, or is given the values one by one.
        """
        key = (inputs, ending, given)
        plan = self._plans.get(key)
        if plan is None:
            emitter, outputs = self._written(inputs, ending, given)
            plan = self._plans[key] = Plan(emitter, inputs, outputs)
        return plan

    def steps(self, inputs: tuple[str, ...]) -> tuple[Step, ...]:
        """What is done, step by step, where these variables are bound."""
        return tuple(self._written(inputs, Ending.FIRST, False)[0].steps)

    def outputs(self, inputs: tuple[str, ...]) -> tuple[str, ...]:
        """The variables that a solution may bind where these are bound."""
        return self.plan(inputs, Ending.FIRST).outputs

    def _written(
        self, inputs: tuple[str, ...], ending: Ending, given: bool
    ) -> tuple[Emitter, tuple[str, ...]]:
        """The code for a set of bound variables, and the variables it binds."""
        emitter = Emitter()
        scope = Scope(emitter, "query", inputs, ending)
        clause = Clause(emitter, self._vocabulary, self.where, self._later)
        scope.head = _given(scope) if given else _from_environment(scope)
        found: set[str] = set()

        def answer(scope: Scope) -> str:
            known = scope.bound | scope.maybe
            outputs = [n for n in self.variables if n in known and n not in inputs]
            found.update(outputs)
            return _answer(scope, outputs)

        formulas.solve(clause, scope, self.formula, answer)
        return emitter, tuple(n for n in self.variables if n in found)

    def _later(self, part: nodes.Formula) -> Query:
        return Query(part, self._vocabulary, self.where)


def _given(scope: Scope) -> list[str]:
    """The head of a function that is given the values of its variables by place.

    Names that items have lost since are first replaced, by who sees to them.
    """
    names = ", ".join(scope.local(name) for name in scope.parameters)
    return [f"def query({names}):", f"    if aliases: return aliased({names})"]


def _from_environment(scope: Scope) -> list[str]:
    """The head of a function that takes what it needs from an environment."""
    return [
        "def query(env):",
        *(
            f"    {scope.local(name)} = env[{scope.emitter.constant(name)}]"
            for name in scope.parameters
        ),
    ]


def _answer(scope: Scope, outputs: Sequence[str]) -> str:
    """The expression for the new bindings, without variables that have none."""
    pairs = [(scope.emitter.constant(name), scope.local(name)) for name in outputs]
    if not scope.maybe.isdisjoint(outputs):
        listed = "".join(f"({key}, {value}), " for key, value in pairs)
        return f"{{k: v for k, v in ({listed}) if v is not UNBOUND}}"
    return f"{{{', '.join(f'{key}: {value}' for key, value in pairs)}}}"


class Plan:
    """A formula compiled for one set of bound variables and one way to end.

    `inputs` are the bound variables that it uses, `outputs` those that it may bind;
    `source` is the generated text, `constants` what it is handed.
    """

    __slots__ = ("constants", "inputs", "outputs", "source")

    def __init__(
        self, emitter: Emitter, inputs: tuple[str, ...], outputs: tuple[str, ...]
    ) -> None:
        self.source = emitter.source()
        self.constants = tuple(emitter.constants)
        self.inputs = inputs
        self.outputs = outputs

    def bind(
        self,
        ctx: Context,
        aliases: Mapping[str, str] | None = None,
        aliased: Callable[..., Any] | None = None,
    ) -> Callable[..., Any]:
        """The function that asks one memory.

        While `aliases` holds anything, `aliased` is called in its place.
        """
        return made(self.source)(ctx, self.constants, aliases, aliased)


Ask = Callable[[Bindings], Any]


class Asked:
    """A query on one memory: each of its functions takes the environment alone.

    `first` returns the new bindings of the first solution, or None; `holds` whether
    there is a solution; `solutions` the new bindings of each, one at a time.
    """

    __slots__ = ("first", "holds", "solutions")

    def __init__(self, query: Query, ctx: Context) -> None:
        names = query.variables
        choose = _chooser(len(names))
        self.first: Callable[[Bindings], dict[str, Value] | None] = choose(
            _Plans(query, ctx, Ending.FIRST), names
        )
        self.holds: Callable[[Bindings], bool] = choose(
            _Plans(query, ctx, Ending.ANY), names
        )
        each: Ask = choose(_Plans(query, ctx, Ending.EACH), names)
        self.solutions: Callable[[Bindings], Iterator[dict[str, Value]]] = each


class Meetings(dict[Query, Asked]):
    """The queries that have met a memory; another one meets it when it is looked up."""

    __slots__ = ("_ctx",)

    def __init__(self, ctx: Context) -> None:
        super().__init__()
        self._ctx = ctx

    def __missing__(self, query: Query) -> Asked:
        found = self[query] = Asked(query, self._ctx)
        return found


class _Plans(dict[int, Ask]):
    """The functions of a query by a number with a bit for each bound variable."""

    __slots__ = ("_ctx", "_ending", "_query")

    def __init__(self, query: Query, ctx: Context, ending: Ending) -> None:
        super().__init__()
        self._query = query
        self._ctx = ctx
        self._ending = ending

    def __missing__(self, key: int) -> Ask:
        names = enumerate(self._query.variables)
        bound = tuple(name for at, name in names if key >> at & 1)
        plan = self._query.plan(bound, self._ending)
        found = self[key] = plan.bind(self._ctx)
        return found


@lru_cache(maxsize=64)
def _chooser(count: int) -> Callable[[_Plans, Sequence[str]], Ask]:
    """Makes the function that picks a plan by which of its variables are bound."""
    names = "".join(f"n{at}, " for at in range(count))
    bits = " | ".join(f"(n{at} in env) << {at}" for at in range(count))
    lines = ["def make(plans, names):"]
    if count:
        lines.append(f"    ({names}) = names")
    lines += [f"    def ask(env): return plans[{bits or 0}](env)", "    return ask"]
    namespace: dict[str, Any] = {}
    exec("\n".join(lines), namespace)  # noqa: S102  # made of the count alone
    maker: Callable[[_Plans, Sequence[str]], Ask] = namespace["make"]
    return maker
