"""Compiled queries: formulas as Python functions that query a memory.

The module has four classes. A `Query` is a formula of a clause. A `Variant` is that
formula compiled for a set of bound variables and a result mode (the first solution, all
solutions, or whether there is a solution). A `BoundQuery` is a query bound to one
memory. A `CodeWriter` writes the text of a variant.

Formulas are compiled because the interpreter evaluates them at every choice and every
change: an evaluation consists of a few look-ups, without a walk over a tree. Variants
differ because the best access path depends on the known values: `(q ?place ?item)` is a
membership test if both variables have values, and a loop if one variable has none. A
variant is compiled at its first use; after that no code reads the IR.

For example, the first solution of

    (and (q ?place ?item) (color ?item red) (not (heavy ?item true)))

where `?place` has a value is found by this text, which `CodeWriter.source` returns:

    def make(ctx, constants, aliases, aliased):
        (k1, k2, k3, k4, k5, k6, k7, k8, k9, k10, ) = constants
        m2 = ctx.facts.table(k3)
        m3 = m2.index(1).get
        m4 = ctx.facts.table(k6)
        m5 = m4.stamps
        m7 = ctx.facts.table(k9)
        m8 = m7.stamps
        def no6(v1):
            if (k8, v1, k7) not in m8: return False
            return True
            return False
        def query(env):
            v0 = env[k2]
            for f1 in m3(v0, ()):
                v1 = f1[2]
                if (k5, v1, k4) not in m5: continue
                if no6(v1): continue
                return {k10: v1}
            return None
        return query

`make` is called once for each memory that the query is bound to, `query` once for each
evaluation. Constants (`k`) are arguments, so that no text of a program is part of the
code, and formulas of equal shape share the code: here `k2` is `?place`, `k3` the name
`q` and `k4` the value `red`. The indexes of memory are looked up beforehand (`m`): the
facts of `q` by their first argument, the facts of `color` and of `heavy`. Then:

- `and` is a sequence of parts, each inside the loops of the preceding parts. So the
  solutions come in the order that the language promises [L 2]: the order of the text,
  and within a part the order of the facts' last assertion.
- `(q ?place ?item)`: the first argument is known, so the index by it returns the facts
  (`f1`) of the loop; `?item` (`v1`) is bound to the second argument of each fact.
- `(color ?item red)`: all arguments are known, and `red` is not the default of `color`:
  the fact is in memory, or the candidate is rejected (`continue`: try the next fact).
- `not` is a separate function (`no6`) that stops at its first solution. The branches of
  an `or`, and parts nested deeper than CPython permits, are separate functions, too.
- The end of the text is a solution, and the mode determines the result: `FIRST` returns
  the new bindings.

A variable that only some branches of an `or` bind may or may not have a value after the
`or`. The part that uses the variable then is a separate query, compiled for the
bindings at run time (`Query.extended`), because code for all cases would grow by two to
the number of these variables.

A conjunction is a search, and may visit every combination of facts. So the code counts
a step back after the loop of each part with two searching parts before it, and aborts a
query with too many steps back (`TooManySteps`). The text determines which parts search
[L 2.71]: loops that only the generated code needs do not count.

The writer also records the steps (`plan_steps`), for `rapc explain`.

Not here: the writers of formulas (`formulas`), facts (`facts`) and terms (`term_code`);
terms outside of formulas (`term_value`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple, Protocol

from rapc.base.resources import Value
from rapc.compiler.query import builtin, formulas
from rapc.compiler.query.code import (
    CodeWriter,
    ResultMode,
    compile_source,
    made_of,
)
from rapc.compiler.query.context import Bindings, QuestionContext
from rapc.compiler.query.function import FunctionWriter
from rapc.compiler.query.plan_steps import PlanStep
from rapc.ir import nodes
from rapc.ir.printer import format_formula
from rapc.ir.walk import variable_names
from rapc.library.signatures import Signatures


class QueryingContext(QuestionContext, Protocol):
    """A context that keeps the queries bound to its memory."""

    @property
    def bound(self) -> BoundQueries:
        """Return the queries already bound to this context."""


class QueryPrefix(NamedTuple):
    """A conjunct of a query, with a query that tests whether it fails."""

    part: nodes.Formula
    #: The query of all conjuncts up to this conjunct.
    up_to_it: Query
    #: The conjunct as RAP text.
    text: str


class Query:
    """A formula ready for evaluation.

    Args:
        formula: the formula.
        signatures: the declarations of its names.
        where: the clause's name for faults, with its position in the source.
        is_whole: whether it is not part of another query, whose limit applies.
    """

    def __init__(
        self,
        formula: nodes.Formula,
        signatures: Signatures,
        where: str,
        is_whole: bool = True,
    ) -> None:
        self.formula = formula
        self.where = where
        self.variables = variable_names(formula)
        self._signatures = signatures
        self._is_whole = is_whole
        self._elsewhere: dict[str, Query] = {}
        self._beginnings: tuple[QueryPrefix, ...] | None = None
        self._variants: dict[tuple[tuple[str, ...], ResultMode, bool], Variant] = {}

    def first(self, ctx: QueryingContext, env: Bindings) -> dict[str, Value] | None:
        """Return the new bindings of the first solution, or None."""
        return ctx.bound[self].first(env)

    def holds(self, ctx: QueryingContext, env: Bindings) -> bool:
        """Return whether there is a solution."""
        return ctx.bound[self].holds(env)

    def solutions(
        self, ctx: QueryingContext, env: Bindings
    ) -> Iterator[dict[str, Value]]:
        """Iterate over the new bindings of each solution, computed on demand."""
        return ctx.bound[self].solutions(env)

    def extended(
        self, ctx: QueryingContext, where: str, values: Sequence[Any]
    ) -> Iterator[list[Any]]:
        """Iterate over the values of all variables for each solution.

        Args:
            ctx: the context of the evaluation.
            where: the clause's name for faults.
            values: the known values, in the order of `variables`, UNBOUND for an
                unknown value.
        """
        pairs = zip(self.variables, values, strict=True)
        env = {name: value for name, value in pairs if value is not builtin.UNBOUND}
        for solution in self._within(where).solutions(ctx, env):
            found = {**env, **solution}
            yield [found.get(name, builtin.UNBOUND) for name in self.variables]

    def beginnings(self) -> tuple[QueryPrefix, ...]:
        """Return each conjunct with the query of all conjuncts up to it."""
        if self._beginnings is None:
            parts = tuple(formulas.conjuncts(self.formula))
            self._beginnings = tuple(
                QueryPrefix(
                    part,
                    Query(nodes.And(parts[: at + 1]), self._signatures, self.where),
                    format_formula(part),
                )
                for at, part in enumerate(parts)
            )
        return self._beginnings

    @staticmethod
    def names(formula: nodes.Formula) -> tuple[str, ...]:
        """Return the named variables of a formula, in the order of the text."""
        return variable_names(formula)

    def variant(
        self, inputs: tuple[str, ...], mode: ResultMode, by_place: bool = False
    ) -> Variant:
        """Return the formula compiled for some bound variables, all from the formula.

        Its function takes an environment, or with `by_place` the values as arguments.
        """
        key = (inputs, mode, by_place)
        variant = self._variants.get(key)
        if variant is None:
            code, outputs = self._write(inputs, mode, by_place)
            variant = self._variants[key] = Variant(code, inputs, outputs)
        return variant

    def steps(self, inputs: tuple[str, ...]) -> tuple[PlanStep, ...]:
        """Return the steps of the evaluation if these variables are bound."""
        return tuple(self._write(inputs, ResultMode.FIRST, False)[0].steps)

    def outputs(self, inputs: tuple[str, ...]) -> tuple[str, ...]:
        """Return the variables that a solution may bind if these are bound."""
        return self.variant(inputs, ResultMode.FIRST).outputs

    def _write(
        self, inputs: tuple[str, ...], mode: ResultMode, by_place: bool
    ) -> tuple[CodeWriter, tuple[str, ...]]:
        """Write the code for some bound variables; return it with its outputs."""
        code = CodeWriter(self._signatures, self.where, self._later)
        fn = FunctionWriter(code, "query", inputs, mode)
        fn.is_whole = self._is_whole
        fn.head = _head_by_place(fn) if by_place else _head_by_name(fn)
        found: set[str] = set()

        def answer(fn: FunctionWriter) -> str:
            known = fn.bound | fn.maybe
            outputs = [n for n in self.variables if n in known and n not in inputs]
            found.update(outputs)
            return _answer(fn, outputs)

        formulas.solve(fn, self.formula, answer)
        return code, tuple(n for n in self.variables if n in found)

    def _later(self, part: nodes.Formula) -> Query:
        return Query(part, self._signatures, self.where, is_whole=False)

    def _within(self, where: str) -> Query:
        """Return the query as a part of another query, with its name for faults."""
        if where == self.where:
            return self
        if where not in self._elsewhere:
            made = Query(self.formula, self._signatures, where, is_whole=False)
            self._elsewhere[where] = made
        return self._elsewhere[where]


def _head_by_place(fn: FunctionWriter) -> list[str]:
    """Return the first lines of a function with the variables as parameters.

    Names that items have lost meanwhile are first replaced, by the aliases of the
    memory.
    """
    names = ", ".join(fn.local(name) for name in fn.parameters)
    return [f"def query({names}):", f"    if aliases: return aliased({names})"]


def _head_by_name(fn: FunctionWriter) -> list[str]:
    """Return the first lines of a function that reads variables from an environment."""
    return [
        "def query(env):",
        *(
            f"    {fn.local(name)} = env[{fn.code.constant(name)}]"
            for name in fn.parameters
        ),
    ]


def _answer(fn: FunctionWriter, outputs: Sequence[str]) -> str:
    """Return the expression for the new bindings, without unbound variables."""
    pairs = [(fn.code.constant(name), fn.local(name)) for name in outputs]
    if not fn.maybe.isdisjoint(outputs):
        listed = "".join(f"({key}, {value}), " for key, value in pairs)
        return f"{{k: v for k, v in ({listed}) if v is not UNBOUND}}"
    return f"{{{', '.join(f'{key}: {value}' for key, value in pairs)}}}"


class Variant:
    """A formula compiled for one set of bound variables and one result mode."""

    __slots__ = ("constants", "inputs", "outputs", "source")

    def __init__(
        self, code: CodeWriter, inputs: tuple[str, ...], outputs: tuple[str, ...]
    ) -> None:
        #: The generated text.
        self.source = code.source()
        #: The constants that the text uses.
        self.constants = tuple(code.constants)
        #: The bound variables, all of which the formula uses.
        self.inputs = inputs
        #: The variables that a solution may bind.
        self.outputs = outputs

    def bind(
        self,
        ctx: QuestionContext,
        aliases: Mapping[str, str] | None = None,
        aliased: Callable[..., Any] | None = None,
    ) -> Callable[..., Any]:
        """Return the function that evaluates the query on one memory.

        While `aliases` has merged items, the result calls `aliased` instead.
        """
        return compile_source(self.source)(ctx, self.constants, aliases, aliased)


Ask = Callable[[Bindings], Any]


class BoundQuery:
    """A query bound to one memory: its functions take only the environment."""

    __slots__ = ("first", "holds", "solutions")

    def __init__(self, query: Query | None, ctx: QuestionContext) -> None:
        #: Returns the new bindings of the first solution, or None.
        self.first: Callable[[Bindings], dict[str, Value] | None]
        #: Returns whether there is a solution.
        self.holds: Callable[[Bindings], bool]
        #: Iterates over the new bindings of each solution, computed on demand.
        self.solutions: Callable[[Bindings], Iterator[dict[str, Value]]]
        if query is None:
            self.first = lambda env: {}
            self.holds = lambda env: True
            self.solutions = lambda env: iter(({},))
            return
        names = query.variables
        select = _variant_selector(len(names))
        self.first = select(_Variants(query, ctx, ResultMode.FIRST), names)
        self.holds = select(_Variants(query, ctx, ResultMode.ANY), names)
        self.solutions = select(_Variants(query, ctx, ResultMode.EACH), names)


class BoundQueries(dict[Query | None, BoundQuery]):
    """The queries bound to one memory. Looking up an unbound query binds it.

    None is the query of a clause that is not stated: it holds and binds nothing.
    """

    __slots__ = ("_ctx",)

    def __init__(self, ctx: QuestionContext) -> None:
        super().__init__()
        self._ctx = ctx

    def __missing__(self, query: Query | None) -> BoundQuery:
        found = self[query] = BoundQuery(query, self._ctx)
        return found


class _Variants(dict[int, Ask]):
    """The functions of a query by a number with a bit for each bound variable."""

    __slots__ = ("_ctx", "_mode", "_query")

    def __init__(self, query: Query, ctx: QuestionContext, mode: ResultMode) -> None:
        super().__init__()
        self._query = query
        self._ctx = ctx
        self._mode = mode

    def __missing__(self, key: int) -> Ask:
        names = enumerate(self._query.variables)
        bound = tuple(name for at, name in names if key >> at & 1)
        found = self[key] = self._query.variant(bound, self._mode).bind(self._ctx)
        return found


@lru_cache(maxsize=64)
def _variant_selector(count: int) -> Callable[[_Variants, Sequence[str]], Ask]:
    """Return a factory of the function that selects a variant of `count` variables.

    The function computes a number with a bit for each variable in the environment, and
    looks up the variant by this number. The function runs at every evaluation, so it is
    one generated expression, which depends only on the count.
    """
    names = "".join(f"n{at}, " for at in range(count))
    bits = " | ".join(f"(n{at} in env) << {at}" for at in range(count))
    lines = ["def make(variants, names):"]
    if count:
        lines.append(f"    ({names}) = names")
    lines += [f"    def ask(env): return variants[{bits or 0}](env)", "    return ask"]
    make: Callable[[_Variants, Sequence[str]], Ask] = made_of("\n".join(lines), {})
    return make
