"""Idle times of a thing, and the tasks that could have used it."""

from __future__ import annotations

import pytest

import rapc
from rapc.base.values import Fact
from rapc.debug.history import History
from rapc.debug.questions.idle import idle, idle_times
from rapc.debug.questions.times import account
from rapc.errors import ArgumentError
from rapc.world import Time
from rapc.worlds.script import At, Row
from rapc.worlds.scripted import ScriptedWorld

TEXT = """
(declare-primitive lift (?arm ?x) (okay) :atomic false :uses ((arm ?arm)))
(declare-primitive drive () (okay) :atomic false :uses (wheels))
(declare-memory-proposition wanted (?x))
(define-rap (take ?arm ?x) (method (primitive (lift ?arm ?x))))
(define-rap (fetch ?x)
  (method (claims wheels) (task-net (t1 (take left ?x) (for t2)) (t2 (go)))))
(define-rap (go) (method (primitive (drive))))
(define-rap (take-wanted ?x)
  (monitor-state (wanted ?x))
  (method (primitive (lift left ?x))))
"""


def _history(*tasks: str) -> History:
    rows = [Row(("lift", "?", "?"), after=3), Row(("drive",), after=5)]
    library = rapc.loads(TEXT, "arms.rap")
    ats = [At(15, asserts=(("wanted", "c"),))]
    world = ScriptedWorld(rows, ats, declared=library.program.library)
    history = History.open(library, world, tasks=tasks)
    history.go()
    return history


def test_idle_times_lie_between_uses_and_claims() -> None:
    history = _history("(fetch a)", "(fetch b)", "(take-wanted c)")
    assert history.now == 18
    serial, state = history.serial, history.run.save()
    found = idle(history, "(arm left)")
    spans = [(row["from"], row["to"]) for row in found.rows]
    assert list(dict.fromkeys(spans)) == [(3, 8), (11, 15)]
    assert found.notes == ("(arm left) idle: 9 of 18, 50 %",)
    [waiting] = [row for row in found.rows if row["from"] == 3]
    assert (waiting["task"], waiting["waited"]) == ("[2]", 5)
    assert (waiting["for"], waiting["of"]) == ("wheels", "[1]")
    [nobody] = [row for row in found.rows if row["from"] == 11]
    assert (nobody["task"], nobody["goal"]) == (None, "no task could use it")
    assert (history.serial, history.run.save()) == (serial, state)


def test_claimed_thing_is_not_idle() -> None:
    found = idle(_history("(fetch a)", "(take right b) :at 10"), "wheels")
    [row] = found.rows
    assert (row["from"], row["to"]) == (8, 13)
    assert idle(_history("(fetch a)"), "wheels").lines == ("never idle",)


def _held_by_claims(history: History, thing: Fact) -> list[tuple[Time, Time]]:
    """Return the intervals between the ends of cycles with a claim held at both."""
    last, found = history.cycle, []
    before: Time | None = None
    for cycle in range(last + 1):
        history.goto(cycle)
        held = any(one.thing == thing for one in history.run.claims())
        if before is not None and held:
            found.append((before, history.now))
        before = history.now if held else None
    return [(start, stop) for start, stop in found if stop > start]


@pytest.mark.parametrize(
    ("folder", "world", "until", "things"),
    [
        ("examples/courier", "courier", 400, [("wheels",)]),
        (
            "examples/laboratory",
            "examples.laboratory.laboratory:LaboratoryWorld",
            150,
            [("heater",), ("instrument",), ("arm", "left"), ("arm", "right")],
        ),
    ],
)
def test_claimed_thing_is_idle_at_no_moment(
    folder: str, world: str, until: int, things: list[Fact]
) -> None:
    history = History.open(rapc.load(folder), world, agenda="shift", seed=1)
    history.goto_time(until)
    history.goto(history.cycle)
    for thing in things:
        idle = idle_times(history, account(history), thing)
        held = _held_by_claims(history, thing)
        assert held
        for start, stop in held:
            assert not any(start < b and a < stop for a, b in idle)


@pytest.mark.parametrize(
    ("thing", "why"),
    [
        ("wheel", r"unknown thing `wheel`"),
        ("arm", "unknown thing `arm`"),
        ("(arm ?x)", "must not contain variables"),
    ],
)
def test_unknown_thing_is_refused(thing: str, why: str) -> None:
    with pytest.raises(ArgumentError, match=why):
        idle(_history("(fetch a)"), thing)
