"""A memory to be driven in a few lines, and read in fewer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rapc import events
from rapc.base.values import Atom
from rapc.library.loader import load_text
from tests.memory.bench import DescriptionView, MemoryBench, SetView

WORDS = """
(declare-memory-property class (?item ?class ?value) unknown)
(declare-memory-property location (?item ?place) unknown)
(declare-memory-property size (?item ?value) unknown)
(declare-memory-property color (?item ?value) unknown)
(declare-memory-property content (?item ?value) unknown)
(declare-memory-property mark (?item ?value) unknown)
(declare-memory-property lid (?item ?value) unknown)
(declare-memory-property contains (?item ?other ?value) unknown)
(declare-memory-property is-empty (?item ?value) unknown
  :excludes true (contains ?item ? true))
(declare-memory-proposition near (?item ?other))
"""

DRUMS = WORDS + "(declare-indistinct-class drum)\n"
BOXES = WORDS + "(declare-indistinct-class box)\n"


def bench(text: str, **how: Any) -> MemoryBench:
    """A memory with the declarations of a text, in which nothing may be wrong."""
    loaded = load_text(text)
    assert loaded.diagnostics == ()
    return MemoryBench(loaded.library, **how)


def see(
    memory: MemoryBench,
    kind: str,
    place: Atom,
    *each: Mapping[str, Atom],
    first: int = 1,
) -> list[str]:
    """See items one after another in one batch, with properties; their names."""
    names = []
    with memory.batch():
        for number, properties in enumerate(each, first):
            sensor = f"s{memory.time}-{number}"
            names.append(memory.introduce(sensor, kind, place))
            for name, value in properties.items():
                memory.assert_fact(name, names[-1], value)
    return [memory.name(name) for name in names]


def leave(memory: MemoryBench) -> None:
    """The robot goes, and time with it."""
    memory.expire()
    memory.time = memory.time + 10


def the_set(memory: MemoryBench, kind: str, place: Atom) -> SetView:
    """The expectation set of a class at a place."""
    (found,) = [s for s in memory.sets() if (s.kind, s.place) == (kind, place)]
    return found


def values(description: DescriptionView) -> dict[str, Atom]:
    """A description's properties of one value by their names."""
    return {
        str(index[0]): value for index, (value, _) in description.properties.items()
    }


def names(view: Sequence[DescriptionView]) -> list[str | None]:
    """Who stands in a view; None for an empty description."""
    return [description.name for description in view]


def merges(memory: MemoryBench) -> list[tuple[str, str | None, Atom, Atom]]:
    """Every merge so far: item, the name that went, score, rival (0: none)."""
    return [
        (event.item, event.with_, event.score or 0, event.rival or 0)
        for event in memory.events
        if isinstance(event, events.ItemMerged)
    ]
