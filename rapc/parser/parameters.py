"""Parameters: variables in a row, with kinds or without, none of them twice."""

from __future__ import annotations

from collections.abc import Sequence

from rapc.base.source import Span
from rapc.ir import nodes
from rapc.parser.context import Context, kind_of
from rapc.parser.findings import wrong
from rapc.parser.syntax import Datum, List, Symbol, Variable


def arguments(ctx: Context, datum: Datum) -> tuple[nodes.Argument, ...]:
    """`(?variable ...)`, each of them with its kind if wanted: `(?size number)`."""
    if not isinstance(datum, List):
        wrong(ctx, "arguments", datum)
        return ()
    return parameters(ctx, datum.items, {})


def valued(ctx: Context, datum: Datum) -> tuple[nodes.Argument, ...]:
    """The arguments of a property, the last of which is its value."""
    made = arguments(ctx, datum)
    if isinstance(datum, List) and not datum.items:
        wrong(ctx, "valued", datum)
    return made


def parameters(
    ctx: Context, data: Sequence[Datum], seen: dict[str, Datum]
) -> tuple[nodes.Argument, ...]:
    """Variables in a row, with kinds or without, none of them among those `seen`."""
    if not data:
        return ()
    return tuple(filter(None, [_argument(ctx, one, seen) for one in data]))


def _argument(
    ctx: Context, datum: Datum, seen: dict[str, Datum]
) -> nodes.Argument | None:
    if type(datum) is not List or not datum.items:
        variable = parameter(ctx, datum, seen)
        return nodes.Argument(variable, None, span=variable.span) if variable else None
    kind = symbol(ctx, datum.items[1], "a kind") if len(datum.items) == 2 else None
    if len(datum.items) != 2:
        wrong(ctx, "argument", datum)
    variable = parameter(ctx, datum.items[0], seen)
    return nodes.Argument(variable, kind, span=ctx.span(datum)) if variable else None


def parameter(ctx: Context, datum: Datum, seen: dict[str, Datum]) -> nodes.Var | None:
    """A variable with a name that is not yet among those `seen`."""
    if type(datum) is not Variable or datum.name == "?":
        named = _named(ctx, datum)
        if named is None:
            return None
        datum = named
    first = seen.setdefault(datum.name, datum)
    if first is not datum:
        ctx.report(
            "repeated-variable",
            f"`{datum.name}` stands here twice",
            datum,
            labels=[(first, "the first is here")],
        )
    return nodes.Var(datum.name, span=Span(ctx.file, datum.start, datum.end))


def _named(ctx: Context, datum: Datum) -> Variable | None:
    """Return the variable that a symbol was meant for; report whatever it is."""
    if isinstance(datum, Symbol):
        ctx.report_fixable(
            "malformed-form",
            f"the variable `?{datum.name}` lacks its `?`",
            datum,
            fix=ctx.replace(datum, f"?{datum.name}"),
        )
        return Variable(f"?{datum.name}", datum.start, datum.end)
    what = "a bare `?`" if isinstance(datum, Variable) else kind_of(datum)
    message = f"a variable with a name is wanted here, not {what}"
    ctx.report("malformed-form", message, datum)
    return None


def symbol(ctx: Context, datum: Datum, what: str) -> str | None:
    """A symbol's name; anything else is reported."""
    if isinstance(datum, Symbol):
        return datum.name
    ctx.report("malformed-form", f"{what} is wanted here, not {kind_of(datum)}", datum)
    return None
