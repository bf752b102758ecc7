"""What a world offers, as the declarations that a library would make of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from string import ascii_lowercase

from rapc.base.source import SourceFile
from rapc.ir import nodes
from rapc.library.library import Library, link
from rapc.parser.unit import SourceUnit
from rapc.world import Offer
from rapc.worlds.skills.catalogue import Catalogue
from rapc.worlds.skills.declarations import Parameter, first_line

_ONLY_LOOKS = "Only looks, and changes nothing."


def declarations(
    offer: Offer, skills: Catalogue | None = None
) -> tuple[nodes.TopForm, ...]:
    """Return the declarations of all that is on offer; arguments are `?a`, `?b`, ...

    Args:
        offer: what a world offers.
        skills: what its author has declared of skills and events, if anything: their
            arguments, with kinds, what they tell and use.
    """
    declared = tuple(_declared(offer))
    if skills is None:
        return declared
    known: dict[str, nodes.TopForm] = {
        form.name: form for form in _of_catalogue(skills)
    }
    return tuple(
        known.get(form.name, form)
        if isinstance(form, nodes.DeclareSkill | nodes.DeclareEvent)
        else form
        for form in declared
    )


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


def _of_catalogue(
    skills: Catalogue,
) -> Iterator[nodes.DeclareSkill | nodes.DeclareEvent]:
    for name in skills.entries:
        of = skills.describe(name)
        yield nodes.DeclareSkill(
            f":{name}",
            _parameters(of.parameters),
            tuple(f":{event}" for event in of.events) or None,
            tuple(nodes.Thing(thing, ()) for thing in of.uses),
            of.doc and f"{of.doc}.",
        )
    for name, event in skills.events.items():
        doc = first_line(event.__doc__) if "__doc__" in vars(event) else ""
        carries = _parameters(event.carries)
        yield nodes.DeclareEvent(f":{name}", carries, doc and f"{doc}.")


def _parameters(parameters: Iterable[Parameter]) -> tuple[nodes.Argument, ...]:
    """Return the arguments of a skill or an event by their names, numbers as such."""
    return tuple(
        nodes.Argument(
            nodes.Var(f"?{one.name}"), "number" if one.kind == "number" else None
        )
        for one in parameters
    )


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
