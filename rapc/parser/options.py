"""Options in a row, `:word value`, as they stand behind what they speak of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rapc.language.heads import rules_by_head
from rapc.parser.context import Context, kind_of
from rapc.parser.syntax import Datum, Keyword, List


def read_options(
    ctx: Context, data: Sequence[Datum], owner: str, group: str
) -> Mapping[str, list[Any]]:
    """Return what was read of each option of a group by its word."""
    rules = rules_by_head(group)
    known = {word: ctx.readers.option(rule) for word, rule in rules.items()}
    counts = {word: option.values for word, option in known.items()}
    found = options(ctx, data, owner, counts)
    return {word: [known[word].read(ctx, one)] for word, one in found.items()}


def options(
    ctx: Context, data: Sequence[Datum], owner: str, known: Mapping[str, int]
) -> Mapping[str, List]:
    """Options by their words, each as a list of its word and, if it has one, its value.

    `known` gives the number of values of each, at most one.
    """
    found: dict[str, List] = {}
    at = 0
    while at < len(data):
        word = data[at]
        at += 1
        if not isinstance(word, Keyword):
            message = f"{kind_of(word)} stands where an option of {owner} is wanted"
            ctx.report("malformed-clause", message, word)
            continue
        wanted = known.get(word.name, 1)
        values = [d for d in data[at : at + wanted] if not isinstance(d, Keyword)]
        at += len(values)
        if word.name not in known:
            ctx.unknown("unknown-clause", f"option of {owner}", word, known)
        elif len(values) < wanted:
            ctx.report("malformed-clause", f"`{word.name}` lacks its value", word)
        elif word.name in found:
            ctx.report("duplicate-clause", f"there is a second `{word.name}`", word)
        else:
            end = values[-1].end if values else word.end
            found[word.name] = List((word, *values), word.start, end)
    return found
