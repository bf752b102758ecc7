"""Declarations, by their rules: their operands and options, and what is wrong in them.

Behind its name the parts of a declaration come in any order. Its operands and options
are read by the readers of their rules; some of those are here. That of a comparator
alone is no row of operands, and has a reader of its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, Literal, cast

import msgspec

from rapc.base.values import Atom
from rapc.ir import nodes, productions
from rapc.language.heads import heads
from rapc.language.shapes import is_word, leaves
from rapc.parser.context import Context, OptionReader, Read, head_of, kind_of
from rapc.parser.fields import Slots, filled, slots
from rapc.parser.special.effects import effects
from rapc.parser.special.parts import ClauseParts, parts, surplus, symbol
from rapc.parser.syntax import Datum, Keyword, List, Numeral, Symbol
from rapc.parser.terms import constant
from rapc.parser.terms import proposition as read_proposition


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


@cache
def _told(rule: str, kind: type[nodes.Node]) -> Declaration:
    """Return what the grammar says of the declarations of a rule."""
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
    options = {heads(str(p.shape))[0]: str(p.shape) for p in known if p.field}
    many = {word for word, one in options.items() if one in _REPEATED}
    return Declaration(
        kind=kind,
        colon=wanted[0] in ("SKILL", "SIGNAL"),
        explained="doc" in names,
        operands=tuple(operands),
        options=options,
        many=frozenset(many),
        slots=slots(rule, kind),
    )


_REPEATED = ("excludes", "result_effects")
"""Options that may stand more than once."""


def declaration(rule: str, kind: type[nodes.Node]) -> Read:
    """Return what reads the declarations of a rule to nodes of a kind."""

    def read(ctx: Context, form: List) -> nodes.Node | None:
        told = _told(rule, kind)
        known = {w: ctx.readers.option(one) for w, one in told.options.items()}
        counts = {word: option.values for word, option in known.items()}
        found = parts(ctx, form, counts, colon=told.colon)
        if found is None:
            return None
        given = _operands(ctx, found, told)
        given |= filled(told.slots, _options(ctx, found, told, known))
        if told.explained:
            given["doc"] = found.doc
        return kind(name=found.name, span=ctx.span(form), **given)

    return read


def _operands(ctx: Context, found: ClauseParts, told: Declaration) -> dict[str, Any]:
    """The operands by their fields; reports the first that is missing."""
    given: dict[str, Any] = {}
    data = list(found.operands)
    last, missed = found.place, False
    for one in told.operands:
        wanted = bool(data)
        if one.optional and one.aside and data:
            wanted = isinstance(data[0], List)
        if wanted:
            last = data.pop(0)
            given[one.field] = ctx.readers[one.leaf](ctx, last)
        elif one.optional:
            given[one.field] = None
        else:
            given[one.field] = _missing(ctx, found, one.leaf, last, silent=missed)
            missed = True
    surplus(ctx, found.form, data)
    return given


def _missing(
    ctx: Context, found: ClauseParts, leaf: str, last: Datum, *, silent: bool
) -> Any:
    """Return what is assumed of an operand that is missing, which is reported."""
    what, help, written, assumed = _MISSING[leaf]
    if not silent:
        message = what.format(found.name)
        fix = ctx.insert(last.end, f" {written}", sure=False) if written else None
        ctx.report("malformed-form", message, found.place, help=help, fix=fix)
    return assumed


_DEFAULTS = "it is `unknown`, `true`, `false` or the name of a function"
_RESULTS = "list `okay` and what else the world may answer: `(okay blocked)`"

_MISSING: Mapping[str, tuple[str, str, str, Any]] = {
    "arguments": (
        "the arguments of `{}` are missing",
        "without any, write `()`",
        "()",
        (),
    ),
    "results": ("the results of `{}` are missing", _RESULTS, "", ("okay",)),
    "DEFAULT": ("the property `{}` has no default", _DEFAULTS, "unknown", "unknown"),
}
"""What is said of an operand that is missing, the advice, the fix, what is assumed."""


def _options(
    ctx: Context,
    found: ClauseParts,
    told: Declaration,
    known: Mapping[str, OptionReader],
) -> dict[str, list[Any]]:
    """Return what was read of each option; report those that wrongly stand twice."""
    read: dict[str, list[Any]] = {}
    for one in found.options:
        word = cast(Keyword, one.items[0]).name
        if word in read and word not in told.many:
            message = f"there is a second `{word}`"
            ctx.report("duplicate-clause", message, one.items[0])
        else:
            read.setdefault(word, []).append(known[word].read(ctx, one))
    return read


# --- operands and options that need a hand ------------------------------------------


def default(ctx: Context, datum: Datum) -> str:
    """The default of a property; `unknown` for what is none."""
    if isinstance(datum, Symbol):
        return datum.name
    ctx.report("malformed-form", "this is no default", datum, help=_DEFAULTS)
    return "unknown"


def comparator_name(ctx: Context, datum: Datum) -> str | None:
    """The name of the comparator of a class."""
    return symbol(ctx, datum, "the name of a comparator")


def excludes(ctx: Context, option: List) -> nodes.Exclusion | None:
    """`:excludes value (pattern)` (docs/memory.md)."""
    _, first, second = option.items
    value = constant(first)
    if value is None:
        ctx.report("malformed-form", "`:excludes` begins with a value", first)
        return None
    excluded = read_proposition(ctx, second)
    if excluded is None:
        return None
    return nodes.Exclusion(value, excluded, ctx.span(option))


def kind_values(ctx: Context, datum: Datum) -> tuple[Atom, ...] | None:
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


def results(ctx: Context, datum: Datum) -> tuple[str, ...]:
    """The results of a primitive, `okay` among them."""
    if not isinstance(datum, List):
        message = f"a list of results is wanted here, not {kind_of(datum)}"
        ctx.report("malformed-form", message, datum)
        return ()
    named = [symbol(ctx, one, "a name") for one in datum.items]
    found = tuple([name for name in named if name is not None])
    if "okay" in found:
        return found
    ctx.report_fixable(
        "malformed-form",
        "`okay` is missing among the results",
        datum,
        fix=ctx.replace(datum, f"({' '.join(('okay', *found))})"),
    )
    return ("okay", *found)


def datum_effects(
    ctx: Context, option: List
) -> tuple[nodes.DeclaredEffect, ...] | None:
    """`:on (effect...)`: what a sensor datum does to memory."""
    given = option.items[1]
    if isinstance(given, List):
        return effects(ctx, given.items)
    message = f"a list of effects is wanted here, not {kind_of(given)}"
    ctx.report("malformed-form", message, given)
    return None


# --- comparators ----------------------------------------------------------------------


def comparator(ctx: Context, form: List) -> nodes.DeclareComparator | None:
    """`(declare-class-comparator class [place] comparator-name | row...)`.

    A row is `(veto property)`, `(ignore property)` or `(score property weight)`.
    """
    found = parts(ctx, form, {}, colon=False)
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
