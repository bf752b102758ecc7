"""Terms computed in an environment: arguments, amounts, times.

Those within formulas are compiled with them, in `rapc.compiler.query.term_code`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rapc.base.resources import Value
from rapc.base.values import Number
from rapc.compiler.query import builtin
from rapc.compiler.query.context import Bindings, QuestionContext
from rapc.ir import nodes

Compute = Callable[[QuestionContext, Bindings], Value]


class TermValue:
    """A term ready to be computed in an environment; `name` if it is a variable."""

    __slots__ = ("_compute", "_known", "name", "term", "where")

    def __init__(self, term: nodes.Term, where: str) -> None:
        self.term = term
        self.where = where
        self.name = term.name if isinstance(term, nodes.Var) else None
        self._known = term.value if isinstance(term, nodes.Const) else None
        self._compute: Compute | None = None

    def value(self, ctx: QuestionContext, env: Bindings) -> Value | None:
        """The value, or None while a variable is unbound or of the wrong kind."""
        if self.name is not None:
            return env.get(self.name)
        if self._known is not None:
            return self._known
        try:
            return self._computed(ctx, env)
        except builtin.QueryFault:
            return None

    def needed(self, ctx: QuestionContext, env: Bindings) -> Value | None:
        """Return what `value` returns; trace what is unbound or of the wrong kind."""
        if self._known is not None:
            return self._known
        try:
            return self._computed(ctx, env)
        except builtin.QueryFault as fault:
            ctx.fault(self.where, str(fault))
            return None

    def _computed(self, ctx: QuestionContext, env: Bindings) -> Value:
        if self._compute is None:
            self._compute = _compile_term(self.term)
        try:
            return self._compute(ctx, env)
        except builtin.QueryFault:
            raise
        except Exception as error:  # of a registered function: say who asked it
            error.add_note(self.where)
            raise


def _compile_term(term: nodes.Term) -> Compute:
    if isinstance(term, nodes.Const):
        constant = term.value
        return lambda ctx, env: constant
    if isinstance(term, nodes.Var):
        return _compile_variable(term.name)
    parts = [_compile_term(arg) for arg in term.args]
    builtin_function = builtin.FUNCTIONS.get(term.function)
    name = term.function
    if builtin_function is not None and len(parts) == 2:
        last = term.args[1]
        if isinstance(last, nodes.Const):
            return _compile_step(builtin_function, parts[0], last.value)
        return _compile_pair(builtin_function, *parts)

    def compute(ctx: QuestionContext, env: Bindings) -> Value:
        args = [part(ctx, env) for part in parts]
        if builtin_function is not None:
            return builtin_function(args)
        return builtin.as_value(ctx.functions[name](ctx.view, *args))

    return compute


def _compile_pair(
    function: Callable[[Sequence[object]], Number], one: Compute, two: Compute
) -> Compute:
    return lambda ctx, env: function((one(ctx, env), two(ctx, env)))


def _compile_step(
    function: Callable[[Sequence[object]], Number], one: Compute, constant: Value
) -> Compute:
    return lambda ctx, env: function((one(ctx, env), constant))


def _compile_variable(name: str) -> Compute:
    def look_up(ctx: QuestionContext, env: Bindings) -> Value:
        value = env.get(name)
        if value is None:
            raise builtin.QueryFault(f"{name} is not bound")
        return value

    return look_up
