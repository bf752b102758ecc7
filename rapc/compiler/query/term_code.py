"""Terms to generated Python: known values, computed values, and matching.

`formulas` and `facts` write terms through these functions. A value that is missing or
of the wrong kind is traced as a fault and rejects the candidate [L 2].
"""

from __future__ import annotations

from collections.abc import Sequence

from rapc.compiler.query import builtin
from rapc.compiler.query.function import FunctionWriter
from rapc.ir import nodes


def fault(fn: FunctionWriter, what: str) -> None:
    """Write the code that reports a fault; `what` is an expression for its text."""
    fn.line(f"ctx.fault({fn.where}, {what})")
    fn.line(fn.skip)


def known_value(fn: FunctionWriter, term: nodes.Term) -> str | None:
    """Return an expression for a term's value, or None for an unbound variable.

    A computed term is computed here, and a fault in it rejects the candidate.
    """
    if isinstance(term, nodes.Const):
        return fn.code.constant(term.value)
    if isinstance(term, nodes.Var):
        if term.anonymous or term.name not in fn.bound:
            return None
        return fn.local(term.name)
    return _computed(fn, term)


def bound_value(fn: FunctionWriter, term: nodes.Term) -> str | None:
    """Return the result of `known_value`; trace an unbound variable as a fault.

    Return None after the code for the rejection: no code may follow.
    """
    known = known_value(fn, term)
    if known is not None:
        return known
    assert isinstance(term, nodes.Var)
    own = term.name.partition(" ")[0]  # without the mark of a query's own variables
    what = fn.code.constant(f"{own} is not bound")
    fault(fn, what)
    return None


def argument_code(fn: FunctionWriter, args: Sequence[nodes.Term]) -> list[str] | None:
    """Return expressions for terms that must be bound; None as `bound_value`."""
    found = []
    for arg in args:
        known = bound_value(fn, arg)
        if known is None:
            return None
        found.append(known)
    return found


def _computed(fn: FunctionWriter, term: nodes.Call) -> str:
    args = argument_code(fn, term.args)
    if args is None:
        return "UNBOUND"
    listed = "".join(f"{a}, " for a in args)
    function = builtin.FUNCTIONS.get(term.function)
    if function is None:
        return registered(fn, term.function, listed)
    return attempt(fn, f"{fn.code.constant(function)}(({listed}))")


def registered(
    fn: FunctionWriter, name: str, listed: str, form: str = "as_value({})"
) -> str:
    """Write the call of a registered function; return the local with its result.

    An exception in the function propagates to the host, with a note that names the
    clause.
    """
    called = f"ctx.functions[{fn.code.constant(name)}](ctx.view, {listed})"
    result = attempt(fn, form.format(called))
    fn.line("except Exception as error:")
    fn.line(f"    error.add_note({fn.where})")
    fn.line("    raise")
    return result


def attempt(fn: FunctionWriter, expression: str) -> str:
    """Return a new local for the value of an expression; a fault in it rejects."""
    result = fn.code.fresh("t")
    fn.line("try:")
    fn.line(f"    {result} = {expression}")
    fn.line("except QueryFault as fault:")
    fn.line(f"    ctx.fault({fn.where}, str(fault))")
    fn.line(f"    {fn.skip}")
    return result


def match(fn: FunctionWriter, term: nodes.Term, value: str) -> None:
    """Match a term with a known value: write a test or bind a variable."""
    known = known_value(fn, term)
    if known is not None:
        fn.skip_if(f"{known} != {value}")
        return
    assert isinstance(term, nodes.Var)
    if term.anonymous:
        return
    fn.line(f"{fn.local(term.name)} = {value}")
    fn.bound.add(term.name)
