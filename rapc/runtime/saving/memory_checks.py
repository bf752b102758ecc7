"""Validate a restored memory before the replacement: its parts must agree.

The declarations must allow all facts, and the tables of items, sets and mentions must
agree about each item.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import chain

from rapc.base.values import Atom, Fact, format_list
from rapc.language.atoms import is_atom
from rapc.runtime.memory.access import MemoryAccess
from rapc.runtime.memory.exclusions import items_of
from rapc.runtime.memory.facts import PREFIX, FactTable
from rapc.runtime.memory.items import Items
from rapc.runtime.memory.memory import in_one_form
from rapc.runtime.memory.recognition.recognizer import Recognizer
from rapc.runtime.memory.recognition.sets import Description, ExpectationSet
from rapc.runtime.saving.codecs import need


def once(values: Iterable[object]) -> bool:
    """Return whether no value occurs twice."""
    listed = list(values)
    return len(set(listed)) == len(listed)


def check_memory(access: MemoryAccess) -> None:
    """Validate a memory made from a record.

    Raises:
        WrongRecordError: for a memory that no run can have left. Also ValueError and
            LookupError.
    """
    memory = access.memory
    tables = memory.facts.tables
    for name, table in tables.items():
        _check_table(access, name, table)
    stored = set(chain(*[table.stamps for table in tables.values()]))
    for part in set(chain(*stored)):
        need(in_one_form(part) == part, "a number in another form")
    need(memory.place is None or is_atom(memory.place), "an unknown place")
    need(memory.notations.by_fact.keys() <= stored, "a notation that is no fact")
    _check_mentions(access, stored)
    _check_past(access)
    _check_items(memory.items)
    described = [d for d in memory.items.known.values() if isinstance(d, Description)]
    _check_sets(access.recognizer, described)
    _check_values(access, stored, described)


# --- facts --------------------------------------------------------------------------


def _check_table(access: MemoryAccess, name: Atom, table: FactTable) -> None:
    """Validate the facts of a name by its declaration. Raises ValueError, too."""
    memory = access.memory
    relation, noted = memory.signatures.relations[str(name)], memory.notations
    need(name == relation.name, f"a table of `{name}`")
    for fact in table.stamps:
        count = len(fact) - 1
        if count != relation.most:
            fits = relation.most is None and relation.miscount(count) is None
            need(fits, f"{format_list(fact)} has another number of arguments")
        need(fact[0] == name, f"the table of `{name}`")
        if fact not in noted.by_fact:
            access.check_kinds(fact)
    if relation.is_property:
        need(once(fact[:-1] for fact in table.stamps), f"two values of `{name}`")


def _check_mentions(access: MemoryAccess, stored: set[Fact]) -> None:
    """Check that the facts that mention an item are known by its name."""
    mentions = access.memory.mentions
    if mentions is None:
        return
    expected: dict[Atom, set[Fact]] = {}
    for fact in stored:
        for part in fact[1:]:
            if type(part) is str and part.startswith(PREFIX):
                expected.setdefault(part, set()).add(fact)
    found = {name: set(facts) for name, facts in mentions.by_item.items()}
    need(found == expected, "facts that mention an item")


def _check_past(access: MemoryAccess) -> None:
    """Check that past assertions exclude facts of the item."""
    exclusions = access.memory.exclusions
    for item, past in () if exclusions is None else exclusions.by_item.items():
        for excluded, (fact, _) in past.items():
            full = access.memory.full_form(fact) == fact
            need(full, f"{format_list(fact)} is incomplete")
            access.check_kinds(fact)
            need(item in items_of(excluded), f"`{item}` is not excluded")


# --- items --------------------------------------------------------------------------


def _check_items(items: Items) -> None:
    """Check that names and sensor names are unique, and that aliases lead to names."""
    known = items.known
    need(all(known), "an item without a name")
    need(known.keys().isdisjoint(items.aliases), "an alias of another name")
    need(known.keys().isdisjoint(items.gone), "a removed item")
    _check_aliases(items.aliases)
    reached = [name for name, item in known.items() if item.accessible]
    need(sorted(reached) == sorted(items.reach), "other items are in reach")
    for name in reached:
        item = known[name]
        need(items.reach[name] is item, f"`{name}` is another item")
        there = item.sensor and items.by_sensor.get(item.sensor) is item
        need(there, f"the sensor name of `{name}`")


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


def _check_values(
    access: MemoryAccess, stored: set[Fact], described: Iterable[Description]
) -> None:
    """Check that a description has the values of the facts about its item."""
    relations = access.memory.signatures.relations
    by_name = {item.name: item for item in described}
    expected: dict[str, dict[Fact, Atom]] = {name: {} for name in by_name}
    for fact in stored if by_name else ():
        item = by_name.get(str(fact[1])) if len(fact) > 2 else None
        if item is None or fact[0] == "location":
            continue
        relation = relations[str(fact[0])]
        if relation.is_property and not (fact[0] == "class" and fact[2] == item.kind):
            expected[item.name][fact[0], *fact[2:-1]] = fact[-1]
    for name, item in by_name.items():
        need(item.values == expected[name], f"the description of `{name}`")


# --- sets ---------------------------------------------------------------------------


def _check_sets(recognizer: Recognizer, described: Iterable[Description]) -> None:
    """Check that each description is in views of a single set or has no known place."""
    sets, lost = recognizer.sets.values(), recognizer.lost
    serials = [layer.serial for home in sets for layer in home.layers]
    need(once(serials), "duplicate layer")
    need(all(0 < n <= recognizer.layers for n in serials), "an unknown layer")
    homes: dict[Description, ExpectationSet] = {}
    for home in sets:
        need(recognizer.recognises(home.kind), f"a set of `{home.kind}`")
        _check_set(home)
        for item in {member: None for view in home.views() for member in view.members}:
            need(item not in homes, f"item {item.number} is in two sets")
            need(item.kind == home.kind, "a class")
            homes[item] = home
    for item in (*described, *homes):
        need(0 < item.number <= recognizer.number, "an unknown number of an item")
    for item in described:
        need(item.name, "an item without a name")
        need((item in homes) != (item in lost), f"the place of {item.number}")
        inside = item in homes and item in homes[item].local.members
        need(inside or item in lost or not item.accessible, "a local item")
    need(not any(item.empty for item in lost), "an unknown lost item")


def _check_set(home: ExpectationSet) -> None:
    serials = [layer.serial for layer in home.layers]
    need(serials == sorted(serials), "layers in another order")
    sizes = {len(layer) for layer in home.layers}
    need(len(sizes) < 2, "layers of other sizes")
    need(not sizes or len(home.local) <= max(sizes), "more local items than expected")
    local = home.local.members
    need(all(item.accessible for item in local), "a local item out of reach")
