"""Readers of `define-test` and `define-agenda`, with scripts and timed actions.

Not here: expectations (`rapc.parser.special.expectations`), and the meaning of a test
(docs/reference/tests.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from rapc.base.limits import MAX_TIMES
from rapc.base.values import Number, format_atom
from rapc.ir import nodes
from rapc.language.heads import TEST_CLAUSES, often
from rapc.parser.context import Context, head_of
from rapc.parser.forms import (
    clauses,
    filled,
    name_of,
    read_clauses,
    read_options,
    single,
    slots,
)
from rapc.parser.generic import made
from rapc.parser.syntax import Datum, List, String, Symbol


def define_test(ctx: Context, form: List) -> nodes.DefineTest | None:
    """Read `(define-test name ["doc"] clause...)`."""
    name = name_of(ctx, form, colon=False)
    if name is None:
        return None
    data = form.items[2:]
    if data and isinstance(data[0], String):
        return _test(ctx, form, name, data[0].value, data[1:])
    return _test(ctx, form, name, "", data)


def define_test_defaults(ctx: Context, form: List) -> nodes.DefineTest:
    """Read `(define-test-defaults clause...)`, the test defaults, as a test."""
    return _test(ctx, form, None, "", form.items[1:])


def _test(
    ctx: Context, form: List, name: str | None, doc: str, data: Sequence[Datum]
) -> nodes.DefineTest:
    """Return a test, or the test defaults of a file, from the data after the name."""
    owner = head_of(form) or ""
    found = clauses(ctx, data, owner, TEST_CLAUSES)
    kept = single(ctx, found, often("define_test"))
    into = slots("define_test", nodes.DefineTest)
    ends = [
        read_clauses(ctx, {word: kept.pop(word)}, "_test_clause", into)["until"]
        for word in ("until", "cycles")
        if word in kept
    ]
    fields = read_clauses(ctx, kept, "_test_clause", into)
    fields["until"] = _until(made(ends))
    return nodes.DefineTest(
        name or "",
        doc,
        name_span=ctx.span(form.items[0 if name is None else 1]),
        span=ctx.span(form),
        **fields,
    )


def _until(found: Sequence[nodes.Until]) -> nodes.Until | None:
    """Join `(until t)`, `(until (cycles n))` and the clause `(cycles n)` to a node."""
    if not found:
        return None
    times = [one.time for one in found if one.time is not None]
    cycles = [one.cycles for one in found if one.cycles is not None]
    time, count = next(iter(times), None), next(iter(cycles), None)
    return nodes.Until(time, count, span=found[-1].span)


# --- agendas ------------------------------------------------------------------------


def define_agenda(ctx: Context, form: List) -> nodes.DefineAgenda | None:
    """Read `(define-agenda name (require "name")... task...)`."""
    name = name_of(ctx, form, colon=False)
    if name is None:
        return None
    words = tuple(ctx.readers.group("_agenda_clause"))
    found = clauses(ctx, form.items[2:], "define-agenda", words)
    kept = single(ctx, found, often("define_agenda"))
    into = slots("define_agenda", nodes.DefineAgenda)
    fields = read_clauses(ctx, kept, "_agenda_clause", into)
    where = ctx.span(form.items[1])
    return nodes.DefineAgenda(name, name_span=where, span=ctx.span(form), **fields)


# --- actions at a time --------------------------------------------------------------


def at(ctx: Context, datum: List) -> nodes.At | None:
    """Read `(at time [:every n :until t] action...)`."""
    data = datum.items[1:]
    if not data:
        ctx.report("malformed-clause", "`at` requires a time", datum)
        return None
    time = cast(Number | None, ctx.readers["TIME"](ctx, data[0]))
    lists = [n for n, one in enumerate(data) if n and isinstance(one, List)]
    first = min(lists, default=len(data))
    options = read_options(ctx, data[1:first], "`at`", "_once_at_option")
    known = ctx.readers.group("_action")
    found = clauses(ctx, data[first:], "at", tuple(known))
    actions = made(known[word](ctx, one) for word, one in found)
    if time is None:
        return None
    fields = filled(slots("at", nodes.At), options)
    every, until = fields["every"], fields["until"]
    wrong = ""
    if len(options) == 1:
        wrong = "a repeated `at` requires both `:every` and `:until`"
    elif every and until is not None and not 0 <= until - time <= every * MAX_TIMES:
        early = f"`:until` is before the time {format_atom(time)}"
        wrong = early if until < time else f"more than {MAX_TIMES} times of an `at`"
    if wrong:
        ctx.report("malformed-clause", wrong, datum)
        fields = {}
    return nodes.At(time, actions, span=ctx.span(datum), **fields)


# --- the script ---------------------------------------------------------------------


def row(ctx: Context, datum: Datum) -> nodes.ScriptRow | None:
    """Read `((request) [result] option...)`."""
    if not isinstance(datum, List) or not datum.items:
        ctx.wrong("script_row", datum)
        return None
    first, *rest = datum.items
    word = head_of(first)
    asked = ctx.readers[_ASKED.get(word or "", "required")](ctx, first)
    result = None
    if rest and isinstance(rest[0], Symbol):
        result, rest = rest[0].name, rest[1:]
    read = read_options(ctx, rest, "a row", "_once_row_option")
    if asked is None:
        return None
    fields = filled(slots("script_row", nodes.ScriptRow), read)
    fields["signals"], fields["pauses"] = _with_pauses(fields["signals"])
    kind = cast(nodes.RowKind, word if word in _ASKED else "request")
    return nodes.ScriptRow(
        kind=kind, request=asked, result=result, span=ctx.span(datum), **fields
    )


_ASKED = {"enable": "enabled", "disable": "disabled"}
"""The rules of the events besides requests that a row may answer, by first word."""


def _with_pauses(
    told: Sequence[nodes.Signal | Number],
) -> tuple[tuple[nodes.Signal, ...], tuple[Number, ...]]:
    """Return the signals of a row, and the pause before each signal."""
    found: list[nodes.Signal] = []
    pauses: list[Number] = []
    pause: Number = 0
    for one in told:
        if isinstance(one, nodes.Signal):
            found.append(one)
            pauses.append(pause)
            pause = 0
        else:
            pause += one
    return tuple(found), tuple(pauses) if any(pauses) else ()
