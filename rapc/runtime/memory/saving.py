"""Memory as plain records for a saved run, and back.

A `MemoryState` holds everything that determines later solutions and their order, and
nothing that can be derived: it leaves out indexes, the caches of recognition, and
observers. Restoring is in place, because compiled queries refer to the tables of facts.

The interpreter captures memory between batches: within a batch, `Gate` has places to be
counted.
"""

from __future__ import annotations

import msgspec

from rapc.base.values import Atom, Fact
from rapc.runtime.memory.exclusions import Past
from rapc.runtime.memory.facts import NEVER
from rapc.runtime.memory.gate import Gate
from rapc.runtime.memory.items import Item
from rapc.runtime.memory.recognition.sets import Description, ExpectationSet, View
from rapc.world import Time


class ItemState(msgspec.Struct, frozen=True, array_like=True):
    """An introduced item, or a description of an item."""

    #: The memory name; "" for an empty description.
    name: str
    sensor: str
    kind: str
    accessible: bool
    #: For a description its number, to which sets refer; for a distinct item 0.
    number: int
    #: For a description its properties, as in `Description.values`, in order.
    values: tuple[tuple[Fact, Atom], ...]


class SetState(msgspec.Struct, frozen=True, array_like=True):
    """An expectation set, with the numbers of its descriptions in their order."""

    kind: str
    place: Atom
    local: tuple[int, ...]
    #: Each layer with its serial number, oldest first.
    layers: tuple[tuple[int, tuple[int, ...]], ...]


class MemoryState(msgspec.Struct, frozen=True):
    """The state of a memory, encodable by msgspec."""

    place: Atom | None
    #: The facts of each name, by name, oldest assertion first; a fact without a stamp
    #: was never asserted.
    facts: tuple[tuple[Atom, tuple[tuple[Fact, Time | None], ...]], ...]
    #: The facts that are notations, each with the number of methods that note it.
    notations: tuple[tuple[Fact, int], ...]
    #: The items that memory knows, in the order of their introduction.
    items: tuple[ItemState, ...]
    #: The empty descriptions of the sets.
    empty: tuple[ItemState, ...]
    aliases: dict[str, str]
    gone: tuple[str, ...]
    #: Sensor names with the names of their items.
    sensors: tuple[tuple[str, str], ...]
    #: The names of the accessible items, in the order in which they came into reach.
    reach: tuple[str, ...]
    #: The facts that mention an item, by its name, oldest assertion first.
    mentions: tuple[tuple[str, tuple[Fact, ...]], ...]
    sets: tuple[SetState, ...]
    #: The unsettled sets, by position in `sets`.
    unsettled: tuple[int, ...]
    #: The numbers of the descriptions with an unknown place.
    lost: tuple[int, ...]
    #: The numbers of the youngest description and of the latest layer.
    number: int
    layers: int
    #: By item the last assertions that exclude facts of the item: `Exclusions.past`.
    past: tuple[tuple[str, tuple[Past, ...]], ...] = ()


# --- capturing ---------------------------------------------------------------------


def capture_memory(gate: Gate) -> MemoryState:
    """Return the state of a memory."""
    memory, recognizer = gate.memory, gate.recognizer
    items = memory.items
    sets = list(recognizer.sets.values())
    position = {home: at for at, home in enumerate(sets)}
    empty = {d.number: d for home in sets for d in home.members() if d.empty}
    mentions = memory.mentions
    return MemoryState(
        place=memory.place,
        facts=tuple(
            (name, tuple((f, _stamp(time)) for f, time in table.stamps.items()))
            for name, table in sorted(memory.facts.tables.items(), key=_name)
            if table.stamps
        ),
        notations=tuple(
            (fact, notation.count)
            for fact, notation in memory.notations.by_fact.items()
        ),
        items=tuple(_item(item) for item in items.known.values()),
        empty=tuple(_item(empty[number]) for number in sorted(empty)),
        aliases=dict(items.aliases),
        gone=tuple(sorted(items.gone)),
        sensors=tuple((s, item.name) for s, item in items.by_sensor.items()),
        reach=tuple(items.accessible()),
        mentions=() if mentions is None else mentions.state(),
        sets=tuple(_set(home) for home in sets),
        unsettled=tuple(position[h] for h in recognizer.unsettled if h in position),
        lost=tuple(d.number for d in recognizer.lost),
        number=recognizer.number,
        layers=recognizer.layers,
        past=() if memory.exclusions is None else memory.exclusions.state(),
    )


def _name(item: tuple[Atom, object]) -> str:
    return str(item[0])


def _stamp(time: Time) -> Time | None:
    return None if time == NEVER else time


def _item(item: Item) -> ItemState:
    number, values = 0, {}
    if isinstance(item, Description):
        number, values = item.number, item.values
    return ItemState(
        item.name,
        item.sensor,
        item.kind,
        item.accessible,
        number,
        tuple(values.items()),
    )


def _set(home: ExpectationSet) -> SetState:
    return SetState(
        home.kind,
        home.place,
        _members(home.local),
        tuple((layer.serial, _members(layer)) for layer in home.layers),
    )


def _members(view: View) -> tuple[int, ...]:
    return tuple(d.number for d in view.members)


# --- restoring ---------------------------------------------------------------------


def restore_memory(gate: Gate, state: MemoryState) -> None:
    """Restore a memory from `state`, in place; observers get no report.

    The state must be of a memory of the same library. Observers have to look at all
    facts again; every `Notation` from before the call is invalid.
    """
    memory = gate.memory
    gate.drop_batch()
    memory.place = state.place
    memory.facts.load(
        (name, [(f, NEVER if t is None else t) for f, t in facts])
        for name, facts in state.facts
    )
    memory.notations.load(state.notations)
    if memory.mentions is not None:
        memory.mentions.load(state.mentions)
    if memory.exclusions is not None:
        memory.exclusions.load(state.past)
    known = [_made(item) for item in state.items]
    memory.items.load(known, state.aliases, state.gone, state.sensors, state.reach)
    found = (*known, *(_made(item) for item in state.empty))
    by_number = {d.number: d for d in found if isinstance(d, Description)}
    _restore_sets(gate, state, by_number)


def _made(state: ItemState) -> Item:
    if not state.number:
        item = Item(state.name, state.sensor, state.kind)
        item.accessible = state.accessible
        return item
    made = Description(state.number, state.name, state.sensor, state.kind)
    made.accessible = state.accessible
    for index, value in state.values:
        made.learn(index, value)
    return made


def _restore_sets(
    gate: Gate, state: MemoryState, by_number: dict[int, Description]
) -> None:
    recognizer = gate.recognizer
    recognizer.number, recognizer.layers = state.number, state.layers
    recognizer.sets.clear()
    made = []
    for each in state.sets:
        home = ExpectationSet(each.kind, each.place)
        made.append(home)
        recognizer.sets[each.kind, each.place] = home
        for serial, row in ((0, each.local), *each.layers):
            into = home.new_layer(serial) if serial else home.local
            for number in row:
                home.add(into, by_number[number])
    recognizer.unsettled.clear()
    recognizer.unsettled.update((made[at], None) for at in state.unsettled)
    recognizer.lost.clear()
    recognizer.lost.update((by_number[number], None) for number in state.lost)
