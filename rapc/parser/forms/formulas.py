"""Data to formulas: everything that can be asked of memory (semantics 2, T 4.1).

One function per special form; any other list is a proposition, whose name the
checker knows or does not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Literal, cast

from rapc.ir import nodes
from rapc.language.heads import CALLS, TRUTHS
from rapc.parser.special.context import Context, head_of, kind_of
from rapc.parser.special.terms import proposition, term, terms
from rapc.parser.syntax import Datum, List, Symbol

MAX_LEAVES = 200
"""How many propositions and tests a formula may have: queries become nested code."""


def formula(ctx: Context, datum: Datum) -> nodes.Formula | None:
    """A formula of at most `MAX_LEAVES` leaves."""
    if datum.end - datum.start > 2 * MAX_LEAVES and _leaves(datum) > MAX_LEAVES:
        ctx.report(
            "formula-too-large",
            f"this formula asks more than {MAX_LEAVES} things at once",
            datum,
            help="declare a function for it, or split the work between RAPs",
        )
        return None
    return _formula(ctx, datum)


def _leaves(datum: Datum) -> int:
    count, stack = 0, [datum]
    while stack:
        here = stack.pop()
        if isinstance(here, List) and head_of(here) in ("and", "or", "not"):
            stack.extend(here.items[1:])
        else:
            count += 1
    return count


def _formula(ctx: Context, datum: Datum) -> nodes.Formula | None:
    if type(datum) is List:
        name = head_of(datum)
        if name is not None:
            special = _SPECIAL.get(name)
            if special:
                return special(ctx, datum)
            if name not in CALLS and name not in TRUTHS:
                return proposition(ctx, datum)
    elif type(datum) is Symbol and datum.name in TRUTHS:
        return nodes.Truth(TRUTHS[datum.name], ctx.span(datum))
    _no_formula(ctx, datum)
    return None


def _no_formula(ctx: Context, datum: Datum) -> None:
    name = head_of(datum)
    fix = None
    if name in CALLS:
        message = f"`{name}` computes a value, it is no test"
        help = "compare the value with another, as in `(< (value ?count) 3)`"
    elif name in TRUTHS and isinstance(datum, List) and len(datum.items) == 1:
        message = f"`{name}` stands without parentheses"
        help, fix = "", ctx.replace(datum, name or "")
    elif name in TRUTHS:
        message, help = f"`{name}` heads no proposition", ""
    elif isinstance(datum, Symbol):
        message = f"the symbol `{datum.name}` alone is no formula"
        help = f"a proposition has parentheses: `({datum.name})`"
    else:
        message = f"{kind_of(datum)} is no formula"
        if isinstance(datum, List):
            message = "this list is no formula"
        help = "a formula begins with the name of a proposition or a connective"
    ctx.report("malformed-formula", message, datum, help=help, fix=fix)


def _parts(ctx: Context, datum: List) -> tuple[nodes.Formula, ...]:
    return tuple(filter(None, [_formula(ctx, part) for part in datum.items[1:]]))


def _and(ctx: Context, datum: List) -> nodes.Formula | None:
    return nodes.And(_parts(ctx, datum), ctx.span(datum))


def _or(ctx: Context, datum: List) -> nodes.Formula | None:
    parts = _parts(ctx, datum)
    if len(parts) < len(datum.items) - 1:
        return None
    return nodes.Or(parts, ctx.span(datum))


def _not(ctx: Context, datum: List) -> nodes.Formula | None:
    if len(datum.items) == 1:
        ctx.report("malformed-formula", "`not` has nothing to deny", datum)
        return None
    parts = _parts(ctx, datum)
    if len(parts) < len(datum.items) - 1:
        return None
    if len(parts) > 1:
        ctx.slip(
            "not-of-many",
            f"`not` denies one formula, not {len(parts)}",
            datum,
            help="`(not (and a b))` denies them together, "
            "`(and (not a) (not b))` each of them",
            fix=ctx.wrap(datum.items[1], datum.items[-1], "(and ", sure=False),
        )
        parts = (nodes.And(parts, ctx.span(datum)),)
    return nodes.Not(parts[0], ctx.span(datum))


_Comparison = Literal["=", "n=", "<", ">", "<=", ">="]


def _compare(ctx: Context, datum: List) -> nodes.Formula | None:
    op = cast(_Comparison, head_of(datum))
    args = _exactly(ctx, datum, 2, 2, "two terms")
    return nodes.Compare(op, args[0], args[1], ctx.span(datum)) if args else None


def _believe(ctx: Context, datum: List) -> nodes.Formula | None:
    args = datum.items[1:]
    if len(args) == 1 and isinstance(args[0], List):
        ctx.report(
            "believe-without-time",
            "`believe` does not say how fresh the belief has to be",
            datum,
            help="write an age in time units, as in `(believe p 30)`, "
            "or a variable that becomes the age",
            fix=ctx.insert(args[0].end, " ?age", sure=False),
        )
        return None
    if len(args) != 2:
        ctx.report(
            "malformed-formula", "`believe` takes a proposition and an age", datum
        )
        return None
    inner = proposition(ctx, args[0])
    age = term(ctx, args[1])
    if inner is None or age is None:
        return None
    return nodes.Believe(inner, age, ctx.span(datum))


def _member(ctx: Context, datum: List) -> nodes.Formula | None:
    args = _exactly(ctx, datum, 2, 2, "a set and a thing")
    return nodes.SetTest("member", args, ctx.span(datum)) if args else None


def _empty(ctx: Context, datum: List) -> nodes.Formula | None:
    args = _exactly(ctx, datum, 1, 1, "a set")
    return nodes.SetTest("empty", args, ctx.span(datum)) if args else None


def _method_tried(ctx: Context, datum: List) -> nodes.Formula | None:
    args = _exactly(ctx, datum, 1, 1, "the name of a method")
    return nodes.HistoryTest("method-tried", args, ctx.span(datum)) if args else None


def _last_result(ctx: Context, datum: List) -> nodes.Formula | None:
    args = _exactly(ctx, datum, 1, 1, "a result")
    return nodes.HistoryTest("last-result", args, ctx.span(datum)) if args else None


def _result_with_method(ctx: Context, datum: List) -> nodes.Formula | None:
    args = _exactly(ctx, datum, 2, 2, "the name of a method and a result")
    return (
        nodes.HistoryTest("result-with-method", args, ctx.span(datum)) if args else None
    )


def _know_sensor_name(ctx: Context, datum: List) -> nodes.Formula | None:
    args = _exactly(ctx, datum, 1, 2, "an item and, if wanted, `true` or `false`")
    if args is None:
        return None
    span = ctx.span(datum)
    value = args[1] if len(args) == 2 else nodes.Const("true", span)
    if isinstance(value, nodes.Const) and value.value not in ("true", "false"):
        message = "`know-sensor-name` is `true` or `false` of an item"
        ctx.report("malformed-formula", message, datum.items[2])
        return None
    return nodes.SensorName(args[0], value, span)


def _count(ctx: Context, datum: List) -> nodes.Formula | None:
    args = _exactly(ctx, datum, 3, 3, "a class, a place and a number")
    return nodes.Count(args[0], args[1], args[2], ctx.span(datum)) if args else None


def _exactly(
    ctx: Context, datum: List, least: int, most: int, words: str
) -> tuple[nodes.Term, ...] | None:
    count = len(datum.items) - 1
    if not least <= count <= most:
        message = f"`{head_of(datum)}` takes {words}"
        ctx.report("malformed-formula", message, datum)
        return None
    args = terms(ctx, datum.items[1:])
    return args if len(args) == count else None


_SPECIAL: Mapping[str, Callable[[Context, List], nodes.Formula | None]] = {
    "and": _and,
    "or": _or,
    "not": _not,
    **dict.fromkeys(("=", "n=", "<", ">", "<=", ">="), _compare),
    "believe": _believe,
    "member": _member,
    "empty": _empty,
    "method-tried": _method_tried,
    "last-result": _last_result,
    "result-with-method": _result_with_method,
    "know-sensor-name": _know_sensor_name,
    "count": _count,
}
"""The special forms of formulas, by their first word."""
