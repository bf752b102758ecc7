"""The expectations of a test that need a hand, and event patterns."""

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
    """`(memory formula)`."""
    asked = lone_formula(ctx, datum)
    return nodes.MemoryHolds(asked, span=ctx.span(datum)) if asked else None


def method_chosen(ctx: Context, datum: List) -> nodes.MethodChosen | None:
    """`(method rap name)`, `(method rap name n)` or `(method rap name n times)`."""
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
    """`(event-name :key value...)`."""
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
    """A term of the trace, as it is written there; None for what is none."""
    if isinstance(datum, List):
        items = [_item(ctx, item) for item in _joined(ctx, datum.items)]
        return nodes.ListPattern(made(items), span=ctx.span(datum))
    if isinstance(datum, Symbol):
        return nodes.Const(datum.name, span=ctx.span(datum))
    return cast(nodes.Const | nodes.Var | None, term(ctx, datum))


def _item(ctx: Context, datum: Datum) -> nodes.TracePattern | None:
    """A term in a list: a goal has the mark before its outputs among its terms."""
    if isinstance(datum, Arrow):
        return nodes.Const(ARROW, span=ctx.span(datum))
    return _value(ctx, datum)


def _joined(ctx: Context, data: Sequence[Datum]) -> list[Datum]:
    """Data in a row; `#counter(3)`, which the reader takes for two, is one symbol."""
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
