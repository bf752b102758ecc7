"""What a world offers: primitives, sensor data, skills, events (semantics 1, S 2)."""

from __future__ import annotations

from rapc.ir import nodes
from rapc.parser.context import Context
from rapc.parser.special.parts import Parts, parts, required_arguments, symbols
from rapc.parser.syntax import Datum, List, Symbol


def primitive(ctx: Context, form: List) -> nodes.DeclarePrimitive | None:
    """`(declare-primitive name (arg...) (result...) [:atomic false] ["doc"])`."""
    found = parts(ctx, form, 2, {":atomic": 1})
    if found is None:
        return None
    args = required_arguments(ctx, found)
    atomic = True
    for option in found.options:
        atomic = _truth(ctx, option.operands[0])
    return nodes.DeclarePrimitive(
        found.name, args, _results(ctx, found), atomic, found.doc, ctx.span(form)
    )


def _results(ctx: Context, found: Parts) -> tuple[str, ...]:
    if not found.operands:
        return ("okay",)
    if len(found.operands) < 2:
        ctx.report(
            "malformed-form",
            f"the results of `{found.name}` are missing",
            found.place,
            help="list `okay` and what else the world may answer: `(okay blocked)`",
        )
        return ("okay",)
    place = found.operands[1]
    results = symbols(ctx, place, "results")
    if "okay" in results or not isinstance(place, List):
        return results
    ctx.slip(
        "malformed-form",
        "`okay` is missing among the results",
        place,
        fix=ctx.replace(place, f"({' '.join(('okay', *results))})"),
    )
    return ("okay", *results)


def _truth(ctx: Context, datum: Datum) -> bool:
    if isinstance(datum, Symbol) and datum.name in ("true", "false"):
        return datum.name == "true"
    ctx.report("malformed-form", "`true` or `false` is wanted here", datum)
    return True


def datum(ctx: Context, form: List) -> nodes.DeclareDatum | None:
    """`(declare-sensor-datum name (arg...) ["doc"])`."""
    found = parts(ctx, form, 1)
    if found is None:
        return None
    args = required_arguments(ctx, found)
    return nodes.DeclareDatum(found.name, args, found.doc, ctx.span(form))


def skill(ctx: Context, form: List) -> nodes.DeclareSkill | None:
    """`(declare-skill :name (arg...) ["doc"])`."""
    found = parts(ctx, form, 1, colon=True)
    if found is None:
        return None
    args = required_arguments(ctx, found)
    return nodes.DeclareSkill(found.name, args, found.doc, ctx.span(form))


def event(ctx: Context, form: List) -> nodes.DeclareEvent | None:
    """`(declare-event :name (arg...) ["doc"])`."""
    found = parts(ctx, form, 1, colon=True)
    if found is None:
        return None
    args = required_arguments(ctx, found)
    return nodes.DeclareEvent(found.name, args, found.doc, ctx.span(form))
