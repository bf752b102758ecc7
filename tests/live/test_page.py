"""The commands in real time of the page on machines, typed as they stand."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.docs.pages import blocks, page

pytestmark = pytest.mark.nightly

SHELL = """
trap 'kill $(jobs -p)' EXIT
await() { for _ in {1..100}; do test -S rover.socket && return; sleep 0.1; done; }
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the files of the page."""
    for block in blocks(page("how-to/drive-a-machine")):
        if block.name:
            (tmp_path / block.name).write_text(block.text)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    monkeypatch.setenv("PATH", path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _commands() -> list[str]:
    return [one.text for one in blocks(page("how-to/drive-a-machine"), "sh")]


def _typed(commands: str) -> str:
    done = subprocess.run(
        ["bash", "-c", SHELL + commands], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_rover_drives_in_real_time(folder: Path) -> None:
    began = time.monotonic()
    told = _typed(_commands()[0])
    assert 2 <= time.monotonic() - began < 4
    assert "  [1] (patrol kitchen) succeeded, 0 to 2" in told


def test_served_rover_drives_with_a_journal(folder: Path) -> None:
    commands = _commands()[1]
    told = _typed(commands.replace("&\n", "&\nawait\n"))
    assert told.count("  [1] (patrol kitchen) succeeded, 0 to 2") == 2


def test_killed_run_resumes_with_the_served_rover(folder: Path) -> None:
    serve, run, resume = _commands()[1].replace("\\\n", "").splitlines()
    await_request = "until grep -q drive day-1/journal*; do sleep 0.1; done"
    kill = f"{await_request}; sleep 0.5; kill -{signal.SIGKILL.value} $!; wait $!"
    told = _typed(f"{serve}\nawait\n{run} &\n{kill}\n{resume}\n")
    lost = "the process of the interpreter ended before the outcome was known"
    assert f"(drive kitchen) - refused: {lost}" in told
    assert told.count("  [1] (patrol kitchen) succeeded") == 1
