"""Expectation sets to be read: what tests, tools and people are shown of them.

A memory without an interpreter is driven through
`rapc.runtime.memory.bench.MemoryBench`:

    bench = MemoryBench(library, comparators={"by-eye": compare}, max_layers=8)
    bench.time = 5                       # stamps of what follows
    with bench.batch():                  # results and data of one primitive
        name = bench.introduce("s-1", "box", "bay")
        bench.assert_fact("color", name, "red")
        bench.fix_cardinality("bay")     # takes effect at the end of the batch
    bench.move(name, "dock")             # outside a batch: one of its own
    bench.lose(name); bench.expire(); bench.erase("color", name)
    bench.name(alias)                    # the name that now stands for it
    bench.sets()                         # tuple of SetView
    bench.events                         # list of events, item-merged among them

`library` is a linked `rapc.library.library.Library` with the declarations.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from rapc.base.values import Atom, Fact
from rapc.world import Time


class DescriptionView(msgspec.Struct, frozen=True):
    """One description as it stands in a view of a set.

    `name` is None for an empty description. `number` tells descriptions apart, empty
    ones too: one that stands in several views has one number; the older, the smaller.
    `sensor` is None out of reach. `properties` maps a property's index without the
    item (`("contains", "papers")`, `("color",)`) to its value and stamp, without
    location and introducing class; the stamp is None for what became unknown.
    """

    name: str | None
    number: int
    sensor: str | None
    properties: Mapping[Fact, tuple[Atom, Time | None]]


class SetView(msgspec.Struct, frozen=True):
    """An expectation set: the local model's part, and the layers, oldest first."""

    kind: str
    place: Atom
    size: int
    local: tuple[DescriptionView, ...]
    layers: tuple[tuple[DescriptionView, ...], ...]
