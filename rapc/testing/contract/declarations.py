"""What a world offers, as the declarations that a library would make of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from string import ascii_lowercase

from rapc.base.source import SourceFile
from rapc.ir import nodes
from rapc.library.library import Library, link
from rapc.parser.unit import SourceUnit
from rapc.world import Offer

_ONLY_LOOKS = "Only looks, and changes nothing."


def declarations(offer: Offer) -> tuple[nodes.TopForm, ...]:
    """Return the declarations of all that is on offer; arguments are `?a`, `?b`, ..."""
    return tuple(_declared(offer))


def declaring(offer: Offer) -> Library:
    """Return a library of nothing but the declarations of what is on offer."""
    unit = SourceUnit(SourceFile("<offer>", ""), declarations(offer))
    return link([unit])[0]


def _declared(offer: Offer) -> Iterator[nodes.TopForm]:
    for name, (count, results) in offer.primitives.items():
        yield nodes.DeclarePrimitive(
            name=name,
            args=_arguments(count),
            results=tuple(results),
            atomic=name not in offer.not_atomic,
            uses=(),
            tells=(),
            on=(),
            doc=_ONLY_LOOKS if name in offer.sensors else "",
        )
    for name, count in offer.data.items():
        yield nodes.DeclareDatum(name, _arguments(count), None, "")
    for name, args in _of_each(offer.skills):
        yield nodes.DeclareSkill(name, args, None, (), "")
    for name, args in _of_each(offer.events):
        yield nodes.DeclareEvent(name, args, "")


def _of_each(
    counts: Mapping[str, int],
) -> Iterator[tuple[str, tuple[nodes.Argument, ...]]]:
    return ((name, _arguments(count)) for name, count in counts.items())


def _arguments(count: int) -> tuple[nodes.Argument, ...]:
    """Return so many arguments with names of their own."""
    letters = len(ascii_lowercase)
    names = [
        f"?{ascii_lowercase[at % letters]}{at // letters or ''}" for at in range(count)
    ]
    return tuple([nodes.Argument(nodes.Var(name), None) for name in names])
