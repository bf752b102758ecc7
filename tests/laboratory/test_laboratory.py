"""The laboratory among the examples: its tests, its world and its shifts."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import rapc
from rapc.worlds.registry import build_world, find_world
from tests.effort import first

LABORATORY = Path(__file__).parents[2] / "examples" / "laboratory"
WORLD = "laboratory:LaboratoryWorld"
SAMPLES = 6


def _rapc(*words: str) -> str:
    """Return what a command prints that runs in the folder of the example."""
    command = [sys.executable, "-m", "rapc", *words]
    done = subprocess.run(
        command, cwd=LABORATORY, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_laboratory_has_no_findings() -> None:
    report = rapc.check(LABORATORY)
    assert report.raps >= 30
    assert report.findings == ()


def test_laboratory_tests_pass_with_several_seeds() -> None:
    assert "54 passed" in _rapc("test", ".", "--seeds", "2")


def test_laboratory_world_keeps_the_contract() -> None:
    said = _rapc("worlds", WORLD, "--test", "world.rap")
    assert "10 checks passed, 1 not applicable" in said


@pytest.mark.parametrize("seed", first(3, range(30)))
def test_shift_reports_all_samples(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(LABORATORY)
    world = build_world(find_world(WORLD), seed, {})
    settings = rapc.Settings(strict=True)
    run = rapc.load(LABORATORY).start(
        world, agenda="shift", seed=seed, settings=settings
    )
    assert run.run(until=3000) == "done"
    assert [task for task in run.results() if task.outcome == "failed"] == []
    figures = world.figures()  # type: ignore[attr-defined]
    assert (figures["right"], figures["wrong"]) == (SAMPLES, 0)


def test_shift_is_the_same_each_time() -> None:
    words = ("run", ".", "--world", WORLD, "--agenda", "shift", "--seed", "3")
    assert _rapc(*words) == _rapc(*words)
