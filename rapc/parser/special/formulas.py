"""Special readers of formulas, the queries over memory [T 4.1].

A list with a first word outside the language is a proposition. The checker checks its
declaration.
"""

from __future__ import annotations

from rapc.base.limits import MAX_LEAVES
from rapc.base.source import Span
from rapc.ir import nodes
from rapc.language.heads import ALONE, CALLS, METHOD_CLAUSES, RAP_CLAUSES, TRUTHS
from rapc.parser.context import Context, Read, head_of, kind_of
from rapc.parser.syntax import Datum, List, Symbol
from rapc.parser.terms import constant, terms


def formula(ctx: Context, datum: Datum) -> nodes.Formula | None:
    """Read a formula of at most `MAX_LEAVES` leaves."""
    if datum.end - datum.start > 2 * MAX_LEAVES and _leaves(datum) > MAX_LEAVES:
        ctx.report(
            "formula-too-large",
            f"this formula has more than {MAX_LEAVES} parts",
            datum,
            help="declare a function for a part of the formula, or divide the "
            "work between RAPs",
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
        head = datum.items[0] if datum.items else None
        if type(head) is Symbol:
            name = head.name
            read = ctx.formulas.get(name)
            if read is not None:
                made: nodes.Formula | None = read(ctx, datum)
                return made
            if name not in _NO_PROPOSITIONS:
                place = Span(ctx.file, datum.start, datum.end)
                return nodes.Proposition(name, terms(ctx, datum.items[1:]), span=place)
    elif type(datum) is Symbol and datum.name in ALONE:
        alone: nodes.Formula = ctx.readers[ALONE[datum.name]](ctx, datum)
        return alone
    _no_formula(ctx, datum)
    return None


def truth(ctx: Context, datum: Datum) -> nodes.Truth:
    """Read `t`, `true`, `nil` or `false`."""
    assert type(datum) is Symbol
    return nodes.Truth(TRUTHS[datum.name], span=ctx.span(datum))


_NO_PROPOSITIONS = frozenset((*CALLS, *ALONE))
"""The first words of lists that are not formulas; formulas have readers."""


def _no_formula(ctx: Context, datum: Datum) -> None:
    """Report a datum that is not a formula."""
    name = head_of(datum)
    fix = None
    if name in CALLS:
        message = f"`{name}` computes a value and is not a test"
        help = "compare the value with another value, as in `(< (value ?count) 3)`"
    elif name in ALONE and isinstance(datum, List) and len(datum.items) == 1:
        message = f"`{name}` must not have parentheses"
        help, fix = "", ctx.replace(datum, name or "")
    elif name in ALONE:
        message, help = f"`{name}` cannot be the name of a proposition", ""
    elif isinstance(datum, Symbol):
        message = f"expected a formula, not the symbol `{datum.name}`"
        help = f"write a proposition with parentheses: `({datum.name})`"
    else:
        message = f"expected a formula, not {kind_of(datum)}"
        if isinstance(datum, List):
            message = "expected a formula, not this list"
        help = "a formula begins with the name of a proposition or a connective"
    ctx.report("malformed-formula", message, datum, help=help, fix=fix)


def _parts(ctx: Context, datum: Datum) -> tuple[nodes.Formula, ...]:
    assert type(datum) is List
    return tuple(filter(None, [_formula(ctx, part) for part in datum.items[1:]]))


def joined(kind: type[nodes.And | nodes.Or]) -> Read:
    """Return the reader of `and` or `or`.

    An `and` leaves out its invalid parts; an `or` with an invalid part is left out.
    """

    def read(ctx: Context, datum: List) -> nodes.Formula | None:
        parts = _parts(ctx, datum)
        if kind is nodes.Or and len(parts) < len(datum.items) - 1:
            return None
        return kind(parts, span=ctx.span(datum))

    return read


def negation(ctx: Context, datum: Datum) -> nodes.Formula | None:
    """Read `(not formula)`; several formulas are negated together."""
    assert type(datum) is List
    if len(datum.items) == 1:
        ctx.report("malformed-formula", "`not` requires a formula", datum)
        return None
    parts = _parts(ctx, datum)
    if len(parts) < len(datum.items) - 1:
        return None
    if len(parts) > 1:
        ctx.report_fixable(
            "not-of-many",
            f"`not` takes one formula, not {len(parts)}",
            datum,
            help="write `(not (and a b))` to deny the conjunction, `(and (not "
            "a) (not b))` to deny each formula",
            fix=ctx.wrap(datum.items[1], datum.items[-1], "(and ", sure=False),
        )
        parts = (nodes.And(parts, span=ctx.span(datum)),)
    return nodes.Not(parts[0], span=ctx.span(datum))


def dated(ctx: Context, datum: List) -> List | None:
    """Return a `believe` with an age; report a missing age and return None."""
    if len(datum.items) != 2 or not isinstance(datum.items[1], List):
        return datum
    ctx.report(
        "believe-without-time",
        "`believe` requires an age",
        datum,
        help="write an age in time units, as in `(believe p 30)`, or a "
        "variable that is bound to the age",
        fix=ctx.insert(datum.items[1].end, " ?age", sure=False),
    )
    return None


def in_sight(ctx: Context, datum: List) -> List | None:
    """Return a `know-sensor-name` with a valid value; report an invalid value."""
    said = constant(datum.items[2]) if len(datum.items) == 3 else None
    if said is None or said in ("true", "false"):
        return datum
    message = "expected `true` or `false` as the value of `know-sensor-name`"
    ctx.report("malformed-formula", message, datum.items[2])
    return None


def lone_formula(ctx: Context, datum: Datum) -> nodes.Formula | None:
    """Read the formula of a clause with a single formula."""
    assert type(datum) is List
    if len(datum.items) == 2:
        return formula(ctx, datum.items[1])
    name, operands = head_of(datum), datum.items[1:]
    if not operands:
        ctx.report("malformed-clause", f"`{name}` requires a formula", datum)
        return None
    first, *others = operands
    stray = next((d for d in others if head_of(d) in _CLAUSES), None)
    ctx.report(
        "malformed-clause",
        f"`{name}` takes one formula, not {len(operands)}",
        others[0],
        help=f"a `)` may be missing before `({head_of(stray)}`"
        if stray
        else "join several formulas with `and`",
        fix=None if stray else ctx.wrap(first, operands[-1], "(and ", sure=False),
    )
    return formula(ctx, first)


_CLAUSES = frozenset((*RAP_CLAUSES, *METHOD_CLAUSES))
