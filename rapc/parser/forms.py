"""Readers of parts in any order: clauses, options and declarations.

A clause is a list that begins with its name. An option is a word with values in a
sequence, `:word value...`. The rule of a clause or option has a reader. The value
that the reader returns fills the field with the name of the clause or option. After the
name of a declaration, its operands, `:options` and text come in any order. A missing
operand is reported and has a default.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import chain
from typing import Any, cast

import msgspec

from rapc.base.source import Span
from rapc.base.values import Atom
from rapc.ir import nodes, schema
from rapc.ir.schema import declared, parts, unsaid
from rapc.language.grammar import GRAMMAR, RULES
from rapc.language.heads import METHOD_CLAUSES, RAP_CLAUSES, heads, often, rules_by_head
from rapc.language.shapes import Shape, is_word, leaves
from rapc.parser.context import Context, Read, head_of, kind_of
from rapc.parser.syntax import (
    Datum,
    Keyword,
    List,
    Numeral,
    String,
    Symbol,
    Variable,
)
from rapc.parser.terms import constant


def arguments(ctx: Context, datum: Datum) -> tuple[nodes.Argument, ...]:
    """Read `(?variable ...)`; each variable may have its kind: `(?size number)`."""
    if not isinstance(datum, List):
        ctx.wrong("arguments", datum)
        return ()
    return parameters(ctx, datum.items, {})


def valued(ctx: Context, datum: Datum) -> tuple[nodes.Argument, ...]:
    """Read the arguments of a property, whose last argument is its value."""
    made = arguments(ctx, datum)
    if isinstance(datum, List) and not datum.items:
        ctx.wrong("valued", datum)
    return made


def default(ctx: Context, datum: Datum) -> Atom | None:
    """Read the default of a property: a symbol, a number or a function's name."""
    if isinstance(datum, Symbol | Numeral):
        return constant(datum)
    ctx.wrong("default", datum)
    return None


def parameters(
    ctx: Context, data: Sequence[Datum], seen: dict[str, Datum]
) -> tuple[nodes.Argument, ...]:
    """Read variables, with or without kinds; report variables that are in `seen`."""
    if not data:
        return ()
    return tuple(filter(None, [_argument(ctx, one, seen) for one in data]))


def _argument(
    ctx: Context, datum: Datum, seen: dict[str, Datum]
) -> nodes.Argument | None:
    if type(datum) is not List or not datum.items:
        variable = parameter(ctx, datum, seen)
        return nodes.Argument(variable, None, span=variable.span) if variable else None
    kind = symbol(ctx, datum.items[1], "a kind") if len(datum.items) == 2 else None
    if len(datum.items) != 2:
        ctx.wrong("argument", datum)
    variable = parameter(ctx, datum.items[0], seen)
    return nodes.Argument(variable, kind, span=ctx.span(datum)) if variable else None


def parameter(ctx: Context, datum: Datum, seen: dict[str, Datum]) -> nodes.Var | None:
    """Read a variable with a name; report the variable if it is in `seen`."""
    if type(datum) is not Variable or datum.name == "?":
        named = _named(ctx, datum)
        if named is None:
            return None
        datum = named
    first = seen.setdefault(datum.name, datum)
    if first is not datum:
        ctx.report(
            "repeated-variable",
            f"duplicate variable `{datum.name}`",
            datum,
            labels=[(first, "the first is here")],
        )
    return nodes.Var(datum.name, span=Span(ctx.file, datum.start, datum.end))


def _named(ctx: Context, datum: Datum) -> Variable | None:
    """Report a datum that is not a variable; return the variable for a symbol."""
    if isinstance(datum, Symbol):
        ctx.report_fixable(
            "malformed-form",
            f"expected a variable, not `{datum.name}`",
            datum,
            fix=ctx.replace(datum, f"?{datum.name}"),
        )
        return Variable(f"?{datum.name}", datum.start, datum.end)
    what = "a bare `?`" if isinstance(datum, Variable) else kind_of(datum)
    message = f"expected a variable with a name, not {what}"
    ctx.report("malformed-form", message, datum)
    return None


def symbol(ctx: Context, datum: Datum, what: str) -> str | None:
    """Read the name of a symbol; report any other datum."""
    if isinstance(datum, Symbol):
        return datum.name
    ctx.report("malformed-form", f"expected {what}, not {kind_of(datum)}", datum)
    return None


class Slots(msgspec.Struct, frozen=True):
    """The fields of a node that clauses and options fill."""

    #: The fields in the order of the node, with their default values.
    unsaid: Mapping[str, Any]
    #: The field of each word, and whether the field holds a tuple.
    fields: Mapping[str, tuple[str, bool]]
    #: The rule of each word.
    rules: Mapping[str, str]


@cache
def slots(rule: str, kind: type[nodes.Node]) -> Slots:
    """Return the fields that the clauses and options of a rule fill in its node."""
    known = [part for part in parts(rule, kind) if part.field]
    empty = {p.field: unsaid(str(p.shape), kind, p.field) for p in known}
    fields = {
        heads(str(p.shape))[0]: (p.field, declared(kind, p.field).startswith("tuple["))
        for p in known
    }
    rules = {heads(str(p.shape))[0]: str(p.shape) for p in known}
    ordered = {f: empty[f] for f in kind.__struct_fields__ if f in empty}
    return Slots(ordered, fields, rules)


def filled(into: Slots, read: Mapping[str, Sequence[Any]]) -> dict[str, Any]:
    """Return the values of the fields, from the values of clauses or options by word.

    A value that could not be read is None. If a field with a single value has several,
    the first is used; tuples are joined.
    """
    fields = dict(into.unsaid)
    for word, values in read.items():
        field, many = into.fields[word]
        if many:
            rows = [_row(value, field) for value in values if value is not None]
            if rows:
                fields[field] = (*(fields[field] or ()), *chain.from_iterable(rows))
        elif values[0] is not None:
            fields[field] = values[0]
    return fields


def _row(value: Any, field: str) -> Iterable[Any]:
    """Return a value as a sequence: a tuple, a node's field of that name, or itself."""
    if isinstance(value, nodes.Node):
        held: Iterable[Any] = getattr(value, field, (value,))
        return held
    return value if type(value) is tuple else (value,)


def read_options(
    ctx: Context, data: Sequence[Datum], owner: str, group: str
) -> Mapping[str, list[Any]]:
    """Return the values of the options of a group by word; report duplicates."""
    rules = rules_by_head(group)
    known = {word: ctx.readers.option(rule) for word, rule in rules.items()}
    found = options(ctx, data, owner, {w: one.values for w, one in known.items()})
    return {word: [known[word].read(ctx, one)] for word, one in found.items()}


def options(
    ctx: Context, data: Sequence[Datum], owner: str, known: Mapping[str, int]
) -> Mapping[str, List]:
    """Return the options by word, each as a list of its word and its values.

    `known` has the number of values of each option; a keyword is not a value. Other
    data and duplicate options are reported.
    """
    others, found = split(ctx, data, owner, known)
    for one in others:
        message = f"expected an option of {owner}, not {kind_of(one)}"
        ctx.report("malformed-clause", message, one)
    return {word: rows[0] for word, rows in found.items()}


def split(
    ctx: Context,
    data: Sequence[Datum],
    owner: str,
    known: Mapping[str, int],
    many: Collection[str] = (),
    rule: str = "malformed-clause",
    keywords: bool = False,
) -> tuple[list[Datum], dict[str, list[List]]]:
    """Return the data that are not options, and the options by word.

    Options in `many` may be repeated. An option with missing values violates `rule`.
    With `keywords`, a keyword that is not an option may be a value.
    """
    others: list[Datum] = []
    found: dict[str, list[List]] = {}
    at = 0
    while at < len(data):
        here = data[at]
        at += 1
        if not isinstance(here, Keyword):
            others.append(here)
            continue
        word: str | None = here.name
        if word not in known:
            word = ctx.unknown("unknown-clause", f"option of {owner}", here, known)
        values = [
            one
            for one in data[at : at + known.get(word or "", 1)]
            if not isinstance(one, Keyword) or (keywords and one.name not in known)
        ]
        at += len(values)
        if word is None:
            continue
        if len(values) < known[word]:
            ctx.report(rule, f"`{word}` requires a value", here)
        elif word in found and word not in many:
            ctx.report("duplicate-clause", f"duplicate option `{word}`", here)
        else:
            end = values[-1].end if values else here.end
            meant = Keyword(word, here.start, here.end)
            found.setdefault(word, []).append(List((meant, *values), here.start, end))
    return others, found


def clauses(
    ctx: Context, data: Sequence[Datum], owner: str, known: Sequence[str]
) -> Iterator[tuple[str, List]]:
    """Yield the clauses among some data with their corrected names.

    Data that are not clauses, and clauses of other forms, are reported.
    """
    for datum in data:
        name = head_of(datum)
        if name is not None and type(datum) is List and name in known:
            yield name, datum
        elif name is None or type(datum) is not List:
            ctx.report(
                "malformed-clause",
                f"expected a clause of `{owner}`, not {kind_of(datum)}",
                datum,
                help="a clause is a list that begins with its name",
            )
        elif name in RAP_CLAUSES or name in METHOD_CLAUSES:
            other = "a method" if name in METHOD_CLAUSES else "the RAP itself"
            ctx.report(
                "misplaced-clause",
                f"`{name}` is a clause of {other}, not of `{owner}`",
                datum.items[0],
                help="the parentheses before the clause may not balance",
            )
        else:
            word = cast(Symbol, datum.items[0])
            meant = ctx.unknown("unknown-clause", f"clause of `{owner}`", word, known)
            if meant:
                yield meant, datum


def single(
    ctx: Context,
    found: Iterable[tuple[str, List]],
    many: Collection[str] = (),
) -> dict[str, list[List]]:
    """Return the clauses by name; report duplicates, except for names in `many`.

    Of duplicate clauses the first is used.
    """
    kept: dict[str, list[List]] = {}
    for name, datum in found:
        have = kept.get(name)
        if have is None:
            kept[name] = [datum]
        elif name not in many:
            ctx.report(
                "duplicate-clause",
                f"duplicate clause `{name}`",
                datum.items[0],
                labels=[(have[0].items[0], "the first is here")],
            )
        else:
            have.append(datum)
    return kept


def read_clauses(
    ctx: Context, kept: Mapping[str, Sequence[List]], group: str, into: Slots
) -> dict[str, Any]:
    """Return the fields that clauses fill, read by the readers of a group."""
    readers = ctx.readers.group(group)
    read = {
        name: [readers[name](ctx, row) for row in rows] for name, rows in kept.items()
    }
    return filled(into, read)


_Operand = tuple[str, Shape, bool]
"""The field of an operand, its shape, and whether a required operand follows."""


@cache
def _operands(rule: str, kind: type[nodes.Node]) -> tuple[_Operand, ...]:
    """Return the operands of a declaration after its name, without its text."""
    known = schema.parts(rule, kind)
    names = schema.fields(kind, known)[1:]
    wanted = [p.shape for p in known if not p.field and not is_word(p.shape)][1:]
    rows = [row for row in zip(names, wanted, strict=False) if row[0] != "doc"]
    return tuple(
        (name, shape, any(later[0] != "?" for _, later in rows[at:]))
        for at, (name, shape) in enumerate(rows, start=1)
    )


def declaration(rule: str, kind: Any) -> Read:
    """Return the reader of the declarations of a rule to nodes of a kind."""
    colon = RULES[rule][2] in ("SKILL", "SIGNAL")

    def read(ctx: Context, form: List) -> Any:
        name = name_of(ctx, form, colon=colon)
        if name is None:
            return None
        data: Sequence[Datum] = form.items[2:]
        into = slots(rule, kind)
        given = dict(into.unsaid)
        if Keyword in map(type, data):
            known = {w: ctx.readers.option(one) for w, one in into.rules.items()}
            counts = {word: option.values for word, option in known.items()}
            owner, many = f"`{head_of(form)}`", often(rule)
            data, options = split(
                ctx, data, owner, counts, many, "malformed-form", keywords=True
            )
            given = filled(
                into, {w: [known[w].read(ctx, o) for o in options[w]] for w in options}
            )
        doc, operands = explained(ctx, form, data)
        _add_operands(ctx, form, name, operands, _operands(rule, kind), given)
        if "doc" in kind.__struct_fields__:
            given["doc"] = doc
        return kind(name=name, span=ctx.span(form), **given)

    return read


def name_of(ctx: Context, form: List, *, colon: bool) -> str | None:
    """Read the name of a declaration; with `colon`, the name begins with a colon."""
    place = form.items[1] if len(form.items) > 1 else form
    if isinstance(place, Keyword) and colon:
        return place.name
    if isinstance(place, Symbol):
        if not colon:
            return place.name
        ctx.report_fixable(
            "malformed-form",
            f"expected a name with a colon, not `{place.name}`",
            place,
            fix=ctx.replace(place, f":{place.name}"),
        )
        return f":{place.name}"
    wanted = "a name with a colon" if colon else "a symbol for its name"
    ctx.report("malformed-form", f"expected {wanted} after `{head_of(form)}`", place)
    return None


def explained(
    ctx: Context, form: List, data: Iterable[Datum]
) -> tuple[str, list[Datum]]:
    """Return the text that explains a declaration, and the data without texts."""
    operands: list[Datum] = []
    docs: list[String] = []
    for one in data:
        if isinstance(one, String):
            docs.append(one)
        else:
            operands.append(one)
    if len(docs) > 1:
        _surplus(ctx, form, docs[1:])
    return docs[0].value if docs else "", operands


def _surplus(ctx: Context, form: List, data: Iterable[Datum]) -> None:
    """Report the surplus data of a declaration."""
    for extra in data:
        message = f"expected the end of `{head_of(form)}`, not {kind_of(extra)}"
        ctx.report("malformed-form", message, extra)


def _add_operands(
    ctx: Context,
    form: List,
    name: str,
    data: list[Datum],
    wanted: Sequence[_Operand],
    given: dict[str, Any],
) -> None:
    """Put the operands into `given` by field; report the first missing operand."""
    last, missed = form.items[1], False
    for field, shape, aside in wanted:
        leaf, optional = next(leaves(shape)), shape[0] == "?"
        value = None
        if data and not (optional and aside and not isinstance(data[0], List)):
            last = data.pop(0)
            value = ctx.readers[leaf](ctx, last)
        elif not optional and not missed:
            missed = True
            _missing(ctx, form.items[1], name, leaf, last)
        if value is None and not optional:
            value = _ASSUMED[leaf]
        given[field] = value
    if data:
        _surplus(ctx, form, data)


_ASSUMED: Mapping[str, Any] = {
    "arguments": (),
    "results": ("okay",),
    "default": "unknown",
}
"""The default values of missing required operands."""


def _missing(ctx: Context, place: Datum, name: str, leaf: str, last: Datum) -> None:
    said, fix = GRAMMAR[leaf], None
    if leaf != "results":
        written = "()" if leaf == "arguments" else _ASSUMED[leaf]
        fix = ctx.insert(last.end, f" {written}", sure=False)
    message = said.missing.format(name=name)
    ctx.report("malformed-form", message, place, help=said.help, fix=fix)
