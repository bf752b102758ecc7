"""Signals that are lost, late, doubled or spurious on the way from any world."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

import rapc
from rapc.testing.faults import read_fault, told_for_skills
from rapc.world import NOT_KNOWN, Fact, Signal, Time
from rapc.worlds.faults import FaultyWorld, problem
from rapc.worlds.script import Row
from rapc.worlds.scripted import ScriptedWorld

ROLL = (":roll",)
ROWS = (
    Row(
        ROLL,
        kind="enable",
        after=2,
        signals=((":seen", "a"), (":done",)),
        pauses=(0, 3),
    ),
)


def heard(
    *faults: str, until: Time = 20, seed: int = 0, off: Time | None = None
) -> list[tuple[Time, Fact, tuple[int, ...]]]:
    """All signals with their times, of a world whose one skill comes on at 0."""
    read = [read_fault(fault) for fault in faults]
    world: Any = FaultyWorld(ScriptedWorld(ROWS), read, seed)
    assert world.activate(7, (ROLL,), (":seen", ":done")) is None
    found = []
    while (time := world.next_time()) is not None and time <= until:
        if off is not None and time >= off:
            world.deactivate(7)
            off = None
            continue
        world.advance(time)
        for message in world.messages():
            assert isinstance(message, Signal)
            found.append((world.now(), message.content, message.tickets))
    return found


SEEN = (2, (":seen", "a"), (7,))
DONE = (5, (":done",), (7,))


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        ("(:other) lost", [SEEN, DONE]),
        ("(:done) lost", [SEEN]),
        ("(:seen b) lost", [SEEN, DONE]),
        ("(:seen ?x) doubled", [SEEN, SEEN, DONE]),
        ("(:seen ?x) late by=4", [DONE, (6, (":seen", "a"), (7,))]),
        ("(:done) late by=1 from=6", [SEEN, DONE]),
        ("(:done) spurious", [(1, (":done",), (7,)), SEEN, DONE]),
        ("(:other) spurious", [SEEN, DONE]),
    ],
)
def test_a_signal_comes_as_the_fault_says(
    fault: str, expected: Sequence[object]
) -> None:
    assert heard(fault) == expected


def test_a_late_signal_comes_only_while_its_activation_is_on() -> None:
    assert heard("(:seen ?) late by=2", off=3) == []


def test_a_chance_is_drawn_for_each_signal_from_the_seed() -> None:
    counts = [len(heard("(:done) lost p=0.5", seed=seed)) for seed in range(40)]
    assert {1, 2} == set(counts)
    assert counts == [len(heard("(:done) lost p=0.5", seed=seed)) for seed in range(40)]


def test_delayed_signals_are_saved() -> None:
    worlds: list[Any] = [
        FaultyWorld(ScriptedWorld(ROWS), [read_fault("(:seen ?) late by=9")], 0)
        for _ in range(2)
    ]
    one, other = worlds
    one.activate(7, (ROLL,), ())
    one.advance(2)
    assert one.messages() == []
    other.restore(one.save())
    assert other.next_time() == 5
    other.advance(11)
    signals = [m.content for m in other.messages() if isinstance(m, Signal)]
    assert signals == [(":done",), (":seen", "a")]


class Continuous(ScriptedWorld):
    """A world that cannot say when it will next send something."""

    def next_time(self) -> Time | None:
        return NOT_KNOWN


def test_a_signal_held_back_has_a_time_where_the_world_knows_none() -> None:
    world: Any = FaultyWorld(Continuous(ROWS), [read_fault("(:done) spurious by=4")], 0)
    assert world.next_time() == NOT_KNOWN
    world.activate(1, (ROLL,), (":done",))
    assert world.next_time() == 4


LIBRARY = rapc.loads(
    """
    (declare-event :done ())
    (declare-event :seen (?what))
    (declare-event :bump ())
    (declare-skill :roll () :events (:seen))
    (define-rap (roll)
      (method (primitive (enable (:roll)) (wait-for (:done) :succeed))))
    (define-event-rule (:bump) (rule))
    """
)


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        ("(:done) spurious", None),
        ("(:seen mug) spurious", None),
        ("(:bump) spurious", "no skill of a request emits `:bump`"),
        ("(:bump) lost", None),
    ],
)
def test_unknown_event_cannot_be_spurious(fault: str, said: str | None) -> None:
    program = LIBRARY.program
    told = told_for_skills(program.library)
    assert problem(read_fault(fault), program.signatures, told) == said
