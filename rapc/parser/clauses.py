"""Clauses of a form: those among its data, once or often, read by their rules."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any, cast

from rapc.language.heads import METHOD_CLAUSES, RAP_CLAUSES
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.fields import Slots, put
from rapc.parser.syntax import Datum, List, Symbol


def clauses(
    ctx: Context, data: Sequence[Datum], owner: str, known: Sequence[str]
) -> Iterator[tuple[str, List]]:
    """The clauses among some data with the names they are meant to have.

    Reports what is no clause, or a clause of something else.
    """
    for datum in data:
        name = head_of(datum)
        if name is not None and type(datum) is List and name in known:
            yield name, datum
        elif name is None or type(datum) is not List:
            ctx.report(
                "malformed-clause",
                f"{kind_of(datum)} stands where a clause of `{owner}` is wanted",
                datum,
                help="a clause is a list that begins with its name",
            )
        elif name in RAP_CLAUSES or name in METHOD_CLAUSES:
            other = "a method" if name in METHOD_CLAUSES else "the RAP itself"
            ctx.report(
                "misplaced-clause",
                f"`{name}` is a clause of {other}, not of `{owner}`",
                datum.items[0],
                help="a parenthesis may be missing or too many before it",
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
    """Clauses by name; reports those that stand twice and may not.

    The first of two counts.
    """
    kept: dict[str, list[List]] = {}
    for name, datum in found:
        have = kept.get(name)
        if have is None:
            kept[name] = [datum]
        elif name not in many:
            ctx.report(
                "duplicate-clause",
                f"there is a second `{name}`",
                datum.items[0],
                labels=[(have[0].items[0], "the first is here")],
            )
        else:
            have.append(datum)
    return kept


def read_clauses(
    ctx: Context, kept: Mapping[str, Sequence[List]], group: str, into: Slots
) -> list[Any]:
    """Return the fields that clauses fill, read by the readers of a group."""
    fields = list(into.unsaid)
    if not kept:
        return fields
    readers = ctx.readers.group(group)
    outer = ctx.clause
    for name, rows in kept.items():
        read = readers[name]
        ctx.clause = name
        put(fields, into, name, [read(ctx, row) for row in rows])
    ctx.clause = outer
    return fields
