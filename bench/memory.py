"""Recognising items: what one new property costs, and how memory grows on the road.

A set of n drums in five layers, none of which says anything about another: on each of
five visits another property was seen of every drum, with ten values (`alike`) or with
a value for each drum (`all different`). Now all are in reach again; a property of one
is seen, which recognises it in one layer, and all views are looked through for more.

A truck drives about a world of 200 items for 100,000 time units, looks about at each
place, and closely at two of the things there. What is counted are the descriptions in
memory, with recognition and without.
"""

from __future__ import annotations

import json
import random
import statistics
import time
from collections.abc import Iterator, Mapping

from bench.common import Figure
from rapc.base.values import Atom, Fact, Text
from rapc.library import loader
from rapc.library.library import Library
from rapc.library.signatures import Signatures
from rapc.runtime.events.recorder import Recorder
from rapc.runtime.memory.access import MemoryAccess
from rapc.worlds.maps import shipped_map
from rapc.worlds.registry import build_world
from rapc.worlds.truck import TruckWorld
from tests.memory.bench import MemoryBench

PROPERTIES = ("color", "size", "content", "mark", "lid")
LIBRARY = "".join(
    f"(declare-memory-property {name} (?item {rest}) unknown)\n"
    for name, rest in (
        ("class", "?class ?value"),
        ("location", "?place"),
        *((name, "?value") for name in PROPERTIES),
    )
)
DRUMS = LIBRARY + "(declare-indistinct-class drum)\n"
DIGESTED = 20
"""How many properties are seen one after another; the figure is the median."""


def digest(drums: int, kinds: int) -> float:
    """The median CPU time in seconds in which one new property is digested."""
    memory = MemoryBench(loader.load_text(DRUMS).library, record=False)
    names: list[str] = []
    for visit, name in enumerate((*PROPERTIES, "")):
        memory.expire()
        memory.time = visit
        names.clear()
        with memory.batch():
            for n in range(drums):
                names.append(memory.introduce(f"s{visit}-{n}", "drum", "depot"))
                if name:
                    memory.assert_fact(name, names[-1], f"{name}-{n % kinds}")
    times = []
    for n in range(DIGESTED):
        name = PROPERTIES[n % len(PROPERTIES)]
        start = time.process_time()
        memory.assert_fact(name, names[n], f"{name}-{n % kinds}")
        times.append(time.process_time() - start)
    return statistics.median(times)


def _library(recognising: bool) -> Library:
    """The truck's words, with or without its indistinct classes."""
    text = '(require "truck")'
    loaded = loader.load_text(text)
    if recognising:
        return loaded.library
    return _without(loaded.library)


def _without(library: Library) -> Library:
    parts = {name: getattr(library, name) for name in library.__struct_fields__}
    return Library(**{**parts, "indistinct": {}})


def _options(items: int, seed: int) -> Mapping[str, Atom | bool]:
    """A world of so many items on the map of T 6.1, in which nothing else happens."""
    rng = random.Random(seed)
    ground = json.loads(shipped_map("truck", "default"))
    places = [place["name"] for place in ground["places"]]
    kinds = (("rock", "red"), ("rock", "blue"), ("fuel-drum", None), ("ammo-box", None))
    lying = []
    for _ in range(items):
        kind, color = rng.choice(kinds)
        place = rng.choice(places)
        lying.append({"kind": kind, "place": place, "count": 1, "color": color})
    ground["items"] = lying
    off = {f"{job}-interval": 0 for job in ("quarry", "warehouse", "depot", "factory")}
    return {**off, "fuel-use": 0, "map": Text(json.dumps(ground))}


class Drive:
    """A truck that drives about at random, and what its memory makes of it."""

    def __init__(self, items: int, recognising: bool, seed: int = 0) -> None:
        self._rng = random.Random(f"{seed}:drive")
        world = build_world(TruckWorld, seed, _options(items, seed))
        assert isinstance(world, TruckWorld)
        self.world = world
        self._handlers = self.world.kit.handlers
        self._recorder = Recorder()
        library = _library(recognising)
        words = Signatures.of(library)
        self._access = MemoryAccess(library, words, self._recorder, {})
        for fact in self.world.facts():
            self._access.assert_fact(*fact)

    def descriptions(self) -> int:
        """How many items memory holds."""
        return len(self._access.memory.items.known)

    def go(self) -> None:
        """One trip, a look about at its end, and a close look at two things."""
        access = self._access
        roads = access.query("road", None, access.place, None, None)
        direction = self._rng.choice(roads)[3]
        self._do("truck-turn", direction)
        self._do("truck-move")
        self._do("eye-scan", "external")
        near = access.query("location", None, access.place or "")
        reached = [f[1] for f in near if self._access.memory.items.is_accessible(f[1])]
        for item in self._rng.sample(reached, min(2, len(reached))):
            self._do("eye-examine", "external", item)

    def _do(self, *request: Atom) -> None:
        memory, access = self._access.memory, self._access
        known = memory.canonical(request)
        sent = [request[0]]
        for part in known[1:]:
            sensor = memory.items.sensor_of(str(part))
            if sensor is None:
                return
            sent.append(sensor)
        reply = self.world.perform(0, tuple(sent))
        assert reply is not None
        self._recorder.time = self.world.now()
        with access.batch():
            handler = self._handlers.results.get(str(request[0]))
            if handler is not None:
                handler(access, known, reply.result)
            for datum in reply.data:
                self._digest(datum)
        for message in self.world.messages():
            self._digest(message.content)  # type: ignore[union-attr]

    def _digest(self, datum: Fact) -> None:
        access, items = self._access, self._access.memory.items
        named = (datum[0], *[items.name_of(str(part)) for part in datum[1:]])
        values = [
            n if isinstance(d, str) else d for n, d in zip(named, datum, strict=True)
        ]
        with access.batch():
            self._handlers.data[str(datum[0])](access, tuple(values))


def curve(until: int, tenths: int, recognising: bool) -> Iterator[tuple[int, int]]:
    """Descriptions in memory after each tenth of a time, up to so many tenths."""
    drive = Drive(200, recognising)
    for tenth in range(1, tenths + 1):
        while drive.world.now() < until * tenth / 10:
            drive.go()
        yield until * tenth // 10, drive.descriptions()


def figures(quick: bool) -> Iterator[Figure]:
    """All figures of this benchmark."""
    for drums in (100, 200) if quick else (250, 500, 1000, 2000):
        for what, kinds in (("alike", 10), ("all different", drums)):
            size = f"{drums:,} drums, 5 layers"
            taken = digest(drums, kinds) * 1000
            yield Figure("memory", f"digest a property, {what}", size, taken, "ms")
    until = 2000 if quick else 100_000
    for what, tenths in (("recognising", 10), ("not recognising", 3)):
        for now, count in curve(until, tenths, tenths == 10):
            size = f"{now:,} time units"
            yield Figure("memory", f"descriptions, {what}", size, count, "items")
