"""What memory holds: propositions, properties, functions, classes (T A.1, A.5).

What a world offers is declared in `rapc.parser.special.offers`.
"""

from __future__ import annotations

from typing import Literal, cast

from rapc.base.values import Atom
from rapc.ir import nodes
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.special.parts import Option, Parts, arguments, parts, symbol, symbols
from rapc.parser.syntax import Datum, List, Numeral, Symbol
from rapc.parser.terms import constant
from rapc.parser.terms import proposition as read_proposition


def proposition(ctx: Context, form: List) -> nodes.DeclareProposition | None:
    """`(declare-memory-proposition name [(arg...)] ["doc"])`."""
    found = parts(ctx, form, 1)
    if found is None:
        return None
    args = arguments(ctx, found.operands[0]) if found.operands else None
    return nodes.DeclareProposition(found.name, args, found.doc, ctx.span(form))


def property_(ctx: Context, form: List) -> nodes.DeclareProperty | None:
    """`(declare-memory-property name [(arg... value)] default [option] ["doc"])`.

    The option is `:excludes value (pattern)`, as often as needed.
    """
    found = parts(ctx, form, 2, {":excludes": 2})
    if found is None:
        return None
    args = None
    if found.operands and isinstance(found.operands[0], List):
        args = arguments(ctx, found.operands[0])
        if not found.operands[0].items:
            ctx.report(
                "malformed-form",
                "the arguments of a property end with its value",
                found.operands[0],
                help="a property without arguments has only that: `(?value)`",
            )
    return nodes.DeclareProperty(
        found.name,
        args,
        _default(ctx, found, args is not None),
        tuple([one for one in (_exclusion(ctx, o) for o in found.options) if one]),
        found.doc,
        ctx.span(form),
    )


def _default(ctx: Context, found: Parts, listed: bool) -> str:
    """The default of a property; `unknown` if it is not said."""
    operands = found.operands[1:] if listed else found.operands
    help = "it is `unknown`, `true`, `false` or the name of a function"
    if not operands:
        last = found.operands[-1] if found.operands else found.place
        ctx.report(
            "malformed-form",
            f"the property `{found.name}` has no default",
            found.place,
            help=help,
            fix=ctx.insert(last.end, " unknown", sure=False),
        )
        return "unknown"
    for extra in operands[1:]:
        ctx.report("malformed-form", "a property has one default", extra)
    if isinstance(operands[0], Symbol):
        return operands[0].name
    ctx.report("malformed-form", "this is no default", operands[0], help=help)
    return "unknown"


def _exclusion(ctx: Context, option: Option) -> nodes.Exclusion | None:
    """`:excludes value (pattern)` (docs/memory.md)."""
    first, second = option.operands
    value = constant(first)
    if value is None:
        ctx.report("malformed-form", "`:excludes` begins with a value", first)
        return None
    excluded = read_proposition(ctx, second)
    if excluded is None:
        return None
    span = ctx.span(option.word).to(ctx.span(second))
    return nodes.Exclusion(value, excluded, span)


def function(ctx: Context, form: List) -> nodes.DeclareFunction | None:
    """`(declare-memory-function name [(arg...)] [:reads (pred...)] ["doc"])`."""
    found = parts(ctx, form, 1, {":reads": 1})
    if found is None:
        return None
    args = arguments(ctx, found.operands[0]) if found.operands else None
    reads = None
    for option in found.options:
        reads = symbols(ctx, option.operands[0], "predicates")
    return nodes.DeclareFunction(found.name, args, reads, found.doc, ctx.span(form))


def kind(ctx: Context, form: List) -> nodes.DeclareKind | None:
    """`(declare-kind name [:is kind] [(value...)] ["doc"])`."""
    found = parts(ctx, form, 1, {":is": 1})
    if found is None:
        return None
    above = None
    for option in found.options:
        above = symbol(ctx, option.operands[0], "the name of a kind")
    values = None
    if found.operands:
        values = _values(ctx, found.operands[0])
    return nodes.DeclareKind(found.name, above, values, found.doc, ctx.span(form))


def _values(ctx: Context, datum: Datum) -> tuple[Atom, ...] | None:
    """The values that a closed kind lists."""
    if not isinstance(datum, List):
        message = f"a list of values is wanted here, not {kind_of(datum)}"
        ctx.report("malformed-form", message, datum)
        return None
    values: list[Atom] = []
    for one in datum.items:
        value = constant(one)
        if value is None:
            message = f"a kind lists values, not {kind_of(one)}"
            ctx.report("malformed-form", message, one)
        else:
            values.append(value)
    return tuple(values)


def indistinct_class(ctx: Context, form: List) -> nodes.DeclareIndistinctClass | None:
    """`(declare-indistinct-class name [comparator] ["doc"])`."""
    found = parts(ctx, form, 1)
    if found is None:
        return None
    comparator = None
    if found.operands:
        comparator = symbol(ctx, found.operands[0], "the name of a comparator")
    return nodes.DeclareIndistinctClass(found.name, comparator, ctx.span(form))


def comparator(ctx: Context, form: List) -> nodes.DeclareComparator | None:
    """`(declare-class-comparator class [place] comparator-name | row...)`.

    A row is `(veto property)`, `(ignore property)` or `(score property weight)`.
    """
    found = parts(ctx, form, len(form.items))
    if found is None:
        return None
    rows = [d for d in found.operands if isinstance(d, List)]
    words = [d for d in found.operands if not isinstance(d, List)]
    if not found.operands or len(words) > (1 if rows else 2):
        ctx.report(
            "malformed-form",
            "a comparator is a name or rows, behind a class and perhaps a place",
            form,
            help="rows are `(veto property)`, `(ignore property)` and "
            "`(score property weight)`",
        )
        return None
    names = [name for name in (symbol(ctx, d, "a name") for d in words) if name]
    called = names.pop() if names and not rows else None
    return nodes.DeclareComparator(
        found.name,
        names[0] if names else None,
        called,
        tuple([row for row in (_row(ctx, d) for d in rows) if row]),
        ctx.span(form),
    )


def _row(ctx: Context, form: List) -> nodes.ComparatorRow | None:
    treatment, operands = head_of(form), form.items[1:]
    if treatment not in ("veto", "ignore", "score") or not operands:
        ctx.report(
            "malformed-form",
            "a row of a comparator vetoes, ignores or scores a property",
            form,
            help="write `(veto p)`, `(ignore p)` or `(score p 20)`",
        )
        return None
    name = symbol(ctx, operands[0], "a property")
    weight = operands[1] if len(operands) > 1 else None
    scores = treatment == "score"
    if len(operands) != 1 + scores or (scores and not isinstance(weight, Numeral)):
        wanted = "a property and a weight" if scores else "one property"
        ctx.report("malformed-form", f"`{treatment}` takes {wanted}", form)
        return None
    if name is None:
        return None
    kind = cast(Literal["veto", "ignore", "score"], treatment)
    value = weight.value if isinstance(weight, Numeral) else 0
    return nodes.ComparatorRow(name, kind, value, ctx.span(form))
