"""The orderly end of a run by a signal, and the log of a run."""

from __future__ import annotations

import logging
import subprocess
import sys
from pathlib import Path

import pytest

import rapc
from rapc.events import Event, SignalReceived, TaskSucceeded
from tests.live.rover import LIBRARY, SimulatedRover


@pytest.mark.parametrize("world", ["StoppedInRequest", "StoppedInWait"])
def test_sigterm_cancels_the_requests_and_ends_with_a_report(
    world: str, tmp_path: Path
) -> None:
    library = tmp_path / "go.rap"
    library.write_text(LIBRARY)
    command = [sys.executable, "-m", "rapc", "run", str(library), "-q"]
    command += ["--world", f"tests.live.rover:{world}", "--task", "(go-to hall)"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.returncode == 1
    lines = done.stdout.splitlines()
    assert lines[0] == "drive hall"
    assert lines.count("stop hall") == 1
    assert any(line.startswith("Run over (cancelled)") for line in lines)


def test_log_has_the_lines_of_the_text_trace(caplog: pytest.LogCaptureFixture) -> None:
    library, rover = rapc.loads(LIBRARY), SimulatedRover()
    with caplog.at_level(logging.INFO, "rapc.run"):
        rapc.run(library, rover, "(go-to hall)", listeners=[rapc.LogTrace()])
    rover.close()
    told = [one for one in caplog.records if one.name == "rapc.run"]
    assert {one.levelname for one in told} == {"INFO"}
    lines = [one.getMessage() for one in told]
    assert "1.5 ... primitive operation (drive hall) - okay" in lines
    ends = [one for one in told if isinstance(vars(one)["event"], TaskSucceeded)]
    assert [one.getMessage().split()[0] for one in ends] == ["1.5"]


def test_log_has_failed_tasks_as_warnings(caplog: pytest.LogCaptureFixture) -> None:
    library, rover = rapc.loads(LIBRARY), SimulatedRover()
    with caplog.at_level(logging.INFO, "rapc.run"):
        rapc.run(library, rover, "(go-to cellar)", listeners=[rapc.LogTrace()])
    rover.close()
    warned = [one.getMessage() for one in caplog.records if one.levelname == "WARNING"]
    assert any("(go-to cellar)" in line for line in warned)


def test_driver_may_be_closed_twice() -> None:
    library, rover = rapc.loads(LIBRARY), SimulatedRover()
    rapc.run(library, rover, "(see hall)")
    rover.close()
    rover.close()


def test_long_cycle_is_a_signal_in_the_trace(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock counts as real, and the time between two calls is a given one."""
    rover = SimulatedRover()
    run = rapc.loads(LIBRARY).start(rover, tasks=["(go-to hall)"])
    while not rover._connected:
        run.step()
    gaps = iter([0.05, 0.0504])
    monkeypatch.setattr(rover.clock, "real", True)
    monkeypatch.setattr(rover._watchdog, "beat", lambda: next(gaps, 0))
    heard: list[Event] = []
    run.listen(heard.append, SignalReceived)
    assert run.run() == "done"
    rover.close()
    found = [event.what for event in heard if isinstance(event, SignalReceived)]
    assert found == [(":long-cycle", 50)]
