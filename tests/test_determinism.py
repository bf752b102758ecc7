"""One library, world and seed: one trace, byte for byte, in any process."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.effort import first

TRUCK = (
    *("--world", "truck"),
    *("--task", "(fill-order red 2 factory-1)"),
    *("--task", "(fill-order blue 1 factory-2) :priority 1 :at 100"),
)
HALLWAY = (
    *("--world", "hallway", "--agenda", "standing-by"),
    *("--task", "(go-to desk) :at 1", "--until", "600"),
)
COMMAND = (sys.executable, "-c", "from rapc.cli.main import main; main()", "run", "-")


def _traces(
    folder: Path, hash_seed: int, seed: int, given: tuple[str, ...] = TRUCK
) -> tuple[bytes, str]:
    """The traces of a run in a process of its own, as JSON Lines and as text."""
    path = folder / f"{hash_seed}-{seed}.jsonl"
    done = subprocess.run(
        [
            *COMMAND,
            *given,
            *("--seed", str(seed), "--trace", str(path)),
        ],
        input=f'(require "{given[1]}")\n',
        env={**os.environ, "PYTHONHASHSEED": str(hash_seed)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return path.read_bytes(), done.stdout


@pytest.mark.parametrize("case", first(2, [(TRUCK, 0), (HALLWAY, 3), (TRUCK, 7)]))
def test_another_process_and_hash_seed_give_the_same_trace(
    tmp_path: Path, case: tuple[tuple[str, ...], int]
) -> None:
    given, seed = case
    one = _traces(tmp_path, 1, seed, given)
    assert one[0].startswith(b'{"event":"run-started","n":0,"cycle":0,"time":0,')
    assert _traces(tmp_path, 2, seed, given) == one


def test_another_seed_gives_another_trace(tmp_path: Path) -> None:
    one, other = (_traces(tmp_path, 1, seed)[0].splitlines() for seed in (0, 1))
    assert one[1:] != other[1:]  # the first line tells the seed


@pytest.mark.parametrize("others", first(1, ["rapc.host", "rapc.worlds.truck.world"]))
def test_examples_of_hypothesis_do_not_depend_on_what_is_imported(others: str) -> None:
    """The tests that ran before in a process decide about that, so chance does."""
    code = """
import sys, importlib, tests.conftest
from hypothesis import given, strategies as st
for name in sys.argv[1:]: importlib.import_module(name)
@given(st.integers() | st.text())
def show(value): print(ascii(value))
show()
"""
    one, other = (
        subprocess.run(
            [sys.executable, "-c", code, *names],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for names in ([], [others])
    )
    assert one == other
