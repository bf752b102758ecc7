"""What is brought about: effects of RAPs, of the results of primitives, of data."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence

from rapc.ir import nodes
from rapc.parser.context import Context, head_of, kind_of
from rapc.parser.syntax import Datum, List, Symbol
from rapc.parser.terms import proposition

_WORDS = ("not", "may")
"""What a fact may be wrapped in: taken away, or possible."""


def effects(
    ctx: Context, data: Iterable[Datum], wrappers: Collection[str] = _WORDS
) -> tuple[nodes.DeclaredEffect, ...]:
    """Facts, each by itself or within one of the words in `wrappers`."""
    return tuple([one for datum in data for one in _effect(ctx, datum, wrappers)])


def _effect(
    ctx: Context, datum: Datum, wrappers: Collection[str]
) -> Iterator[nodes.DeclaredEffect]:
    word = head_of(datum)
    inner: Sequence[Datum] = (datum,)
    if word in wrappers and isinstance(datum, List):
        inner = datum.items[1:]
    if len(inner) != 1:
        message = f"`{word}` goes with one effect; write one for each"
        ctx.report("malformed-clause", message, datum)
    for one in inner:
        fact = proposition(ctx, one)
        if fact is not None:
            negated, possible = word == "not", word in wrappers and word == "may"
            yield nodes.DeclaredEffect(fact, negated, possible, ctx.span(datum))


def result_effects(ctx: Context, option: List) -> nodes.ResultEffects | None:
    """`:on (result effect...)` of a primitive."""
    datum = option.items[1]
    first = datum.items[0] if isinstance(datum, List) and datum.items else None
    if not isinstance(first, Symbol) or not isinstance(datum, List):
        ctx.report(
            "malformed-form",
            f"a result and its effects are wanted here, not {kind_of(datum)}"
            if not isinstance(datum, List)
            else "a list of effects begins with the result they come with",
            first or datum,
            help="write `:on (okay (fact ...) (not (fact ...)) (may (fact ...)))`",
        )
        return None
    found = effects(ctx, datum.items[1:])
    return nodes.ResultEffects(first.name, found, ctx.span(datum))
