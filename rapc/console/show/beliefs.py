"""What the robot believes of the things in a picture, and how either is told in words.

Items are compared by what they are and where, not by name: the names of memory and
those of a world have nothing to do with each other.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from rapc.base.values import Atom, format_atom
from rapc.runtime.memory.gate import MemoryView
from rapc.world import Picture, Thing

Contents = Counter[tuple[str, str]]
"""How many things there are of a class that look so (`red`, or nothing)."""


def true_contents(things: Iterable[Thing]) -> Contents:
    """Return what things there are."""
    return Counter((thing.kind, _look(thing.look)) for thing in things)


def believed_contents(memory: MemoryView, picture: Picture) -> dict[str, Contents]:
    """Return what the robot believes is where, by the name of the spot or place.

    An item that is believed to be in another one is where that is.
    """
    places = {f[1]: f[2] for f in memory.query("location", None, None)}
    held: dict[Atom, Contents] = {}
    for item, place in places.items():
        kind = memory.kind(item)
        if kind is not None:
            look = _look(memory.value(picture.look, item))
            held.setdefault(place, Counter())[kind, look] += 1
    found: dict[str, Contents] = {}
    for place, contents in held.items():
        for kind in {kind for kind, _ in contents}:
            _leave(contents, kind, memory.count(kind, place))
        at = format_atom(_outermost(place, places))
        found.setdefault(at, Counter()).update(contents)
    return found


def _leave(contents: Contents, kind: str, count: int) -> None:
    """Leave so many of a class as memory expects, however many descriptions it has.

    One item may go by several until they are recognised as one (T A.5): those go first
    of which least is known, then those of which there are most.
    """
    looks = {look: n for (of, look), n in contents.items() if of == kind}
    for _ in range(sum(looks.values()) - count):
        look = max(looks, key=lambda look: (look == "", looks[look], look))
        looks[look] -= 1
        contents[kind, look] -= 1
        if not looks[look]:
            del looks[look], contents[kind, look]


def _look(value: Atom | None) -> str:
    return "" if value is None else format_atom(value)


def _outermost(place: Atom, places: Mapping[Atom, Atom]) -> Atom:
    passed = {place}
    while place in places and places[place] not in passed:
        place = places[place]
        passed.add(place)
    return place


def contents_in_words(contents: Contents) -> str:
    """Contents in words: `2 red+blue rock, fuel-drum`; `nothing` if there are none."""
    by_kind: dict[tuple[str, bool], list[str]] = {}
    for (kind, look), count in sorted(contents.items()):
        number = "" if count == 1 else f"{count} "
        by_kind.setdefault((kind, look != ""), []).append(f"{number}{look}".strip())
    groups = (f"{'+'.join(parts)} {kind}" for (kind, _), parts in by_kind.items())
    return ", ".join(group.strip() for group in groups) or "nothing"
