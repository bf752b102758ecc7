"""The robot's beliefs about the things in a picture, and contents as text.

Items are compared by class, look and place, not by name: the names in memory are
unrelated to the names in a world.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from rapc.base.pictures import outermost
from rapc.base.values import Atom, format_atom
from rapc.runtime.memory.access import MemoryView
from rapc.world import Picture, Thing

Contents = Counter[tuple[str, str]]
"""The number of things of a class with a look (`red`, or no text)."""


def true_contents(things: Iterable[Thing]) -> Contents:
    """Return some things as contents."""
    return Counter((thing.kind, _look(thing.look)) for thing in things)


def believed_contents(memory: MemoryView, picture: Picture) -> dict[str, Contents]:
    """Return the things that the robot believes in, by name of spot or place.

    An item that is believed to be in a second item is at the place of the second.
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
        at = format_atom(outermost(place, places))
        found.setdefault(at, Counter()).update(contents)
    return found


def _leave(contents: Contents, kind: str, count: int) -> None:
    """Keep as many of a class as memory expects, out of all descriptions.

    One item may have several descriptions until these are merged (T A.5). Descriptions
    with the least information are removed first, then the most frequent ones.
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


def contents_in_words(contents: Contents) -> str:
    """Return contents as text: `2 red+blue rock, fuel-drum`, or `nothing`."""
    by_kind: dict[tuple[str, bool], list[str]] = {}
    for (kind, look), count in sorted(contents.items()):
        number = "" if count == 1 else f"{count} "
        by_kind.setdefault((kind, look != ""), []).append(f"{number}{look}".strip())
    groups = (f"{'+'.join(parts)} {kind}" for (kind, _), parts in by_kind.items())
    return ", ".join(group.strip() for group in groups) or "nothing"
