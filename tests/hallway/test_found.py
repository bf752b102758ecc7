"""What the planner has found is RAP text, and drives without a planner [S 3.2]."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

import rapc
from rapc import events
from rapc.base.values import Atom
from rapc.ir.nodes import Method
from rapc.worlds.hallway import HallwayWorld
from rapc.worlds.registry import build_world
from tests.hallway.sent import STDLIB, begin

PLANNED = "travel-to-distant-space"

WITHOUT = """(define-rap (travel-to-distant-space (?space space))
  (succeed (current-space robot ?space)))
"""

QUIET: dict[str, Atom | bool] = {"doors": 0, "people": 0}


def _planner(goal: Sequence[Atom], memory: object) -> Sequence[Method]:
    raise AssertionError("nothing is left to be planned")


def _with(text: str) -> rapc.CheckedLibrary:
    """The library of the hallway, one of its definitions in another wording."""
    files = (f for f in sorted(STDLIB.glob("*.rap")) if ".test." not in f.name)
    lines = "".join(file.read_text(encoding="utf-8") for file in files).splitlines()
    whole = "\n".join(line for line in lines if not line.startswith("(require"))
    assert WITHOUT in whole
    return rapc.loads(whole.replace(WITHOUT, text))


def test_ways_that_were_found_are_text_that_drives_without_a_planner() -> None:
    task = "(go-to coffee-machine) :at 1"
    run, _ = begin(2, task, options=QUIET)
    heard = run.record()
    run.run(until=1000)
    text = rapc.rap_text(run, PLANNED)
    assert text.startswith(f"(define-rap ({PLANNED} (?space space))")
    assert text.count("(method ") == 1
    assert "(go-to-next-space kitchen-door kitchen)" in text
    world = build_world(HallwayWorld, 2, QUIET)
    written = _with(text).start(
        world,
        agenda="standing-by",
        tasks=[task],
        seed=2,
        solvers={PLANNED: _planner},
    )
    again = written.record()
    written.run(until=1000)
    (sent,) = [one for one in written.results() if not one.background]
    assert (sent.outcome, written.now) == ("succeeded", run.now)
    assert any(isinstance(event, events.SolverCalled) for event in heard)
    assert not any(isinstance(event, events.SolverCalled) for event in again)


def test_a_rap_without_a_planner_is_written_as_it_was() -> None:
    run, _ = begin(2)
    assert rapc.rap_text(run, "nothing") == "(define-rap (nothing) (succeed true))"
    with pytest.raises(rapc.RefusedError, match="unknown RAP `no-such-rap`"):
        rapc.rap_text(run, "no-such-rap")
