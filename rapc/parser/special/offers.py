"""What a world offers: primitives, sensor data, skills, events [L 1] [S 2]."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from rapc.ir import nodes
from rapc.parser.context import Context, kind_of
from rapc.parser.special.effects import effects, result_effects
from rapc.parser.special.parts import (
    Option,
    Parts,
    parts,
    required_arguments,
    symbols,
)
from rapc.parser.syntax import Datum, Keyword, List, Symbol
from rapc.parser.terms import things

_OPTIONS = {":atomic": 1, ":uses": 1, ":tells": 1, ":on": 1}


def primitive(ctx: Context, form: List) -> nodes.DeclarePrimitive | None:
    """`(declare-primitive name (arg...) (result...) option... ["doc"])`.

    The options are `:atomic false`, `:uses (thing...)`, `:tells (datum...)` and, for
    each result, `:on (result effect...)`.
    """
    found = parts(ctx, form, 2, _OPTIONS)
    if found is None:
        return None
    args, results = required_arguments(ctx, found), _results(ctx, found)
    one = _single(ctx, found)
    on = [result_effects(ctx, o.operands[0]) for o in found.options if _is_on(o)]
    return nodes.DeclarePrimitive(
        name=found.name,
        args=args,
        results=results,
        atomic=_truth(ctx, one[":atomic"]) if ":atomic" in one else True,
        uses=_uses(ctx, one),
        tells=symbols(ctx, one[":tells"], "data") if ":tells" in one else (),
        on=tuple([effects for effects in on if effects]),
        doc=found.doc,
        span=ctx.span(form),
    )


def _is_on(option: Option) -> bool:
    return option.word.name == ":on"


def _single(
    ctx: Context, found: Parts, many: Collection[str] = (":on",)
) -> Mapping[str, Datum]:
    """The values of options by name; reports those that stand twice and may not."""
    kept: dict[str, Datum] = {}
    for option in found.options:
        name = option.word.name
        if name in kept and name not in many:
            message = f"there is a second `{name}`"
            ctx.report("duplicate-clause", message, option.word)
        else:
            kept[name] = option.operands[0]
    return kept


def _uses(ctx: Context, given: Mapping[str, Datum]) -> tuple[nodes.Thing, ...]:
    datum = given.get(":uses")
    if datum is None:
        return ()
    if isinstance(datum, List):
        return things(ctx, datum.items)
    message = f"a list of things is wanted here, not {kind_of(datum)}"
    fix = ctx.wrap(datum, datum, "(", sure=False)
    ctx.report("malformed-form", message, datum, fix=fix)
    return ()


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
    ctx.report_fixable(
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
    """`(declare-sensor-datum name (arg...) [:on (effect...)] ["doc"])`."""
    found = parts(ctx, form, 1, {":on": 1})
    if found is None:
        return None
    args = required_arguments(ctx, found)
    given = _single(ctx, found, ()).get(":on")
    on = None
    if isinstance(given, List):
        on = effects(ctx, given.items)
    elif given is not None:
        message = f"a list of effects is wanted here, not {kind_of(given)}"
        ctx.report("malformed-form", message, given)
    return nodes.DeclareDatum(found.name, args, on, found.doc, ctx.span(form))


def skill(ctx: Context, form: List) -> nodes.DeclareSkill | None:
    """`(declare-skill :name (arg...) option... ["doc"])`.

    The options are `:events (:event...)` and `:uses (thing...)`.
    """
    found = parts(ctx, form, 1, {":events": 1, ":uses": 1}, colon=True)
    if found is None:
        return None
    args = required_arguments(ctx, found)
    given = _single(ctx, found)
    told = _events(ctx, given[":events"]) if ":events" in given else None
    return nodes.DeclareSkill(
        found.name, args, told, _uses(ctx, given), found.doc, ctx.span(form)
    )


def _events(ctx: Context, datum: Datum) -> tuple[str, ...]:
    """The names of events, each with its colon."""
    if not isinstance(datum, List):
        message = f"a list of events is wanted here, not {kind_of(datum)}"
        ctx.report("malformed-form", message, datum)
        return ()
    found: list[str] = []
    for one in datum.items:
        if isinstance(one, Keyword):
            found.append(one.name)
        else:
            message = f"the name of an event begins with a colon, unlike {kind_of(one)}"
            ctx.report("malformed-form", message, one)
    return tuple(found)


def event(ctx: Context, form: List) -> nodes.DeclareEvent | None:
    """`(declare-event :name (arg...) ["doc"])`."""
    found = parts(ctx, form, 1, colon=True)
    if found is None:
        return None
    args = required_arguments(ctx, found)
    return nodes.DeclareEvent(found.name, args, found.doc, ctx.span(form))
