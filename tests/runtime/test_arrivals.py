"""Stops between two cycles leave the trace of a run as it is."""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Any

import pytest

import rapc
from rapc.runtime.interpreter import Interpreter
from tests.runtime.helpers import Play, row

RUNS: Mapping[str, tuple[str, str, dict[str, Any]]] = {
    "truck": (
        "stdlib/truck",
        "truck",
        {"agenda": "nine-orders", "options": {"shuffle-interval": 15}},
    ),
    "courier": ("examples/courier", "courier", {"agenda": "shift"}),
    "hallway": ("stdlib/hallway", "hallway", {"agenda": "sightseeing"}),
}


def _begun(name: str) -> tuple[Interpreter, list[str]]:
    """Return a run and the list to which its events are added as text."""
    library, world, given = RUNS[name]
    lines: list[str] = []
    run = rapc.load(library).start(
        world, seed=3, listeners=[lambda event: lines.append(repr(event))], **given
    )
    return run, lines


@pytest.mark.parametrize("name", RUNS)
def test_stops_at_arrivals_change_no_trace(name: str) -> None:
    run, expected = _begun(name)
    while run.cycle < 600 and run.step():
        pass
    stopped, lines = _begun(name)
    chance, arrivals = random.Random(7), 0
    while stopped.cycle < 600:
        while chance.random() < 0.8 and stopped.come_to_arrival():
            arrivals += 1
            if chance.random() < 0.2:
                stopped.restore(stopped.save())
        if not stopped.step():
            break
    assert arrivals > (0 if name == "truck" else 20)
    assert lines == expected


MOVE = """
(declare-primitive walk (?where) (okay) :atomic false)
(define-rap (move) (method (primitive (walk lab))))
(define-rap (late) (method (primitive (walk yard))))
"""


def test_each_arrival_is_a_stop() -> None:
    rows = [row("(walk ?)", after=5)]
    play = Play(MOVE, "(move)", "(late) :at 3", rows=rows)
    run = play.interpreter
    assert not run.come_to_arrival()  # `move` is eligible at once
    assert run.step()
    assert run.come_to_arrival()
    assert (run.cycle, run.now, run.created) == (1, 3, 2)
    assert not run.come_to_arrival()
    assert run.step()
    assert run.come_to_arrival()
    assert (run.cycle, run.now, [*run.requests()]) == (2, 5, [2])
    assert run.step()
    assert run.come_to_arrival()
    assert (run.now, run.requests()) == (8, {})
    assert run.step()
    assert not run.come_to_arrival()
    assert run.reason == "done"
