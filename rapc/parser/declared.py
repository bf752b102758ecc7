"""Declarations, as their rules have them: a name, operands, `:options` and a text.

Behind its name the parts of a declaration come in any order. Its operands and options
are read by the readers of their rules; of an operand that is missing something is
assumed, which is reported.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from typing import Any

import msgspec

from rapc.ir import nodes, productions
from rapc.language.heads import heads, often
from rapc.language.shapes import is_word, leaves
from rapc.parser.context import Context, Read, head_of, kind_of
from rapc.parser.fields import Slots, filled, slots
from rapc.parser.options import split
from rapc.parser.syntax import Datum, Keyword, List, String, Symbol


class DeclaredOperand(msgspec.Struct, frozen=True):
    """An operand of a declaration behind its name."""

    field: str
    #: The rule or terminal that it is read as.
    leaf: str
    #: Whether it may be left out.
    optional: bool
    #: Whether one comes behind it that may not.
    aside: bool


class Declaration(msgspec.Struct, frozen=True):
    """What a rule says of a declaration and its node."""

    kind: type[nodes.Node]
    #: Whether its name begins with a colon.
    colon: bool
    #: Whether its node keeps the text that explains it.
    explained: bool
    operands: tuple[DeclaredOperand, ...]
    #: The rules of its options by their words.
    options: Mapping[str, str]
    #: The options that may stand more than once.
    many: frozenset[str]
    slots: Slots
    #: What the fields of its options hold where nothing is said.
    unsaid: Mapping[str, Any]


@cache
def _told(rule: str, kind: type[nodes.Node]) -> Declaration:
    known = productions.parts(rule, kind)
    names = productions.fields(kind, known)[1:]
    wanted = [
        part.shape for part in known if not part.field and not is_word(part.shape)
    ]
    rows = [
        (name, shape)
        for name, shape in zip(names, wanted[1:], strict=False)
        if name != "doc"
    ]
    operands = [
        DeclaredOperand(
            field=name,
            leaf=next(leaves(shape)),
            optional=shape[0] == "?",
            aside=any(later[0] != "?" for _, later in rows[at:]),
        )
        for at, (name, shape) in enumerate(rows, start=1)
    ]
    filled_by = slots(rule, kind)
    return Declaration(
        kind=kind,
        colon=wanted[0] in ("SKILL", "SIGNAL"),
        explained="doc" in names,
        operands=tuple(operands),
        options={heads(str(p.shape))[0]: str(p.shape) for p in known if p.field},
        many=often(rule),
        slots=filled_by,
        unsaid=dict(zip(filled_by.names, filled_by.unsaid, strict=True)),
    )


def declaration(rule: str, kind: Any) -> Read:
    """Return what reads the declarations of a rule to nodes of a kind."""

    def read(ctx: Context, form: List) -> Any:
        told = _told(rule, kind)
        name = name_of(ctx, form, colon=told.colon)
        if name is None:
            return None
        data: Sequence[Datum] = form.items[2:]
        given: dict[str, Any] = dict(told.unsaid)
        if Keyword in map(type, data):
            data, options = _options(ctx, form, data, told)
            given.update(options)
        doc, operands = explained(ctx, form, data)
        _add_operands(ctx, form, name, operands, told, given)
        if told.explained:
            given["doc"] = doc
        return kind(name=name, span=ctx.span(form), **given)

    return read


def _options(
    ctx: Context, form: List, data: Sequence[Datum], told: Declaration
) -> tuple[list[Datum], dict[str, Any]]:
    """The data that are no options, and the fields of options by their names."""
    known = {w: ctx.readers.option(one) for w, one in told.options.items()}
    counts = {word: option.values for word, option in known.items()}
    owner = f"`{head_of(form)}`"
    others, options = split(ctx, data, owner, counts, told.many, "malformed-form", True)
    found = {w: [known[w].read(ctx, o) for o in row] for w, row in options.items()}
    fields = filled(told.slots, found)
    return others, dict(zip(told.slots.names, fields, strict=True))


def name_of(ctx: Context, form: List, *, colon: bool) -> str | None:
    """The name in a declaration; `colon` says that it begins with one."""
    place = form.items[1] if len(form.items) > 1 else form
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


def explained(
    ctx: Context, form: List, data: Iterable[Datum]
) -> tuple[str, list[Datum]]:
    """The text that explains a declaration, and the data in it that are no texts."""
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
    """Report what a declaration has no place for."""
    for extra in data:
        message = f"{kind_of(extra)} too many for `{head_of(form)}`"
        ctx.report("malformed-form", message, extra)


def _add_operands(
    ctx: Context,
    form: List,
    name: str,
    data: list[Datum],
    told: Declaration,
    given: dict[str, Any],
) -> None:
    """Put the operands into `given` by their fields; reports the first missing."""
    last, missed = form.items[1], False
    for one in told.operands:
        value = None
        wanted = bool(data)
        if one.optional and one.aside and data:
            wanted = isinstance(data[0], List)
        if wanted:
            last = data.pop(0)
            value = ctx.readers[one.leaf](ctx, last)
        elif not one.optional and not missed:
            missed = True
            _missing(ctx, form.items[1], name, one.leaf, last)
        if value is None and not one.optional:
            value = MISSING[one.leaf].assumed
        given[one.field] = value
    if data:
        _surplus(ctx, form, data)


class MissingOperand(msgspec.Struct, frozen=True):
    """A row: what is reported of an operand that is missing, and assumed of it."""

    #: The message; `{name}` stands for the name of what is declared.
    message: str
    help: str
    #: What is offered to be written there.
    written: str
    assumed: Any


MISSING: Mapping[str, MissingOperand] = {
    "arguments": MissingOperand(
        "the arguments of `{name}` are missing", "without any, write `()`", "()", ()
    ),
    "results": MissingOperand(
        "the results of `{name}` are missing",
        "list `okay` and what else the world may answer: `(okay blocked)`",
        "",
        ("okay",),
    ),
    "DEFAULT": MissingOperand(
        "the property `{name}` has no default",
        "it is `unknown`, `true`, `false` or the name of a function",
        "unknown",
        "unknown",
    ),
}
"""The operands of declarations that may not be left out, by rule or terminal."""


def _missing(ctx: Context, place: Datum, name: str, leaf: str, last: Datum) -> None:
    said = MISSING[leaf]
    fix = None
    if said.written:
        fix = ctx.insert(last.end, f" {said.written}", sure=False)
    message = said.message.format(name=name)
    ctx.report("malformed-form", message, place, help=said.help, fix=fix)
