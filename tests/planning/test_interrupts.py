"""Ctrl-C while a plan is looked for: `rapc plan` and `rapc run` end cleanly."""

from __future__ import annotations

import json
import random
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.cli.command import COMMAND

WORLD = '''"""A sliding puzzle whose plan takes the search a long time."""

from pathlib import Path

from rapc.world import Kit, Offer, SimpleWorld

TILES = (15, 14, 8, 12, 10, 11, 9, 13, 2, 6, 5, 1, 3, 7, 4, 0)


class PuzzleWorld(SimpleWorld):
    """The puzzle."""

    name = "puzzle"
    kit = Kit(Offer({"push": (1, ("okay",))}))

    def facts(self):
        Path("begun").touch()
        for at, tile in enumerate(TILES):
            yield ("on", f"t{tile}", f"p{at}") if tile else ("free", f"p{at}")
            for other in (at + 1,) * (at % 4 < 3) + (at + 4,) * (at < 12):
                yield ("beside", f"p{at}", f"p{other}")
                yield ("beside", f"p{other}", f"p{at}")

    def perform(self, ticket, request):
        return "okay"
'''
GOAL = f"(and {' '.join(f'(on t{at} p{at - 1})' for at in range(1, 16))})"
LIBRARY = f"""(declare-memory-proposition on (?tile ?place))
(declare-memory-proposition free (?place))
(declare-memory-proposition beside (?place ?other))
(declare-primitive push (?tile) (okay))
(define-rap (slide ?tile ?from ?to)
  (preconditions (and (on ?tile ?from) (free ?to) (beside ?from ?to)))
  (effects (on ?tile ?to) (free ?from) (not (on ?tile ?from)) (not (free ?to)))
  (method (primitive (push ?tile))))
(define-rap (order)
  (succeed {GOAL})
  (plan))
"""
SET = ("--set", "rapc.plan-limit=10000000")
COMMANDS = {
    "plan": ("plan", GOAL, "puzzle.rap", "--world", "puzzle:PuzzleWorld", *SET),
    "run": (
        *("run", "puzzle.rap", "--world", "puzzle:PuzzleWorld", "--task", "(order)"),
        *(*SET, "--trace", "run.jsonl"),
    ),
}
LATEST = 0.4
"""The latest moment, in seconds after the first question to the world."""


def interrupted(name: str, folder: Path, moment: float) -> None:
    """Interrupt a command at a moment after the first question to the world."""
    (folder / "puzzle.py").write_text(WORLD)
    (folder / "puzzle.rap").write_text(LIBRARY)
    trace = folder / "run.jsonl"
    begun = folder / "begun"
    begun.unlink(missing_ok=True)
    process = subprocess.Popen(
        [str(COMMAND), *COMMANDS[name]],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    ends = time.monotonic() + 60
    while not begun.exists() and time.monotonic() < ends:
        time.sleep(0.002)
    time.sleep(moment)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=60)
    assert errors.strip() == ""
    if name == "plan" or process.returncode != 1:
        assert (process.returncode, output) == (130, "")
        return
    assert "Run over (cancelled) at time 0" in output
    lines = [json.loads(line) for line in trace.read_text().splitlines()]
    assert lines[-1]["event"] == "run-ended"
    assert lines[-1]["reason"] == "cancelled"


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_interrupt_ends_a_search(name: str, tmp_path: Path) -> None:
    for moment in (0, LATEST):
        interrupted(name, tmp_path, moment)


@pytest.mark.nightly
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", COMMANDS)
def test_interrupts_at_any_moment_end_a_search(name: str, tmp_path: Path) -> None:
    rng = random.Random(30)
    for _ in range(50):
        interrupted(name, tmp_path, rng.random() * LATEST)
