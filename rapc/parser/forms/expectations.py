"""The expectations of a test, one function each, and event patterns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, cast

from rapc.ir import nodes
from rapc.parser.special.clauses import lone_formula
from rapc.parser.special.context import Context, head_of, kind_of
from rapc.parser.special.script import (
    asked_goal,
    made,
    number,
    options,
    request,
    requests,
    whole,
)
from rapc.parser.special.terms import term, terms
from rapc.parser.syntax import Datum, Keyword, List, Numeral, Symbol, Variable


class _Kind(NamedTuple):
    """How an expectation is written, how many operands it takes, who reads it."""

    form: str
    least: int
    most: int | None
    read: Callable[[Context, List], nodes.Expectation | None]


def expectations(ctx: Context, data: Sequence[Datum]) -> tuple[nodes.Expectation, ...]:
    """What stands in an `expect`."""
    return made(_expectation(ctx, datum) for datum in data)


def _expectation(ctx: Context, datum: Datum) -> nodes.Expectation | None:
    name = head_of(datum)
    if name is None or not isinstance(datum, List):
        message = f"an expectation is wanted here, not {kind_of(datum)}"
        help = "expectations begin with " + ", ".join(f"`{name}`" for name in KINDS)
        ctx.report("malformed-clause", message, datum, help=help)
        return None
    if name not in KINDS:
        ctx.unknown(
            "unknown-clause", "expectation", cast(Symbol, datum.items[0]), KINDS
        )
        return None
    kind = KINDS[name]
    count = len(datum.items) - 1
    if count < kind.least or (kind.most is not None and count > kind.most):
        _wrong(ctx, datum)
        return None
    return kind.read(ctx, datum)


def _wrong(ctx: Context, datum: List) -> None:
    name = head_of(datum) or ""
    message = f"`{name}` is written `{KINDS[name].form}`"
    ctx.report("malformed-clause", message, datum)


def _succeeds(ctx: Context, datum: List) -> nodes.Succeeds | None:
    asked = asked_goal(ctx, datum.items[1])
    outputs = terms(ctx, datum.items[2:])
    if any(isinstance(one, nodes.Call) for one in outputs):
        _wrong(ctx, datum)
        return None
    return nodes.Succeeds(asked, outputs, ctx.span(datum)) if asked else None


def _fails(ctx: Context, datum: List) -> nodes.Fails | None:
    asked = asked_goal(ctx, datum.items[1])
    result = None
    if len(datum.items) == 3:
        word = datum.items[2]
        if not isinstance(word, Symbol | Variable):
            _wrong(ctx, datum)
            return None
        result = cast(nodes.Const | nodes.Var, term(ctx, word))
    return nodes.Fails(asked, result, ctx.span(datum)) if asked else None


def _active(ctx: Context, datum: List) -> nodes.Active | None:
    asked = asked_goal(ctx, datum.items[1])
    return nodes.Active(asked, ctx.span(datum)) if asked else None


def _primitives(ctx: Context, datum: List) -> nodes.Primitives:
    return nodes.Primitives(requests(ctx, datum.items[1:]), ctx.span(datum))


def _include(ctx: Context, datum: List) -> nodes.PrimitivesInclude:
    return nodes.PrimitivesInclude(requests(ctx, datum.items[1:]), ctx.span(datum))


def _never(ctx: Context, datum: List) -> nodes.Never | None:
    unwanted = request(ctx, datum.items[1])
    return nodes.Never(unwanted, ctx.span(datum)) if unwanted else None


def _memory(ctx: Context, datum: List) -> nodes.MemoryHolds | None:
    formula = lone_formula(ctx, datum)
    return nodes.MemoryHolds(formula, ctx.span(datum)) if formula else None


def _method(ctx: Context, datum: List) -> nodes.MethodChosen | None:
    """`(method rap name)`, `(method rap name n)` or `(method rap name n times)`."""
    rap, name, *more = datum.items[1:]
    if len(more) == 2 and isinstance(more[1], Symbol) and more[1].name in _TIMES:
        del more[1]
    if (
        not isinstance(rap, Symbol)
        or not isinstance(name, Symbol | Numeral)
        or len(more) > 1
    ):
        _wrong(ctx, datum)
        return None
    times = whole(ctx, more[0], "a number", least=0) if more else None
    word = name.name if isinstance(name, Symbol) else str(name.value)
    return nodes.MethodChosen(rap.name, word, times, ctx.span(datum))


_TIMES = ("times", "time")


def _selected_before(ctx: Context, datum: List) -> nodes.SelectedBefore | None:
    first, second = asked_goal(ctx, datum.items[1]), asked_goal(ctx, datum.items[2])
    if first is None or second is None:
        return None
    return nodes.SelectedBefore(first, second, ctx.span(datum))


def _ends_by(ctx: Context, datum: List) -> nodes.EndsBy | None:
    time = number(ctx, datum.items[1], "a time")
    asked = asked_goal(ctx, datum.items[2])
    if time is None or asked is None:
        return None
    return nodes.EndsBy(time, asked, ctx.span(datum))


# --- event patterns -------------------------------------------------------------------


def _trace(ctx: Context, datum: List) -> nodes.TraceHas:
    events = made(_event(ctx, one) for one in datum.items[1:])
    return nodes.TraceHas(events, ctx.span(datum))


def _event(ctx: Context, datum: Datum) -> nodes.EventPattern | None:
    """`(event-name :key value...)`."""
    name = head_of(datum)
    if name is None or not isinstance(datum, List):
        message = f"an event pattern is wanted here, not {kind_of(datum)}"
        help = "write `(task-failed :reason no-method)`"
        ctx.report("malformed-clause", message, datum, help=help)
        return None
    rest = _joined(ctx, datum.items[1:])
    words = {word.name: 1 for word in rest if isinstance(word, Keyword)}
    given = options(ctx, rest, f"`{name}`", words)
    keys = tuple((key[1:], _value(ctx, value)) for key, value in given.items())
    return nodes.EventPattern(name, keys, ctx.span(datum))


def _value(ctx: Context, datum: Datum) -> nodes.TracePattern:
    """A term of the trace, as it is written there."""
    if isinstance(datum, List):
        items = [_value(ctx, item) for item in _joined(ctx, datum.items)]
        return nodes.ListPattern(tuple(items), ctx.span(datum))
    if isinstance(datum, Symbol):
        return nodes.Const(datum.name, ctx.span(datum))
    return cast(nodes.Const | nodes.Var, term(ctx, datum))


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


KINDS: Mapping[str, _Kind] = {
    "succeeds": _Kind("(succeeds (goal) output...)", 1, None, _succeeds),
    "fails": _Kind("(fails (goal) result)", 1, 2, _fails),
    "active": _Kind("(active (goal))", 1, 1, _active),
    "primitives": _Kind("(primitives (request)...)", 0, None, _primitives),
    "primitives-include": _Kind("(primitives-include (request)...)", 1, None, _include),
    "never": _Kind("(never (request))", 1, 1, _never),
    "memory": _Kind("(memory formula)", 1, None, _memory),
    "method": _Kind("(method rap name 2 times)", 2, 4, _method),
    "selected-before": _Kind("(selected-before (goal) (goal))", 2, 2, _selected_before),
    "ends-by": _Kind("(ends-by time (goal))", 2, 2, _ends_by),
    "trace": _Kind("(trace (event :key value...)...)", 1, None, _trace),
}
"""The expectations by the word they begin with."""
