"""Checks of single classes of skills, before any class is wired.

A catalogue runs these checks first. So an author who forgets a comma, a name or a
method gets a message with the class and the missing part.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import msgspec

from rapc.worlds.skills.declarations import (
    Channel,
    Compound,
    Event,
    Input,
    NetworkNode,
    Parameter,
    Skill,
)

T = TypeVar("T")

_NAME = re.compile(r"[a-z][a-z0-9-]*")

_TUPLES: Mapping[str, tuple[tuple[type, ...], str]] = {
    "inputs": ((Channel, Input), "channels"),
    "outputs": ((Channel,), "channels"),
    "parameters": ((Parameter,), "parameters"),
    "carries": ((Parameter,), "parameters"),
    "uses": ((str,), "names"),
    "events": ((Event,), "classes of events"),
}
"""Types in the tuples of a class by attribute, with the word for messages."""


class CatalogueError(ValueError):
    """Declarations of skills that cannot work together."""


def check_list(
    what: str, given: Iterable[T], types: type[Any], word: str
) -> tuple[T, ...]:
    """Return a list given to a catalogue as a tuple, after a check of its types.

    Args:
        what: the name of the parameter.
        given: the list.
        types: the allowed class of its entries.
        word: the name of the entries in messages.

    Raises:
        CatalogueError: if the value is not a list, or has entries of another type.
    """
    owner = f"`{what}` of a catalogue"
    if not isinstance(given, Iterable) or isinstance(given, str | type):
        raise CatalogueError(
            f"{owner} is a list of {word}, not {given!a:.60}; one of a single thing "
            "has brackets: [x]"
        )
    listed = tuple(given)
    for one in listed:
        if not isinstance(one, types):
            raise CatalogueError(f"{owner} has {word}, not {one!a:.60}")
    return listed


def check_entry(entry: object) -> None:
    """Validate an entry of a catalogue as a skill.

    Raises:
        CatalogueError: with the class and its fault.
    """
    if isinstance(entry, Compound):
        _check_name(f"the compound `{entry.name}`", entry.name)
        _check_tuple(f"the compound `{entry.name}`", "parameters", entry.parameters)
        if not isinstance(entry.parts, tuple) or not entry.parts:
            raise CatalogueError(f"`parts` of the compound `{entry.name}` is no tuple")
        for part in entry.parts:
            _check_skill(part)
    else:
        _check_skill(entry)


def _check_skill(skill: object) -> None:
    if not isinstance(skill, type) or not issubclass(skill, Skill):
        raise CatalogueError(
            f"a catalogue has classes of skills, and compounds, not {skill!a:.60}"
        )
    _check_node(skill, Skill, "step")
    for what in ("outputs", "parameters", "uses", "events"):
        _check_tuple(f"the class {skill.__name__}", what, getattr(skill, what))
    for event in skill.events:
        _check_node(event, Event, "test")
        _check_tuple(f"the class {event.__name__}", "carries", event.carries)


def _check_node(node: type[NetworkNode], base: type[NetworkNode], method: str) -> None:
    owner = f"the class {node.__name__}"
    _check_name(owner, getattr(node, "name", None))
    _check_tuple(owner, "inputs", node.inputs)
    if getattr(node, method) is getattr(base, method):
        raise CatalogueError(f"{owner} does not define `{method}`")
    state = node.State
    if not isinstance(state, type) or not issubclass(state, msgspec.Struct):
        raise CatalogueError(f"`State` of {owner} is no msgspec struct")


def _check_name(owner: str, name: object) -> None:
    if name is None:
        raise CatalogueError(f"{owner} has no `name`")
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise CatalogueError(
            f"the name of {owner} is a symbol of small letters, not {name!a:.60}"
        )


def _check_tuple(owner: str, what: str, given: object) -> None:
    types, word = _TUPLES[what]
    if not isinstance(given, tuple):
        told = "is no tuple; one of a single thing has a comma: (x,)"
        raise CatalogueError(f"`{what}` of {owner} {told}")
    for one in given:
        fits = isinstance(one, types)
        if what == "events":
            fits = isinstance(one, type) and issubclass(one, types)
        if not fits:
            raise CatalogueError(f"`{what}` of {owner} has {word}, not {one!a:.60}")
