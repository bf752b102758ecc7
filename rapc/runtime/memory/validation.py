"""Validate a saved memory before it is restored: its parts must agree.

The declarations must allow all facts, and the tables of items, sets and mentions must
agree about each item.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rapc.base.values import Atom, Fact, format_list
from rapc.language.atoms import is_atom
from rapc.library.signatures import Signatures
from rapc.runtime.memory.exclusions import items_of
from rapc.runtime.memory.facts import PREFIX
from rapc.runtime.memory.gate import Gate
from rapc.runtime.memory.saving import ItemState, MemoryState, SetState


class WrongRecordError(Exception):
    """Saved data that no run can have written; the text gives the reason."""


def need(holds: object, wrong: str) -> None:
    """Raise a WrongRecordError with the text `wrong` unless `holds` is true."""
    if not holds:
        raise WrongRecordError(wrong)


def once(values: Iterable[object]) -> bool:
    """Return whether no value occurs twice."""
    listed = list(values)
    return len(set(listed)) == len(listed)


def validate_memory(gate: Gate, state: MemoryState, noted: Mapping[Fact, int]) -> None:
    """Validate a saved memory.

    Args:
        gate: the memory to be restored.
        state: the saved memory.
        noted: the number of notations by methods under way, for each fact.

    Raises:
        WrongRecordError: for a memory that no run can have written.
    """
    notations = dict(state.notations)
    stored = _facts(gate, state, notations)
    need(state.place is None or is_atom(state.place), "an unknown place")
    need(len(notations) == len(state.notations), "a notation twice")
    need(notations.keys() <= stored, "a notation that is no fact")
    counted = {fact: count for fact, count in noted.items() if fact in notations}
    need(notations == counted, "notations that no method notes")
    _names(state)
    _mentions(gate, state, stored)
    _sets(gate, state)
    _values(state, stored, gate.memory.signatures)


_NONE: Mapping[Fact, int] = {}


# --- facts --------------------------------------------------------------------------


def _facts(gate: Gate, state: MemoryState, notations: Mapping[Fact, int]) -> set[Fact]:
    """Return all facts, after validating each by the declarations."""
    stored: set[Fact] = set()
    count = 0
    need(once(name for name, _ in state.facts), "a table twice")
    for name, facts in state.facts:
        relation = gate.memory.signatures.relations.get(str(name))
        for fact, _ in facts:
            _check_fact(gate, fact, notations)
        need(all(f[0] == name for f, _ in facts), f"the table of `{name}`")
        stored.update(fact for fact, _ in facts)
        count += len(facts)
        if relation is not None and relation.is_property:
            need(once(fact[:-1] for fact, _ in facts), f"two values of `{name}`")
    need(len(stored) == count, "a fact twice")
    return stored


def _check_fact(gate: Gate, fact: Fact, notations: Mapping[Fact, int] = _NONE) -> None:
    """Validate a fact by the declarations. Raises ValueError, as FactError."""
    if gate.memory.full_form(fact) != fact:
        raise ValueError(f"{format_list(fact)} is incomplete")
    if fact not in notations:
        gate.check_kinds(fact)


def _mentions(gate: Gate, state: MemoryState, stored: set[Fact]) -> None:
    expected: dict[str, set[Fact]] = {}
    for fact in stored if gate.memory.mentions is not None else ():
        for part in fact[1:]:
            if type(part) is str and part.startswith(PREFIX):
                expected.setdefault(part, set()).add(fact)
    found = {name: set(facts) for name, facts in state.mentions}
    need(found == expected, "facts that mention an item")
    need(all(once(facts) for _, facts in state.mentions), "a fact twice")
    exclusions = gate.memory.exclusions
    need(exclusions is not None or not state.past, "assertions that exclude nothing")
    for item, past in state.past:
        for fact, _ in past:
            _check_fact(gate, fact)
            excluded = () if exclusions is None else exclusions.excluded(fact)
            need(item in items_of(excluded), f"`{item}` is not excluded")


# --- items --------------------------------------------------------------------------


def _names(state: MemoryState) -> None:
    """Check that names and sensor names are unique, and that aliases lead to names."""
    known = {item.name: item for item in state.items}
    need(len(known) == len(state.items), "an item twice")
    need(all(known), "an item without a name")
    need(all(item.number and not item.name for item in state.empty), "an item")
    numbers = [item.number for item in (*state.items, *state.empty) if item.number]
    need(once(numbers), "two items have one number")
    need(all(0 < n <= state.number for n in numbers), "an unknown number of an item")
    need(known.keys().isdisjoint(state.aliases), "an alias of another name")
    need(known.keys().isdisjoint(state.gone), "an item that is gone")
    _check_aliases(state.aliases)
    reached = [name for name, item in known.items() if item.accessible]
    need(sorted(reached) == sorted(state.reach), "other items are in reach")
    sensors = dict(state.sensors)
    need(len(sensors) == len(state.sensors), "a sensor name twice")
    for name in reached:
        sensor = known[name].sensor
        need(sensor and sensors.get(sensor) == name, f"the sensor name of `{name}`")


def _check_aliases(aliases: Mapping[str, str]) -> None:
    """Check that no alias leads back to itself."""
    ends: set[str] = set()
    for name in aliases:
        passed: dict[str, None] = {}
        while name in aliases and name not in ends:
            need(name not in passed, f"`{name}` is an alias of itself")
            passed[name] = None
            name = aliases[name]  # noqa: PLW2901  # follows the chain
        ends.update(passed)


def _values(state: MemoryState, stored: set[Fact], signatures: Signatures) -> None:
    """Check that a description has the values of the facts about its item."""
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
        need(len(found) == len(item.values), f"two values of `{name}`")
        need(found == expected[name], f"the description of `{name}`")
    need(not any(item.values for item in state.empty), "an empty description")


# --- sets ---------------------------------------------------------------------------


def _sets(gate: Gate, state: MemoryState) -> None:
    """Check that each description is in views of a single set or has no known place."""
    described = {i.number: i for i in (*state.items, *state.empty) if i.number}
    need(once((home.kind, home.place) for home in state.sets), "a set twice")
    serials = [serial for home in state.sets for serial, _ in home.layers]
    need(once(serials), "a layer twice")
    need(all(0 < n <= state.layers for n in serials), "an unknown layer")
    homes: dict[int, SetState] = {}
    for home in state.sets:
        need(gate.recognizer.recognises(home.kind), f"a set of `{home.kind}`")
        _check_set(home, described)
        for number in {*home.local, *(n for _, row in home.layers for n in row)}:
            need(number not in homes, f"item {number} is in two sets")
            homes[number] = home
    for number, item in described.items():
        need((number in homes) != (number in state.lost), f"the place of {number}")
        need(number not in homes or item.kind == homes[number].kind, "a class")
        inside = number in homes and number in homes[number].local
        need(inside or number in state.lost or not item.accessible, "a local item")
    need(once(state.lost), "a lost item twice")
    need(described.keys() >= {*state.lost}, "an unknown lost item")
    sets = range(len(state.sets))
    need(all(at in sets for at in state.unsettled), "an unknown set")


def _check_set(home: SetState, described: Mapping[int, ItemState]) -> None:
    rows = [home.local, *(row for _, row in home.layers)]
    for row in rows:
        need(once(row), "an item twice in a view")
        need(all(number in described for number in row), "an unknown item in a view")
    serials = [serial for serial, _ in home.layers]
    need(serials == sorted(serials), "layers in another order")
    sizes = {len(row) for _, row in home.layers}
    need(len(sizes) < 2, "layers of other sizes")
    need(not sizes or len(home.local) <= max(sizes), "more local items than expected")
    need(all(described[n].accessible for n in home.local), "a local item out of reach")
