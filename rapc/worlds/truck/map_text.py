"""Maps from JSON text: parsing and validation."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator, Mapping

import msgspec

from rapc.base.decoding import UNREADABLE, flaw
from rapc.base.names import hint
from rapc.worlds.maps import MapError
from rapc.worlds.truck.kinds import COLORED, ENEMY, KINDS, Kind, TruckMachine
from rapc.worlds.truck.map import TAKEN, Map

_MOST = 1_000_000
_NUMBERED = re.compile(r"-s?[0-9]+$")
"""The reserved endings of item names and sensor names."""


def read_map(text: str) -> Map:
    """Return the map in a JSON text.

    Raises:
        MapError: if the text is not JSON, has unknown fields, or is inconsistent.
    """
    try:
        made = msgspec.json.decode(text.encode(), type=Map)
    except UNREADABLE as error:
        raise MapError(f"cannot be read: {flaw(error)}") from error
    for problem in _problems(made):
        raise MapError(problem)
    return made


def _problems(made: Map) -> Iterator[str]:
    names, kinds = made.spots(), {**KINDS, **made.kinds}
    for name, times in Counter(names).items():
        if times > 1:
            yield f"`{name}` stands for two places or roads"
        if name in TAKEN or name in made.kinds or _NUMBERED.sub("", name) in kinds:
            yield f"`{name}` cannot be the name of a place or road"
    places = [place.name for place in made.places]
    yield from _unknown(made.start, places, "the start")
    for road in made.roads:
        for end in (road.a, road.b):
            yield from _unknown(end, places, f"an end of `{road.name}`")
        if road.a == road.b:
            yield f"`{road.name}` leads from `{road.a}` to itself"
        if not (0 < road.time <= _MOST and 0 <= road.fuel <= _MOST):
            yield f"`{road.name}` must take time, and no less fuel than none"
        if not (0 <= road.mishap <= 1 and 0 <= road.mud <= 1):
            yield f"`{road.name}`: the chance of a mishap is not from 0 to 1"
    yield from _crossed(made)
    yield from _bad_colors(made)
    yield from _bad_sectors(made, names)
    for name, kind in made.kinds.items():
        yield from _bad_kind(name, kind, kinds)
    yield from _misplaced(made, kinds)


def _unknown(name: str, known: Collection[str], what: str) -> Iterator[str]:
    if name not in known:
        yield f"{what} is `{name}`, which is unknown{hint(name, known)}"


def _bad_kind(name: str, kind: Kind, kinds: Mapping[str, Kind]) -> Iterator[str]:
    if name in TAKEN or _NUMBERED.search(name):
        yield f"`{name}` cannot be the name of a kind"
    if kind.holds and kind.holds >= kind.size:
        yield f"a `{name}` cannot hold as much as it is large"
    if bool(kind.capacity) != bool(kind.liquid or kind.rounds):
        yield f"`{name}`: a capacity goes with a liquid or with rounds"
    if kind.liquid and kind.rounds:
        yield f"`{name}` is a vessel or a weapon, not both"
    if kind.tool not in (None, "gun-tool"):
        yield f"a `{name}` can only need a `gun-tool` (the robot knows no other tool)"
    for one in kind.mends:
        yield from _unknown(one, kinds, f"what a `{name}` mends")
        if one in kinds and kinds[one].machine is None:
            yield f"a `{name}` repairs machines, and `{one}` is not a machine"
    if kind.machine is not None:
        yield from _bad_machine(name, kind, kind.machine, kinds)


def _bad_machine(
    name: str, kind: Kind, machine: TruckMachine, kinds: Mapping[str, Kind]
) -> Iterator[str]:
    if not 1 <= machine.every <= _MOST:
        yield f"a `{name}` cannot work every {machine.every} time units"
    for part in (machine.makes, *machine.needs):
        yield from _unknown(part, kinds, f"what a `{name}` makes or needs")
    if machine.makes in COLORED or machine.makes == ENEMY:
        yield f"a `{name}` cannot make a `{machine.makes}`"
    if kind.rounds or machine.uses > kind.capacity:
        yield f"a `{name}` uses up a liquid that it cannot contain"
    needed = sum(kinds[part].size * count for part, count in machine.needs.items())
    if needed > kind.holds:
        yield f"a `{name}` cannot hold what it needs"


def _misplaced(made: Map, kinds: Mapping[str, Kind]) -> Iterator[str]:
    """Yield faults of items with an unknown kind or place, containers first."""
    room: dict[str, int] = {}
    numbers: Counter[str] = Counter()
    for lying in made.items:
        yield from _unknown(lying.kind, kinds, "an item's kind")
        kind = kinds[lying.kind]
        if lying.broken and kind.machine is None:
            yield f"only machines can be broken, not a `{lying.kind}`"
        where = f"the place of a `{lying.kind}`"
        yield from _unknown(lying.place, (*made.spots(), *room), where)
        if lying.place in room:
            room[lying.place] -= kind.size * lying.count
            if room[lying.place] < 0:
                yield f"`{lying.place}` cannot hold all that lies in it"
        for _ in range(lying.count if kind.holds else 0):
            numbers[lying.kind] += 1
            room[f"{lying.kind}-{numbers[lying.kind]}"] = kind.holds


def _crossed(made: Map) -> Iterator[str]:
    for place in made.places:
        taken: dict[str, str] = {}
        for leg in made.legs(place.name):
            first = taken.setdefault(leg.direction, leg.road.name)
            if first != leg.road.name:
                yield (
                    f"`{first}` and `{leg.road.name}` both lead "
                    f"{leg.direction} from `{place.name}`"
                )


def _bad_sectors(made: Map, names: Collection[str]) -> Iterator[str]:
    sectors: dict[str, str] = {}
    for index, sector in enumerate(made.sectors):
        if sector.name in [other.name for other in made.sectors[:index]]:
            yield f"`{sector.name}` stands for two sectors"
        for spot in sector.spots:
            yield from _unknown(spot, names, f"part of the sector `{sector.name}`")
            if sectors.setdefault(spot, sector.name) != sector.name:
                yield f"`{spot}` is in two sectors"


def _bad_colors(made: Map) -> Iterator[str]:
    for place in made.places:
        if (place.color is not None) != (place.kind == "quarry"):
            yield f"`{place.name}`: quarries alone have a colour"
    for lying in made.items:
        if (lying.color is not None) != (lying.kind in COLORED):
            yield f"`{lying.kind}` at `{lying.place}`: rocks alone have a colour"
