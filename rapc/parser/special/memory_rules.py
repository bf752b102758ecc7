"""Readers of rules over memory, `define-memory-rule` and `define-event-rule`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, cast

from rapc.ir import nodes
from rapc.language.heads import ALONE, heads
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.generic import made
from rapc.parser.special.formulas import formula
from rapc.parser.syntax import Datum, Keyword, List, Symbol, Variable
from rapc.parser.terms import goal, signal, terms

_ACTIONS = heads("action")


def memory_rule(ctx: Context, form: List) -> nodes.MemoryRule | None:
    """Read `(define-memory-rule index when (match-result case...))` (S 4.2)."""
    operands = form.items[1:]
    index = goal(ctx, operands[0]) if operands else None
    when = operands[1] if len(operands) > 1 else None
    body = operands[2] if len(operands) == 3 else None
    if not isinstance(when, Keyword) or when.name not in (":finish", ":event"):
        ctx.wrong("define_memory_rule", when or form)
        return None
    if not isinstance(body, List) or head_of(body) != "match-result":
        ctx.wrong("match_result", body or form)
        return None
    if index is None:
        return None
    cases = made(_case(ctx, one) for one in body.items[1:])
    moment = cast(Literal["finish", "event"], when.name[1:])
    return nodes.MemoryRule(index, moment, cases, span=ctx.span(form))


def _case(ctx: Context, datum: Datum) -> nodes.ResultCase | None:
    """Read `(pattern (rule ...)...)`."""
    if not isinstance(datum, List) or not datum.items:
        ctx.wrong("case", datum)
        return None
    first = datum.items[0]
    result: nodes.Const | nodes.Var | nodes.Signal | None = None
    if isinstance(first, Symbol):
        result = nodes.Const(first.name, span=ctx.span(first))
    elif isinstance(first, Variable):
        result = nodes.Var(first.name, span=ctx.span(first))
    elif isinstance(first, List) and first.items:
        result = _awaited(ctx, first)
    else:
        message = (
            "expected a symbol, a variable or a signal as a result, not "
            f"{kind_of(first)}"
        )
        ctx.report("malformed-rule", message, first)
    found = _headed(ctx, "rule", datum.items[1:])
    return nodes.ResultCase(result, found, span=ctx.span(datum)) if result else None


def _awaited(ctx: Context, datum: List) -> nodes.Signal | None:
    """Read a signal, with or without its colon: S 4.2 has no colon here."""
    first = datum.items[0]
    if isinstance(first, Symbol):
        args = terms(ctx, datum.items[1:])
        return nodes.Signal(f":{first.name}", args, span=ctx.span(datum))
    return signal(ctx, datum)


def event_rule(ctx: Context, form: List) -> nodes.EventRule | None:
    """Read `(define-event-rule (:signal args...) (rule ...)...)` (S 4.3)."""
    operands = form.items[1:]
    if not operands:
        ctx.report("malformed-rule", "expected a signal in an event rule", form)
        return None
    awaited = signal(ctx, operands[0])
    found = _headed(ctx, "rule", operands[1:])
    if awaited is None:
        return None
    if len(operands) == 1:
        ctx.report(
            "malformed-rule",
            "an event rule requires rules that state how the signal changes memory",
            form,
            help="write `(rule (query (mem-add fact)))` after the signal",
        )
    return nodes.EventRule(awaited.name, awaited.args, found, span=ctx.span(form))


def _headed(ctx: Context, rule: str, data: Sequence[Datum]) -> tuple[Any, ...]:
    """Read data that must be lists of a rule; report other data."""
    words, read = heads(rule), ctx.readers[rule]
    for one in data:
        if head_of(one) not in words:
            ctx.wrong(rule, one)
    return made(read(ctx, one) for one in data if head_of(one) in words)


def whole_rule(ctx: Context, datum: List) -> List:
    """Return `(rule (query action...)...)` with parentheses around its alternative."""
    operands = datum.items[1:]
    if not any(head_of(one) in _ACTIONS for one in operands):
        return datum
    ctx.report_fixable(
        "bare-rule",
        "the query and the actions of a rule require parentheses",
        datum.items[0],
        fix=ctx.wrap(operands[0], operands[-1], "("),
    )
    inner = List(operands, operands[0].start, operands[-1].end)
    return List((datum.items[0], inner), datum.start, datum.end)


def alternative(ctx: Context, datum: Datum) -> nodes.Alternative | None:
    """Read `(query action...)`, or only actions, which always run."""
    named = head_of(datum) not in (None, *ALONE)
    if not isinstance(datum, List) or not datum.items or named:
        ctx.wrong("alternative", datum)
        return None
    query: nodes.Formula | None = nodes.Truth(True, span=ctx.span(datum))
    actions = datum.items
    if head_of(datum.items[0]) not in _ACTIONS:
        query, actions = formula(ctx, datum.items[0]), datum.items[1:]
    read = _headed(ctx, "action", actions)
    return nodes.Alternative(query, read, span=ctx.span(datum)) if query else None
