"""Options in a row, `:word value...`, as they stand behind what they speak of."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from rapc.language.heads import rules_by_head
from rapc.parser.context import Context, kind_of
from rapc.parser.syntax import Datum, Keyword, List


def read_options(
    ctx: Context, data: Sequence[Datum], owner: str, group: str
) -> Mapping[str, list[Any]]:
    """Return what was read of each option of a group by its word; none stands twice."""
    rules = rules_by_head(group)
    known = {word: ctx.readers.option(rule) for word, rule in rules.items()}
    found = options(ctx, data, owner, {w: one.values for w, one in known.items()})
    return {word: [known[word].read(ctx, one)] for word, one in found.items()}


def options(
    ctx: Context, data: Sequence[Datum], owner: str, known: Mapping[str, int]
) -> Mapping[str, List]:
    """Options by their words, each as a list of its word and its values.

    `known` gives the number of values of each; no keyword is one. Reports what is no
    option, and words that stand twice.
    """
    others, found = split(ctx, data, owner, known)
    for one in others:
        message = f"{kind_of(one)} stands where an option of {owner} is wanted"
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
    """Whatever is no option, and the options by their words.

    Those in `many` may stand more than once. `rule` is broken by an option that lacks
    its values; `keywords` says whether one that is no option may be a value.
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
            ctx.report(rule, f"`{word}` lacks its value", here)
        elif word in found and word not in many:
            ctx.report("duplicate-clause", f"there is a second `{word}`", here)
        else:
            end = values[-1].end if values else here.end
            meant = Keyword(word, here.start, here.end)
            found.setdefault(word, []).append(List((meant, *values), here.start, end))
    return others, found
