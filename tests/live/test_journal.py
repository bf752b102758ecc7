"""The journal of a live run in the debugger: each state is that seen at the time."""

from __future__ import annotations

import hashlib
import random
from pathlib import Path
from types import MappingProxyType

import pytest

import rapc
from rapc.durable.folder import Options
from rapc.durable.opening import Opened
from rapc.durable.runs import begin
from rapc.live import Action, Clock, SimulatedClock, WallClock
from rapc.runtime.interpreter import Interpreter
from rapc.spec import RunSpec
from rapc.world import Atom, Datum
from tests.live.rover import LIBRARY, Rover

TASKS = """
(define-rap (drive-about)
  (succeed nil)
  (repeat-while (not (robot-at mars)))
  (method
    (task-net
      (t1 (round hall) (for t2))
      (t2 (round kitchen)))))
(define-rap (round ?room)
  (method
    (task-net
      (t1 (go-to ?room))
      (t2 (look-at ?room) (until-end t1)))))
(define-rap (look-at ?room)
  (method (primitive (look ?room))))
(define-rap (follow-battery)
  (succeed nil)
  (monitor-state (and (battery ?n) (not (beeped ?n))))
  (method
    (context (and (battery ?n) (not (beeped ?n))))
    (primitive (beep ?n))))
"""


class Busy(Rover):
    """A rover with 20 data in a second."""

    timeouts = MappingProxyType({"drive": 2})
    sent = drives = 0

    def connect(self) -> None:
        self.start(self.poll)

    def do_drive(self, action: Action, room: Atom) -> str:
        self.drives += 1
        # the timeout ends each fifth drive
        self.seconds[room] = 3 if self.drives % 5 == 0 else 1.5
        return super().do_drive(action, room)

    def poll(self, action: Action) -> None:
        while True:
            self.sent += 1
            self.send(Datum(("battery", self.sent)))
            action.sleep(0.05)


def _digest(run: Interpreter) -> bytes:
    return hashlib.sha256(run.save()).digest()


def _check(folder: Path, clock: Clock, until: float, moments: int) -> None:
    """Run with a journal; then go to random cycles and back in the debugger."""
    library = rapc.loads(LIBRARY + TASKS)
    spec = RunSpec(
        tasks=("(drive-about)", "(follow-battery)"),
        settings={"futile-limit": 9999},
        until=until,
    )
    rover = Busy(clock=clock)
    run = Interpreter.prepared(library.program, rover, spec)
    trace = folder.with_suffix(".jsonl")
    durable = begin(folder, run, Options(), until=until, trace=trace)
    seen: dict[int, bytes] = {}
    while durable.step():
        seen[durable.run.cycle] = _digest(durable.run)
    durable.close()
    rover.close()
    assert durable.run.reason == "until"
    acts = [one[1] for one in rover.log]
    assert acts.count("drive") > until / 10
    assert acts.count("looked") > until / 10

    opened = Opened(folder)  # the rover is not asked
    world = opened.build(Busy, 0, {})
    again = Interpreter.prepared(opened.program(), world, opened.spec)
    history = opened.history(again)
    chance = random.Random(1)
    first, last = min(seen), max(seen)
    for _ in range(moments):
        cycle = chance.choice(list(seen))
        for one in (cycle, last, cycle, first):
            history.goto(one)
            assert (history.cycle, _digest(history.run)) == (one, seen[one])
    print(f"{len(seen)} cycles, {rover.sent} data, {moments} moments")  # for -s


def test_states_of_a_journal_are_those_seen_at_the_time(tmp_path: Path) -> None:
    _check(tmp_path / "journal", SimulatedClock(), 12, 10)


@pytest.mark.nightly
@pytest.mark.timeout(1800)
def test_states_of_a_live_run_are_those_seen_at_the_time(tmp_path: Path) -> None:
    # ten minutes of real time
    _check(tmp_path / "journal", WallClock(), 600, 200)
