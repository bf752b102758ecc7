"""The offer of a world as declarations of a library."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
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
    """Return the declarations of an offer.

    The arguments have the names of the offer, else `?a`, `?b`, ...

    Args:
        offer: the offer of a world.
        skills: the author's declarations of skills and events, if any: their arguments,
            with kinds, their signals and things.
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
    """Return a library that consists of the declarations of an offer."""
    unit = SourceUnit(SourceFile("<offer>", ""), declarations(offer))
    return link([unit])[0]


def _declared(offer: Offer) -> Iterator[nodes.TopForm]:
    for name, (count, results) in offer.primitives.items():
        yield nodes.DeclarePrimitive(
            name=name,
            args=_arguments(offer, name, count),
            results=tuple(results),
            atomic=name not in offer.not_atomic,
            uses=(),
            tells=(),
            on=(),
            doc=_ONLY_LOOKS if name in offer.sensors else "",
        )
    for name, count in offer.data.items():
        yield nodes.DeclareDatum(name, _arguments(offer, name, count), None, "")
    for name, count in offer.skills.items():
        yield nodes.DeclareSkill(name, _arguments(offer, name, count), None, (), "")
    for name, count in offer.events.items():
        yield nodes.DeclareEvent(name, _arguments(offer, name, count), "")


def _of_catalogue(
    skills: Catalogue,
) -> Iterator[nodes.DeclareSkill | nodes.DeclareEvent]:
    for name in skills.entries:
        of = skills.describe(name)
        yield nodes.DeclareSkill(
            f":{name}",
            _parameters(of.parameters),
            tuple(f":{event}" for event in of.events),
            tuple(nodes.Thing(thing, ()) for thing in of.uses),
            of.doc and f"{of.doc}.",
        )
    for name, event in skills.events.items():
        doc = first_line(event.__doc__) if "__doc__" in vars(event) else ""
        carries = _parameters(event.carries)
        yield nodes.DeclareEvent(f":{name}", carries, doc and f"{doc}.")


def _parameters(parameters: Iterable[Parameter]) -> tuple[nodes.Argument, ...]:
    """Return the arguments of a skill or an event by name, numbers as such."""
    return tuple(
        nodes.Argument(
            nodes.Var(f"?{one.name}"), "number" if one.kind == "number" else None
        )
        for one in parameters
    )


def _letter(at: int) -> str:
    """Return a name for the argument `at`, different for each argument."""
    letters = len(ascii_lowercase)
    return f"{ascii_lowercase[at % letters]}{at // letters or ''}"


def _arguments(offer: Offer, name: str, count: int) -> tuple[nodes.Argument, ...]:
    """Return a number of arguments, with generated names if the offer has none."""
    called = offer.arguments.get(name, ())
    if len(called) != count:
        called = tuple([_letter(at) for at in range(count)])
    return tuple([nodes.Argument(nodes.Var(f"?{one}"), None) for one in called])
