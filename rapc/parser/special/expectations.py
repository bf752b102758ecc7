"""Special readers of the expectations of a test, and of event patterns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from rapc.ir import nodes
from rapc.language.heads import ARROW
from rapc.parser.context import Context, head_of
from rapc.parser.forms import options
from rapc.parser.generic import made, terminal
from rapc.parser.special.formulas import lone_formula
from rapc.parser.syntax import Arrow, Datum, Keyword, List, Numeral, Symbol
from rapc.parser.terms import term


def memory(ctx: Context, datum: Datum) -> nodes.MemoryHolds | None:
    """Read `(memory formula)`."""
    asked = lone_formula(ctx, datum)
    return nodes.MemoryHolds(asked, span=ctx.span(datum)) if asked else None


def method_chosen(ctx: Context, datum: List) -> nodes.MethodChosen | None:
    """Read `(method rap name)`, `(method rap name n)`, `(method rap name n times)`."""
    operands = list(datum.items[1:])
    last = operands[-1] if len(operands) == 4 else None
    if isinstance(last, Symbol) and last.name in ("times", "time"):
        del operands[-1]
    rap, name = operands[:2] if len(operands) in (2, 3) else (datum, datum)
    if not isinstance(rap, Symbol) or not isinstance(name, Symbol | Numeral):
        ctx.wrong("method_chosen", datum)
        return None
    count = terminal("COUNT").read
    times = count(ctx, operands[2]) or 0 if operands[2:] else None
    word = name.name if isinstance(name, Symbol) else str(name.value)
    return nodes.MethodChosen(rap.name, word, times, span=ctx.span(datum))


# --- event patterns -------------------------------------------------------------------


def event_pattern(ctx: Context, datum: Datum) -> nodes.EventPattern | None:
    """Read `(event-name :key value...)`."""
    name = head_of(datum)
    if name is None or not isinstance(datum, List):
        ctx.wrong("event_pattern", datum)
        return None
    rest = _joined(ctx, datum.items[1:])
    words = {word.name: 1 for word in rest if isinstance(word, Keyword)}
    given = options(ctx, rest, f"`{name}`", words)
    values = {key[1:]: _value(ctx, one.items[1]) for key, one in given.items()}
    keys = tuple((key, value) for key, value in values.items() if value is not None)
    return nodes.EventPattern(name, keys, span=ctx.span(datum))


def _value(ctx: Context, datum: Datum) -> nodes.TracePattern | None:
    """Read a term in the form of the trace; return None for invalid data."""
    if isinstance(datum, List):
        items = [_item(ctx, item) for item in _joined(ctx, datum.items)]
        return nodes.ListPattern(made(items), span=ctx.span(datum))
    if isinstance(datum, Symbol):
        return nodes.Const(datum.name, span=ctx.span(datum))
    return cast(nodes.Const | nodes.Var | None, term(ctx, datum))


def _item(ctx: Context, datum: Datum) -> nodes.TracePattern | None:
    """Read a term in a list; a list for a goal may have the mark before its outputs."""
    if isinstance(datum, Arrow):
        return nodes.Const(ARROW, span=ctx.span(datum))
    return _value(ctx, datum)


def _joined(ctx: Context, data: Sequence[Datum]) -> list[Datum]:
    """Return data with `#counter(3)`, two data for the reader, joined to a symbol."""
    found: list[Datum] = []
    for datum in data:
        last = found[-1] if found else None
        if (
            isinstance(datum, List)
            and isinstance(last, Symbol)
            and last.name in ("#counter", "#set")
            and last.end == datum.start
        ):
            words = [ctx.text(item).lower() for item in datum.items]
            name = f"{last.name}({' '.join(words)})"
            found[-1] = Symbol(name, last.start, datum.end)
        else:
            found.append(datum)
    return found
