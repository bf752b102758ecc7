"""Special readers of declarations: results, effects, comparators, queries."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Literal, cast

from rapc.base.values import Atom
from rapc.ir import nodes
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.forms import explained, name_of, parameters, symbol
from rapc.parser.special.formulas import formula
from rapc.parser.syntax import Datum, List, Numeral, Symbol
from rapc.parser.terms import constant, proposition


def results(ctx: Context, datum: Datum) -> tuple[str, ...] | None:
    """Read the results of a primitive, which include `okay`."""
    if not isinstance(datum, List):
        ctx.wrong("results", datum)
        return ()
    named = [symbol(ctx, one, "a name") for one in datum.items]
    found = tuple([name for name in named if name is not None])
    if "okay" in found:
        return found
    ctx.report_fixable(
        "malformed-form",
        "missing `okay` among the results",
        datum,
        fix=ctx.replace(datum, f"({' '.join(('okay', *found))})"),
    )
    return ("okay", *found)


def excludes(ctx: Context, option: List) -> nodes.Exclusion | None:
    """Read `:excludes value (pattern)` (docs/explanation/memory.md)."""
    _, first, second = option.items
    value = constant(first)
    if value is None:
        ctx.report("malformed-form", "expected a value after `:excludes`", first)
        return None
    excluded = proposition(ctx, second)
    if excluded is None:
        return None
    return nodes.Exclusion(value, excluded, span=ctx.span(option))


def kind_values(ctx: Context, datum: Datum) -> tuple[Atom, ...] | None:
    """Read the values of a closed kind."""
    if not isinstance(datum, List):
        ctx.wrong("kind_values", datum)
        return None
    values: list[Atom] = []
    for one in datum.items:
        value = constant(one)
        if value is None:
            message = f"expected a value of the kind, not {kind_of(one)}"
            ctx.report("malformed-form", message, one)
        else:
            values.append(value)
    return tuple(values)


# --- effects --------------------------------------------------------------------------


def effects(
    ctx: Context, data: Iterable[Datum], wrappers: Sequence[str] = ("not", "may")
) -> tuple[nodes.DeclaredEffect, ...]:
    """Read declared effects: facts, erased facts (`not`), possible facts (`may`)."""
    return tuple([one for datum in data for one in _effect(ctx, datum, wrappers)])


def _effect(
    ctx: Context, datum: Datum, wrappers: Sequence[str]
) -> Iterator[nodes.DeclaredEffect]:
    word = head_of(datum)
    inner: Sequence[Datum] = (datum,)
    if word in wrappers and isinstance(datum, List):
        inner = datum.items[1:]
    if len(inner) != 1:
        message = (
            f"`{word}` takes one effect; write a separate `{word}` for each effect"
        )
        ctx.report("malformed-clause", message, datum)
    for one in inner:
        if word == "may" and head_of(one) == "not" and isinstance(one, List):
            _no_contrary(ctx, one)
            continue
        fact = proposition(ctx, one)
        if fact is not None:
            negated, possible = word == "not", word in wrappers and word == "may"
            yield nodes.DeclaredEffect(fact, negated, possible, span=ctx.span(datum))


def _no_contrary(ctx: Context, datum: List) -> None:
    """Report `not` in a `may`: a possible effect may assert or erase a fact."""
    inner = datum.items[1:]
    written = ctx.text(inner[0]) if len(inner) == 1 else "(fact)"
    ctx.report(
        "malformed-proposition",
        "expected a proposition after `not`",
        datum,
        help=f"write `(may {written})`: the fact may be asserted or erased",
    )


def datum_effects(
    ctx: Context, option: List
) -> tuple[nodes.DeclaredEffect, ...] | None:
    """Read `:on (effect...)`: the declared effects of a sensor datum."""
    given = option.items[1]
    if isinstance(given, List):
        return effects(ctx, given.items)
    ctx.wrong("datum_effects", given)
    return None


def result_effects(ctx: Context, option: List) -> nodes.ResultEffects | None:
    """Read `:on (result effect...)` of a primitive."""
    datum = option.items[1]
    first = datum.items[0] if isinstance(datum, List) and datum.items else None
    if not isinstance(first, Symbol) or not isinstance(datum, List):
        ctx.wrong("result_effects", first or datum)
        return None
    found = effects(ctx, datum.items[1:])
    return nodes.ResultEffects(first.name, found, span=ctx.span(datum))


# --- comparators and queries ----------------------------------------------------------


def comparator(ctx: Context, form: List) -> nodes.DeclareComparator | None:
    """Read `(declare-class-comparator class [place] comparator-name | row...)`.

    A row is `(veto property)`, `(ignore property)` or `(score property weight)`.
    """
    name = name_of(ctx, form, colon=False)
    if name is None:
        return None
    _, operands = explained(ctx, form, form.items[2:])
    rows = [d for d in operands if isinstance(d, List)]
    words = [d for d in operands if not isinstance(d, List)]
    if not operands or len(words) > (1 if rows else 2):
        ctx.wrong("declare_class_comparator", form)
        return None
    names = [name for name in (symbol(ctx, d, "a name") for d in words) if name]
    called = names.pop() if names and not rows else None
    made = tuple([row for row in (_row(ctx, d) for d in rows) if row])
    place = names[0] if names else None
    return nodes.DeclareComparator(name, place, called, made, span=ctx.span(form))


def _row(ctx: Context, form: List) -> nodes.ComparatorRow | None:
    treatment, operands = head_of(form), form.items[1:]
    if treatment not in ("veto", "ignore", "score") or not operands:
        ctx.wrong("row", form)
        return None
    name = symbol(ctx, operands[0], "a property")
    weight = operands[1] if len(operands) > 1 else None
    scores = treatment == "score"
    if len(operands) != 1 + scores or (scores and not isinstance(weight, Numeral)):
        wanted = "a property and a weight" if scores else "one property"
        ctx.report("malformed-form", f"expected {wanted} after `{treatment}`", form)
        return None
    if name is None:
        return None
    kind = cast(Literal["veto", "ignore", "score"], treatment)
    value = weight.value if isinstance(weight, Numeral) else 0
    return nodes.ComparatorRow(name, kind, value, span=ctx.span(form))


def query(ctx: Context, form: List) -> nodes.DefineQuery | None:
    """Read `(define-query (name arg...) formula ["doc"])`."""
    head = form.items[1] if len(form.items) > 1 else None
    name = head.items[0] if isinstance(head, List) and head.items else None
    if not isinstance(head, List) or not isinstance(name, Symbol):
        ctx.wrong("define_query", name or head or form)
        return None
    doc, asked = explained(ctx, form, form.items[2:])
    if len(asked) != 1:
        message = f"query `{name.name}` requires exactly one formula"
        ctx.report("malformed-form", message, (*asked[1:], form)[0])
    made = formula(ctx, asked[0]) if asked else None
    args = parameters(ctx, head.items[1:], {})
    if made is None:
        return None
    return nodes.DefineQuery(
        name.name, args, made, doc, ctx.span(name), span=ctx.span(form)
    )
