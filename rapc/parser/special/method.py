"""Readers of a method: its name, its clauses and its body (T 4.5, 4.9; S 3.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rapc.ir import nodes
from rapc.language.heads import METHOD_CLAUSES, heads
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.forms import clauses, read_clauses, single, slots
from rapc.parser.syntax import Datum, List, Numeral, Symbol
from rapc.parser.terms import pattern


def method(ctx: Context, datum: List, position: int) -> nodes.Method:
    """Read `(method [name] clause...)`, with a `task-net` or `primitive` clause.

    `position` counts the methods of a RAP from 1. A method without a body gets an
    empty task-net, and a finding.
    """
    return _method(ctx, datum, datum.items[1:], position)


def define_method(ctx: Context, datum: Datum) -> nodes.DefineMethod | None:
    """Read `(define-method rap [name] clause...)`.

    Linking sets the position of the method among the methods of its RAP.
    """
    assert isinstance(datum, List)
    rap = datum.items[1] if len(datum.items) > 1 else None
    if not isinstance(rap, Symbol):
        ctx.wrong("define_method", rap or datum)
        return None
    made = _method(ctx, datum, datum.items[2:], 1)
    name_span, span = ctx.span(rap), ctx.span(datum)
    return nodes.DefineMethod(rap.name, made, name_span, span=span)


def _method(
    ctx: Context, datum: List, items: Sequence[Datum], position: int
) -> nodes.Method:
    name: str | int | None = None
    if items and type(items[0]) is not List:
        name, items = _name(ctx, items[0]), items[1:]
    found = single(ctx, clauses(ctx, items, "method", METHOD_CLAUSES))
    if "task-net" in found and "primitive" in found:
        found["task-net"] = found.pop("task-net")  # the last one read counts
    fields = read_clauses(ctx, found, "method", _SLOTS)
    _check_body(ctx, datum, found)
    fields["body"] = fields["body"] or nodes.TaskNet((), span=ctx.span(datum))
    return nodes.Method(name, position, span=ctx.span(datum), **fields)


_SLOTS = slots("method", nodes.Method)


def _name(ctx: Context, datum: Datum) -> str | int | None:
    if isinstance(datum, Symbol):
        return datum.name
    if isinstance(datum, Numeral) and isinstance(datum.value, int):
        return datum.value
    ctx.report(
        "malformed-clause",
        "expected a symbol or an integer as the name of a method, not "
        f"{kind_of(datum)}",
        datum,
    )
    return None


def _check_body(ctx: Context, datum: List, found: Mapping[str, Sequence[List]]) -> None:
    net, request = found.get("task-net"), found.get("primitive")
    if net and request:
        ctx.report(
            "malformed-clause",
            "a method takes a `task-net` or a `primitive`, not both",
            request[0].items[0],
            labels=[(net[0].items[0], "the task-net is here")],
        )
    if not net and not request:
        ctx.report(
            "method-without-body",
            "this method requires a `task-net` or a `primitive`",
            datum.items[0],
            help="add a `task-net` or a `primitive`; `(task-net)` does nothing",
        )
    if request and not net:
        for name in _WITH_STEPS:
            for clause in found.get(name, ()):
                ctx.report(
                    "misplaced-clause",
                    f"`{head_of(clause)}` requires a method with a `task-net`",
                    clause.items[0],
                    labels=[(request[0].items[0], "this method has a primitive")],
                )


_WITH_STEPS = heads("_once_net_clause")
"""The clauses about the tasks of a `task-net`."""


def primitive(ctx: Context, clause: Datum) -> nodes.Primitive | nodes.Skills | None:
    """Read `(primitive (request...))` or a primitive of skills."""
    assert type(clause) is List
    operands = clause.items[1:]
    if any(head_of(d) in _SKILL_PARTS for d in operands):
        return _skills(ctx, clause, operands)
    if len(operands) != 1:
        ctx.report(
            "malformed-clause",
            f"`primitive` takes one request, not {len(operands)}",
            operands[1] if operands else clause,
            help="a request is a name and its arguments, as in `(arm-grasp arm1 ?x)`",
        )
    request = pattern(ctx, operands[0], nodes.Request) if operands else None
    return nodes.Primitive(request, span=ctx.span(clause)) if request else None


_SKILL_PARTS = {"enable": "enable", "wait-for": "await", "disable": "disable"}
"""The rules of the parts of a primitive of skills, by first word."""


def _skills(ctx: Context, clause: List, operands: Sequence[Datum]) -> nodes.Skills:
    """Read the parts `(enable (:skill args...)...) (wait-for ...)... (disable ...)`."""
    found: dict[str, list[Any]] = {word: [] for word in _SKILL_PARTS}
    for datum in operands:
        name = head_of(datum)
        if name in found:
            read = ctx.readers[_SKILL_PARTS[name]](ctx, datum)
            found[name] += read if isinstance(read, tuple) else [read] * bool(read)
        else:
            ctx.report(
                "malformed-clause",
                "expected `enable`, `wait-for` or `disable` in a primitive of skills",
                datum,
            )
    return nodes.Skills(*map(tuple, found.values()), span=ctx.span(clause))
