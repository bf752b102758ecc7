"""A memory that was saved and restored goes on as if nothing had been."""

from __future__ import annotations

import random

import msgspec
import pytest

from rapc.compiler.program import Program
from rapc.events import Event
from rapc.runtime.memory.access import MemoryAccess
from rapc.runtime.memory.facts import NEVER
from rapc.runtime.saving.codecs import Reader, Writer, fields_of
from rapc.runtime.saving.memory_checks import check_memory
from tests.effort import first

from .bench import MemoryBench
from .sightings import BOXES, DRUMS, bench, leave, see
from .walking import Step, Walk


def _bytes(memory: MemoryBench) -> bytes:
    access = memory.access
    return msgspec.json.encode(fields_of(MemoryAccess).write(Writer(access), access))


def _restore(memory: MemoryBench, saved: bytes) -> None:
    record = msgspec.json.decode(saved, type=fields_of(MemoryAccess).saved)
    access = MemoryBench(memory.library).access
    fields_of(MemoryAccess).read(Reader(Program(memory.library), access), record)
    check_memory(access)
    memory.access.take_up(access)


def _steps(seed: int, count: int) -> list[Step]:
    rng = random.Random(seed)
    return [
        (rng.randrange(100), rng.randrange(100), rng.randrange(100))
        for _ in range(count)
    ]


def _go(walk: Walk, steps: list[Step]) -> tuple[list[Event], object, object]:
    """Walk on; all that came of it."""
    walk.memory.events.clear()
    walk.memory.recorder.serial = 0
    for step in steps:
        walk.step(step)
    facts = [
        (name, list(table.stamps.items()))
        for name, table in sorted(walk.memory.access.memory.facts.tables.items())
        if table.stamps
    ]
    return (list(walk.memory.events), walk.memory.sets(), facts)


@pytest.mark.parametrize("seed", first(8, range(40)))
def test_a_walk_goes_on_the_same_way(seed: int) -> None:
    rng = random.Random(seed)
    walk, other = Walk(), Walk()
    for step in _steps(seed, rng.randrange(150)):
        walk.step(step)
    for step in _steps(seed + 1000, rng.randrange(60)):
        other.step(step)
    saved, time, sensors = _bytes(walk.memory), walk.memory.time, walk.sensors
    rest = _steps(seed + 2000, 80)
    expected = _go(walk, rest)
    assert expected[0]
    for each in (walk, other, Walk()):
        _restore(each.memory, saved)
        assert _bytes(each.memory) == saved
        each.memory.time, each.sensors = time, sensors
        assert _go(each, rest) == expected


def test_saving_tells_nobody() -> None:
    walk = Walk()
    for step in _steps(3, 100):
        walk.step(step)
    events = list(walk.memory.events)
    assert _bytes(walk.memory) == _bytes(walk.memory)
    _restore(walk.memory, _bytes(walk.memory))
    assert walk.memory.events == events


def test_what_became_unknown_is_still_older_than_anything() -> None:
    memory = bench(BOXES)
    see(memory, "box", "bay", {"color": "red"}, {"color": "blue"})
    leave(memory)
    [name] = see(memory, "box", "bay", {})
    memory.lose(name)
    facts = memory.access.memory.facts
    before = {fact: facts.stamp(fact) for fact in facts}
    assert NEVER in before.values()
    other = bench(BOXES)
    _restore(other, _bytes(memory))
    restored = other.access.memory.facts
    assert {fact: restored.stamp(fact) for fact in restored} == before


def test_exclusion_by_a_fact_that_has_gone_outlives_a_restore() -> None:
    memory = bench(DRUMS)
    (old,) = see(memory, "drum", "bay", {"mark": "x"})
    memory.assert_fact("contains", old, "nuts", "true")
    leave(memory)
    new, _ = see(memory, "drum", "bay", {}, {})
    memory.assert_fact("is-empty", new, "true")
    memory.time += 1
    memory.assert_fact("is-empty", new, "false")
    _restore(memory, _bytes(memory))
    memory.assert_fact("mark", new, "x")
    assert memory.name(new) == old
    assert memory.memory.value("contains", old, "nuts") is None


def test_queries_keep_their_tables() -> None:
    memory = bench(DRUMS)
    memory.assert_fact("near", "a", "b")
    table = memory.access.memory.facts.table("near")
    stamps, index = table.stamps, table.index(1)
    saved = _bytes(memory)
    memory.erase("near")
    memory.assert_fact("near", "c", "d")
    _restore(memory, saved)
    assert list(stamps) == [("near", "a", "b")]
    assert index == {"a": {("near", "a", "b"): None}}
