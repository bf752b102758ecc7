"""Readers of `define-rap` and its clauses, in both spellings (T chapter 4, S 3).

Not here: methods (`rapc.parser.special.method`).
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Sequence
from typing import Literal, cast

from rapc.base.diagnostics import Fix
from rapc.base.names import nearest
from rapc.ir import nodes
from rapc.language.heads import METHOD_CLAUSES, RAP_CLAUSES, often
from rapc.parser.context import Context, head_of
from rapc.parser.forms import (
    clauses,
    parameter,
    parameters,
    read_clauses,
    single,
    slots,
)
from rapc.parser.generic import made
from rapc.parser.special.method import method
from rapc.parser.syntax import Datum, List, Symbol, Variable
from rapc.parser.terms import split_arrow, term


def define_rap(ctx: Context, datum: Datum) -> nodes.DefineRap | None:
    """Read `(define-rap (index (name in... => out...)) clause...)`.

    The word `index` and its parentheses may be left out.
    """
    assert isinstance(datum, List)
    items = datum.items[1:]
    index: Datum | None = None
    if items and _is_index(items[0]):
        index, items = items[0], items[1:]
    found = single(ctx, clauses(ctx, items, "define-rap", RAP_CLAUSES), _OFTEN)
    for clause in found.pop("index", ()):
        if index is None:
            index = _index(ctx, clause)
        else:
            ctx.report(
                "duplicate-clause",
                "duplicate index of this RAP",
                clause.items[0],
                labels=[(index, "the first is here")],
            )
    name = _name(ctx, datum, index)
    if name is None or index is None:
        return None
    return _rap(ctx, datum, name, index, found)


def _is_index(datum: Datum) -> bool:
    """Return whether a first operand is the index itself (S 3), not a clause."""
    name = head_of(datum)
    if name is None or not isinstance(datum, List):
        return isinstance(datum, Symbol | List)
    if name in RAP_CLAUSES or name in METHOD_CLAUSES:
        return False
    if all(type(item) is not List or _has_kind(item) for item in datum.items):
        return True
    return nearest(name, RAP_CLAUSES) is None


def _has_kind(datum: List) -> bool:
    """Return whether a list in a first operand is an input with its kind."""
    return [type(item) for item in datum.items] == [Variable, Symbol]


def _index(ctx: Context, clause: List) -> Datum | None:
    """Return the index in an `index` clause; None if the clause is empty."""
    operands = clause.items[1:]
    if operands and isinstance(operands[0], Symbol):
        ctx.report_fixable(
            "malformed-goal",
            "the index requires its own parentheses",
            operands[0],
            fix=ctx.wrap(operands[0], operands[-1], "("),
        )
        return List(operands, operands[0].start, operands[-1].end)
    for extra in operands[1:]:
        name = head_of(extra)
        ctx.report(
            "malformed-clause",
            "`index` takes exactly one list",
            extra,
            help=f"a `)` may be missing before `({name}`"
            if name in RAP_CLAUSES
            else "",
        )
    return operands[0] if operands else None


def _name(ctx: Context, datum: List, index: Datum | None) -> Symbol | None:
    """Return the name in an index; report a missing name and return None."""
    if type(index) is Symbol:
        ctx.report(
            "malformed-goal",
            "the index requires parentheses",
            index,
            help=f"write `({index.name} ?input... => ?output...)`",
            fix=ctx.wrap(index, index, "(", sure=False),
        )
        return index
    if type(index) is List and index.items:
        first = index.items[0]
        if isinstance(first, Symbol):
            return first
        message = "expected the name of the RAP in the index"
        ctx.report("malformed-goal", message, first)
        return None
    ctx.report(
        "missing-index",
        "this RAP requires a name",
        index or datum.items[0],
        help="write `(define-rap (index (name ?input... => ?output...)) ...)`",
    )
    return None


def _rap(
    ctx: Context,
    datum: List,
    name: Symbol,
    index: Datum,
    found: dict[str, list[List]],
) -> nodes.DefineRap:
    whole = index if type(index) is List else List((), name.start, name.end)
    before, after = split_arrow(ctx, whole)
    seen: dict[str, Datum] = {}
    inputs = parameters(ctx, before, seen)
    outputs = parameters(ctx, after, seen)
    rows = found.pop("method", ())
    fields = read_clauses(ctx, found, "_rap_clause", _SLOTS)
    if rows:
        fields["methods"] = _methods(ctx, rows)
    return nodes.DefineRap(
        name.name,
        tuple([one.variable for one in inputs]),
        tuple([one.variable for one in outputs]),
        _kinds(inputs + outputs),
        name_span=ctx.span(name),
        span=ctx.span(datum),
        **fields,
    )


def _kinds(given: Iterable[nodes.Argument]) -> tuple[nodes.VariableKind, ...]:
    """Return the declared kinds of inputs and outputs."""
    return tuple(
        [
            nodes.VariableKind(one.variable.name, one.kind, span=one.span)
            for one in given
            if one.kind is not None
        ]
    )


def _methods(ctx: Context, rows: Sequence[List]) -> tuple[nodes.Method, ...]:
    methods = [method(ctx, row, at) for at, row in enumerate(rows, start=1)]
    if len(rows) > 1:
        _check_method_names(ctx, methods, rows)
    return tuple(methods)


_SLOTS = slots("define_rap", nodes.DefineRap)
_OFTEN = often("define_rap")


def bare_times(ctx: Context, clause: List) -> List:
    """Return a `monitor-time` without parentheses around its times [T 4.7.1]."""
    inner = clause.items[1] if len(clause.items) == 2 else None
    if not isinstance(inner, List):
        return clause
    ctx.report_fixable(
        "parenthesised-times",
        "the times of `monitor-time` must not have parentheses",
        inner,
        fix=ctx.replace(inner, ctx.text(inner)[1:-1].strip()),
    )
    return List((clause.items[0], *inner.items), clause.start, clause.end)


def resources(ctx: Context, clause: Datum) -> tuple[nodes.Resource, ...]:
    """Read `(resources resource...)`; duplicate names are reported."""
    assert isinstance(clause, List)
    seen: dict[str, Datum] = {}
    return made(_resource(ctx, row, seen) for row in clause.items[1:])


def _resource(
    ctx: Context, datum: Datum, seen: dict[str, Datum]
) -> nodes.Resource | None:
    """Read `(set ?name [set])` or `(counter ?name [number-or-counter])` (T 4.8.1)."""
    kind = head_of(datum)
    operands = datum.items[1:] if isinstance(datum, List) else ()
    if kind not in ("set", "counter") or not 1 <= len(operands) <= 2:
        ctx.wrong("resource", datum)
        return None
    variable = parameter(ctx, operands[0], seen)
    initial = term(ctx, operands[1]) if len(operands) == 2 else None
    if variable is None:
        return None
    named = cast(Literal["set", "counter"], kind)
    return nodes.Resource(named, variable, initial, span=ctx.span(datum))


def _check_method_names(
    ctx: Context, methods: Sequence[nodes.Method], data: Sequence[List]
) -> None:
    first: dict[str | int, List] = {}
    taken = {one.name for one in methods}
    for one, datum in zip(methods, data, strict=True):
        if one.name is None:
            continue
        other = first.setdefault(one.name, datum)
        if other is not datum:
            ctx.incomplete = True
            ctx.certain(
                "duplicate-method",
                f"duplicate method name `{one.name}`",
                datum.items[1],
                labels=[(other.items[1], "the first is here")],
                help="`method-tried` and `result-with-method` identify methods by name",
                fix=_renumbered(ctx, one, datum.items[1], taken),
            )


def _renumbered(
    ctx: Context, method: nodes.Method, name: Datum, taken: Container[str | int | None]
) -> Fix | None:
    """Return the fix that replaces the number in a method's name by its position.

    The fix is unsafe: other uses of the duplicate number may mean either method.
    """
    number = method.position
    if not isinstance(method.name, int) or number in taken:
        return None
    return ctx.replace(name, str(number), sure=False)
