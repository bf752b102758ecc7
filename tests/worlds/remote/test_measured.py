"""Times of worlds in other processes, on this machine."""

from __future__ import annotations

import json
import os
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rapc.worlds.registry import build_world, find_world

pytestmark = pytest.mark.nightly

SERVED = f"exec:{sys.executable} -m rapc.worlds.remote"
LIBRARY = """
(declare-primitive drive (?room) (okay halted)
  :atomic false
  :on (okay (robot-at ?room)) :on (halted))
(declare-memory-property robot-at (?room) unknown)
(define-rap (visit ?room)
  (succeed (robot-at ?room))
  (method (primitive (drive ?room))))
"""


def test_idle_call_takes_at_most_60_us() -> None:
    world = build_world(find_world(f"{SERVED} truck"), 0, {})
    world.facts()
    times = []
    for _ in range(5000):
        began = time.perf_counter()
        world.advance(0)
        times.append(time.perf_counter() - began)
    assert statistics.median(times) <= 60e-6


def test_stopped_interpreter_halts_the_body(tmp_path: Path) -> None:
    library, log, trace = (tmp_path / name for name in ("go.rap", "log", "trace.jsonl"))
    library.write_text(LIBRARY)
    command = [sys.executable, "-m", "rapc", "run", str(library), "--trace", str(trace)]
    command += ["--world", f"{SERVED} tests.worlds.remote.rover:Rover"]
    environment = {**os.environ, "ROVER_LOG": str(log)}
    run = subprocess.Popen(
        [*command, "--task", "(visit kitchen)"], env=environment, stdout=subprocess.PIPE
    )
    deadline = time.monotonic() + 20
    while not log.exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.3)
    stopped = time.time()
    run.send_signal(signal.SIGSTOP)
    time.sleep(2)
    run.send_signal(signal.SIGCONT)
    run.communicate(timeout=20)
    events = [line.split() for line in log.read_text().splitlines()]
    assert [what for what, _ in events] == ["start", "halted", "start", "okay"]
    assert float(events[1][1]) - stopped <= 0.3
    assert run.returncode == 0
    ends = [json.loads(line) for line in trace.read_text().splitlines()]
    results = [one["result"] for one in ends if one["event"] == "primitive-ended"]
    assert results == ["halted", "okay"]
