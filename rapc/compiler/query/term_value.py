"""Terms computed in an environment: arguments, amounts, times.

Terms within formulas are compiled with the formulas, in
`rapc.compiler.query.term_code`.
"""

from __future__ import annotations

from rapc.base.resources import Value
from rapc.compiler.query import builtin
from rapc.compiler.query.context import Bindings, QuestionContext
from rapc.ir import nodes


class TermValue:
    """A term for evaluation in an environment; `name` if it is a variable."""

    __slots__ = ("_known", "name", "term", "where")

    def __init__(self, term: nodes.Term, where: str) -> None:
        self.term = term
        self.where = where
        self.name = term.name if isinstance(term, nodes.Var) else None
        self._known = term.value if isinstance(term, nodes.Const) else None

    def value(self, ctx: QuestionContext, env: Bindings) -> Value | None:
        """Return the value, or None if a variable is unbound or of the wrong kind."""
        if self.name is not None:
            return env.get(self.name)
        if self._known is not None:
            return self._known
        try:
            return self._computed(ctx, env)
        except builtin.QueryFault:
            return None

    def needed(self, ctx: QuestionContext, env: Bindings) -> Value | None:
        """Return the result of `value`; trace an unbound or ill-typed value."""
        if self._known is not None:
            return self._known
        try:
            return self._computed(ctx, env)
        except builtin.QueryFault as fault:
            ctx.fault(self.where, str(fault))
            return None

    def _computed(self, ctx: QuestionContext, env: Bindings) -> Value:
        try:
            return _computed(self.term, ctx, env)
        except builtin.QueryFault:
            raise
        except Exception as error:  # of a registered function: add the clause
            error.add_note(self.where)
            raise


def _computed(term: nodes.Term, ctx: QuestionContext, env: Bindings) -> Value:
    """Return the value of a term; raise QueryFault if there is none."""
    if isinstance(term, nodes.Const):
        return term.value
    if isinstance(term, nodes.Var):
        value = env.get(term.name)
        if value is None:
            raise builtin.QueryFault(f"{term.name} is not bound")
        return value
    args = [_computed(arg, ctx, env) for arg in term.args]
    function = builtin.FUNCTIONS.get(term.function)
    if function is not None:
        return function(args)
    return builtin.as_value(ctx.functions[term.function](ctx.view, *args))
