"""Validate a saved memory before it is restored: its parts must agree.

Facts are those that the declarations allow, and each table of items, sets and mentions
says the same of an item as the others.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rapc.base.values import Atom, Fact, format_list
from rapc.language.atoms import is_atom
from rapc.library.signatures import Signatures
from rapc.runtime.memory.build import Assembled
from rapc.runtime.memory.checking import full_form
from rapc.runtime.memory.exclusions import items_of
from rapc.runtime.memory.mentions import PREFIX
from rapc.runtime.memory.saving import ItemState, MemoryState, SetState


def validate_memory(
    parts: Assembled, state: MemoryState, noted: Mapping[Fact, int]
) -> None:
    """Validate a saved memory.

    Args:
        parts: the memory that is to be restored.
        state: the saved memory.
        noted: how many notations of methods under way each fact is.

    Raises:
        ValueError: for a memory that no run has left.
    """
    notations = dict(state.notations)
    stored = _facts(parts, state, notations)
    _need(state.place is None or is_atom(state.place), "an unknown place")
    _need(len(notations) == len(state.notations), "a notation twice")
    _need(notations.keys() <= stored, "a notation that is no fact")
    counted = {fact: count for fact, count in noted.items() if fact in notations}
    _need(notations == counted, "notations that no method notes")
    _names(state)
    _mentions(parts, state, stored)
    _sets(parts, state)
    _values(state, stored, parts.memory.signatures)


_NONE: Mapping[Fact, int] = {}


def _need(holds: object, wrong: str) -> None:
    if not holds:
        raise ValueError(wrong)


def _once(values: Iterable[object]) -> bool:
    listed = list(values)
    return len(set(listed)) == len(listed)


# --- facts --------------------------------------------------------------------------


def _facts(
    parts: Assembled, state: MemoryState, notations: Mapping[Fact, int]
) -> set[Fact]:
    """Return all facts, each of which the declarations allow."""
    stored: set[Fact] = set()
    count = 0
    _need(_once(name for name, _ in state.facts), "a table twice")
    for name, facts in state.facts:
        relation = parts.memory.signatures.relations.get(str(name))
        for fact, _ in facts:
            _check_fact(parts, fact, notations)
        _need(all(f[0] == name for f, _ in facts), f"the table of `{name}`")
        stored.update(fact for fact, _ in facts)
        count += len(facts)
        if relation is not None and relation.is_property:
            _need(_once(fact[:-1] for fact, _ in facts), f"two values of `{name}`")
    _need(len(stored) == count, "a fact twice")
    return stored


def _check_fact(
    parts: Assembled, fact: Fact, notations: Mapping[Fact, int] = _NONE
) -> None:
    """See that a fact is one that may be asserted. Raises ValueError, as FactError."""
    if full_form(fact, parts.memory.signatures.relations) != fact:
        raise ValueError(f"{format_list(fact)} is incomplete")
    if fact not in notations:
        parts.access.check_kinds(fact)


def _mentions(parts: Assembled, state: MemoryState, stored: set[Fact]) -> None:
    expected: dict[str, set[Fact]] = {}
    for fact in stored if parts.memory.mentions is not None else ():
        for part in fact[1:]:
            if type(part) is str and part.startswith(PREFIX):
                expected.setdefault(part, set()).add(fact)
    found = {name: set(facts) for name, facts in state.mentions}
    _need(found == expected, "facts that mention an item")
    _need(all(_once(facts) for _, facts in state.mentions), "a fact twice")
    exclusions = parts.memory.exclusions
    _need(exclusions is not None or not state.past, "assertions that exclude nothing")
    for item, past in state.past:
        for fact, _ in past:
            _check_fact(parts, fact)
            excluded = () if exclusions is None else exclusions.excluded(fact)
            _need(item in items_of(excluded), f"`{item}` is not excluded")


# --- items --------------------------------------------------------------------------


def _names(state: MemoryState) -> None:
    """Names and sensor names are clear, and each alias leads to a name."""
    known = {item.name: item for item in state.items}
    _need(len(known) == len(state.items), "an item twice")
    _need(all(known), "an item without a name")
    _need(all(item.number and not item.name for item in state.empty), "an item")
    numbers = [item.number for item in (*state.items, *state.empty) if item.number]
    _need(_once(numbers), "two items have one number")
    _need(all(0 < n <= state.number for n in numbers), "an unknown number of an item")
    _need(known.keys().isdisjoint(state.aliases), "an alias of another name")
    _need(known.keys().isdisjoint(state.gone), "an item that is gone")
    _check_aliases(state.aliases)
    reached = [name for name, item in known.items() if item.accessible]
    _need(sorted(reached) == sorted(state.reach), "other items are in reach")
    sensors = dict(state.sensors)
    _need(len(sensors) == len(state.sensors), "a sensor name twice")
    for name in reached:
        sensor = known[name].sensor
        _need(sensor and sensors.get(sensor) == name, f"the sensor name of `{name}`")


def _check_aliases(aliases: Mapping[str, str]) -> None:
    """No alias leads back to itself."""
    ends: set[str] = set()
    for name in aliases:
        passed: dict[str, None] = {}
        while name in aliases and name not in ends:
            _need(name not in passed, f"`{name}` is an alias of itself")
            passed[name] = None
            name = aliases[name]  # noqa: PLW2901  # follows the chain
        ends.update(passed)


def _values(state: MemoryState, stored: set[Fact], signatures: Signatures) -> None:
    """A description has the values that the facts about its item say."""
    described = {item.name: item for item in state.items if item.number}
    expected: dict[str, dict[Fact, Atom]] = {name: {} for name in described}
    for fact in stored if described else ():
        item = described.get(str(fact[1])) if len(fact) > 2 else None
        if item is None or fact[0] == "location":
            continue
        relation = signatures.relations[str(fact[0])]
        if relation.is_property and not (fact[0] == "class" and fact[2] == item.kind):
            expected[item.name][fact[0], *fact[2:-1]] = fact[-1]
    for name, item in described.items():
        found = dict(item.values)
        _need(len(found) == len(item.values), f"two values of `{name}`")
        _need(found == expected[name], f"the description of `{name}`")
    _need(not any(item.values for item in state.empty), "an empty description")


# --- sets ---------------------------------------------------------------------------


def _sets(parts: Assembled, state: MemoryState) -> None:
    """Each description stands in the views of one set, or its place is unknown."""
    described = {i.number: i for i in (*state.items, *state.empty) if i.number}
    _need(_once((home.kind, home.place) for home in state.sets), "a set twice")
    serials = [serial for home in state.sets for serial, _ in home.layers]
    _need(_once(serials), "a layer twice")
    _need(all(0 < n <= state.layers for n in serials), "an unknown layer")
    homes: dict[int, SetState] = {}
    for home in state.sets:
        _need(parts.recognizer.recognises(home.kind), f"a set of `{home.kind}`")
        _check_set(home, described)
        for number in {*home.local, *(n for _, row in home.layers for n in row)}:
            _need(number not in homes, f"item {number} is in two sets")
            homes[number] = home
    for number, item in described.items():
        _need((number in homes) != (number in state.lost), f"the place of {number}")
        _need(number not in homes or item.kind == homes[number].kind, "a class")
        inside = number in homes and number in homes[number].local
        _need(inside or number in state.lost or not item.accessible, "a local item")
    _need(_once(state.lost), "a lost item twice")
    _need(described.keys() >= {*state.lost}, "an unknown lost item")
    sets = range(len(state.sets))
    _need(all(at in sets for at in state.unsettled), "an unknown set")


def _check_set(home: SetState, described: Mapping[int, ItemState]) -> None:
    rows = [home.local, *(row for _, row in home.layers)]
    for row in rows:
        _need(_once(row), "an item twice in a view")
        _need(all(number in described for number in row), "an unknown item in a view")
    serials = [serial for serial, _ in home.layers]
    _need(serials == sorted(serials), "layers in another order")
    sizes = {len(row) for _, row in home.layers}
    _need(len(sizes) < 2, "layers of other sizes")
    _need(not sizes or len(home.local) <= max(sizes), "more local items than expected")
    _need(all(described[n].accessible for n in home.local), "a local item out of reach")
