"""Terms to generated Python: known values, computed ones, and matching.

Shared by the writers of formulas and of facts. A value that is missing or of the
wrong kind is traced as a fault and gives up the candidate (semantics 2).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rapc.compiler.query import builtin
from rapc.compiler.query.code import Emitter, Scope
from rapc.compiler.query.plan_steps import Step, Way
from rapc.compiler.vocabulary import Vocabulary
from rapc.ir import nodes


class Clause:
    """What the writers of one formula share: vocabulary and the clause's name.

    `later` makes a query of a part of the formula, to be compiled when it is asked.
    """

    def __init__(
        self,
        emitter: Emitter,
        vocabulary: Vocabulary,
        where: str,
        later: Callable[[nodes.Formula], object],
    ) -> None:
        self.emitter = emitter
        self.vocabulary = vocabulary
        self.later = later
        self.where = emitter.constant(where)

    def note(self, formula: nodes.Formula, way: Way, **rest: Any) -> None:
        """Note what is done for a part of the formula, before its code is written."""
        step = Step(formula, self.emitter.depth, way, **rest)
        self.emitter.steps.append(step)


def fault(clause: Clause, scope: Scope, what: str) -> None:
    """Trace a fault and give up; `what` is an expression or a constant's name."""
    scope.line(f"ctx.fault({clause.where}, {what})")
    scope.line(scope.skip)


def known_value(clause: Clause, scope: Scope, term: nodes.Term) -> str | None:
    """An expression for a term's value, or None for a variable that is not bound.

    A computed term is computed here, and a fault in it gives up the candidate.
    """
    if isinstance(term, nodes.Const):
        return clause.emitter.constant(term.value)
    if isinstance(term, nodes.Var):
        if term.anonymous or term.name not in scope.bound:
            return None
        return scope.local(term.name)
    return _computed(clause, scope, term)


def bound_value(clause: Clause, scope: Scope, term: nodes.Term) -> str | None:
    """As `known_value`, but a variable that is not bound is a fault that is traced.

    Returns None when the code to give up has been written: nothing may follow.
    """
    known = known_value(clause, scope, term)
    if known is not None:
        return known
    assert isinstance(term, nodes.Var)
    what = clause.emitter.constant(f"{term.name} is not bound")
    fault(clause, scope, what)
    return None


def arguments(
    clause: Clause, scope: Scope, args: Sequence[nodes.Term]
) -> list[str] | None:
    """Expressions for terms that must be bound; None as `bound_value`."""
    found = []
    for arg in args:
        known = bound_value(clause, scope, arg)
        if known is None:
            return None
        found.append(known)
    return found


def _computed(clause: Clause, scope: Scope, term: nodes.Call) -> str:
    args = arguments(clause, scope, term.args)
    if args is None:
        return "UNBOUND"
    listed = "".join(f"{a}, " for a in args)
    function = builtin.FUNCTIONS.get(term.function)
    if function is None:
        return registered(clause, scope, term.function, listed)
    return attempt(clause, scope, f"{clause.emitter.constant(function)}(({listed}))")


def registered(
    clause: Clause, scope: Scope, name: str, listed: str, form: str = "as_value({})"
) -> str:
    """As `attempt`, for what a registered function returns, put into a form.

    An exception that it raises is the host's: it goes on, and says which clause it
    was that asked.
    """
    called = f"ctx.functions[{clause.emitter.constant(name)}](ctx.view, {listed})"
    result = attempt(clause, scope, form.format(called))
    scope.line("except Exception as error:")
    scope.line(f"    error.add_note({clause.where})")
    scope.line("    raise")
    return result


def attempt(clause: Clause, scope: Scope, expression: str) -> str:
    """A new local for what an expression comes to; a fault in it gives up."""
    result = clause.emitter.fresh("t")
    scope.line("try:")
    scope.line(f"    {result} = {expression}")
    scope.line("except Fault as fault:")
    scope.line(f"    ctx.fault({clause.where}, str(fault))")
    scope.line(f"    {scope.skip}")
    return result


def match(clause: Clause, scope: Scope, term: nodes.Term, value: str) -> None:
    """Match a term with a value that is there: test it or bind a variable."""
    known = known_value(clause, scope, term)
    if known is not None:
        scope.refuse(f"{known} != {value}")
        return
    assert isinstance(term, nodes.Var)
    if term.anonymous:
        return
    scope.line(f"{scope.local(term.name)} = {value}")
    scope.bound.add(term.name)
