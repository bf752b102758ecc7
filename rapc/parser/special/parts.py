"""The parts of a declaration: its name, operands, doc string and `:options`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import msgspec

from rapc.base.source import Span
from rapc.ir import nodes
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.syntax import Datum, Keyword, List, String, Symbol, Variable


class ClauseParts(msgspec.Struct, frozen=True):
    """A declaration taken apart; names of skills and events keep their colon."""

    form: List
    name: str
    place: Datum
    operands: tuple[Datum, ...]
    doc: str
    #: Lists that begin with a word, the values of which stand behind it.
    options: tuple[List, ...]


def parts(
    ctx: Context, form: List, options: Mapping[str, int], *, colon: bool
) -> ClauseParts | None:
    """A declaration taken apart, or None if there is no name.

    `options` gives the number of values for each option; `colon` says that the
    name begins with one.
    """
    place = form.items[1] if len(form.items) > 1 else form
    name = _name(ctx, form, place, colon)
    if name is None:
        return None
    operands, docs, found = _sort(ctx, form, options)
    surplus(ctx, form, docs[1:])
    doc = docs[0].value if docs else ""
    return ClauseParts(form, name, place, tuple(operands), doc, tuple(found))


def surplus(ctx: Context, form: List, data: Iterable[Datum]) -> None:
    """Report what a declaration has no place for."""
    for extra in data:
        message = f"{kind_of(extra)} too many for `{head_of(form)}`"
        ctx.report("malformed-form", message, extra)


def _name(ctx: Context, form: List, place: Datum, colon: bool) -> str | None:
    if isinstance(place, Keyword) and colon:
        return place.name
    if isinstance(place, Symbol):
        if not colon:
            return place.name
        ctx.report_fixable(
            "malformed-form",
            f"the name `{place.name}` of a skill or event begins with a colon",
            place,
            fix=ctx.replace(place, f":{place.name}"),
        )
        return f":{place.name}"
    wanted = "a name with a colon" if colon else "a symbol for its name"
    ctx.report("malformed-form", f"`{head_of(form)}` wants {wanted} first", place)
    return None


def _sort(
    ctx: Context, form: List, known: Mapping[str, int]
) -> tuple[list[Datum], list[String], list[List]]:
    """Operands, doc strings and options behind the name."""
    operands: list[Datum] = []
    docs: list[String] = []
    found: list[List] = []
    data = form.items[2:]
    at = 0
    while at < len(data):
        here = data[at]
        at += 1
        if isinstance(here, String):
            docs.append(here)
        elif isinstance(here, Keyword):
            word: str | None = here.name
            if word not in known:
                what = f"option of `{head_of(form)}`"
                word = ctx.unknown("unknown-clause", what, here, known)
            taken = data[at : at + known.get(word or "", 1)]
            at += len(taken)
            if word and len(taken) < known[word]:
                ctx.report("malformed-form", f"`{word}` lacks its value", here)
            elif word:
                end = taken[-1].end if taken else here.end
                meant = Keyword(word, here.start, here.end)
                found.append(List((meant, *taken), here.start, end))
        else:
            operands.append(here)
    return operands, docs, found


def arguments(ctx: Context, datum: Datum) -> tuple[nodes.Argument, ...]:
    """`(?variable ...)`, each of them with its kind if wanted: `(?size number)`."""
    if not isinstance(datum, List):
        message = f"a list of variables is wanted here, not {kind_of(datum)}"
        ctx.report("malformed-form", message, datum)
        return ()
    return parameters(ctx, datum.items, {})


def valued(ctx: Context, datum: Datum) -> tuple[nodes.Argument, ...]:
    """The arguments of a property, the last of which is its value."""
    made = arguments(ctx, datum)
    if isinstance(datum, List) and not datum.items:
        ctx.report(
            "malformed-form",
            "the arguments of a property end with its value",
            datum,
            help="a property without arguments has only that: `(?value)`",
        )
    return made


def parameters(
    ctx: Context, data: Sequence[Datum], seen: dict[str, Datum]
) -> tuple[nodes.Argument, ...]:
    """Variables in a row, with kinds or without, none of them among those `seen`."""
    if not data:
        return ()
    return tuple(filter(None, [_argument(ctx, one, seen) for one in data]))


def _argument(
    ctx: Context, datum: Datum, seen: dict[str, Datum]
) -> nodes.Argument | None:
    if type(datum) is not List or not datum.items:
        variable = parameter(ctx, datum, seen)
        return nodes.Argument(variable, None, variable.span) if variable else None
    kind = symbol(ctx, datum.items[1], "a kind") if len(datum.items) == 2 else None
    if len(datum.items) != 2:
        message = "an argument in parentheses is a variable and its kind"
        ctx.report("malformed-form", message, datum)
    variable = parameter(ctx, datum.items[0], seen)
    return nodes.Argument(variable, kind, ctx.span(datum)) if variable else None


def parameter(ctx: Context, datum: Datum, seen: dict[str, Datum]) -> nodes.Var | None:
    """A variable with a name that is not yet among those `seen`."""
    if type(datum) is not Variable or datum.name == "?":
        named = _named(ctx, datum)
        if named is None:
            return None
        datum = named
    first = seen.setdefault(datum.name, datum)
    if first is not datum:
        ctx.report(
            "repeated-variable",
            f"`{datum.name}` stands here twice",
            datum,
            labels=[(first, "the first is here")],
        )
    return nodes.Var(datum.name, Span(ctx.file, datum.start, datum.end))


def _named(ctx: Context, datum: Datum) -> Variable | None:
    """Return the variable that a symbol was meant for; report whatever it is."""
    if isinstance(datum, Symbol):
        ctx.report_fixable(
            "malformed-form",
            f"the variable `?{datum.name}` lacks its `?`",
            datum,
            fix=ctx.replace(datum, f"?{datum.name}"),
        )
        return Variable(f"?{datum.name}", datum.start, datum.end)
    what = "a bare `?`" if isinstance(datum, Variable) else kind_of(datum)
    message = f"a variable with a name is wanted here, not {what}"
    ctx.report("malformed-form", message, datum)
    return None


def symbol(ctx: Context, datum: Datum, what: str) -> str | None:
    """A symbol's name; anything else is reported."""
    if isinstance(datum, Symbol):
        return datum.name
    ctx.report("malformed-form", f"{what} is wanted here, not {kind_of(datum)}", datum)
    return None
