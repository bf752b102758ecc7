"""Runs among enemies and a demon, with nine orders: each trace is known byte by byte.

Of each trace there is a digest in `golden/hardest-runs.txt`: so no behaviour changes
unseen. Where one is meant to change, write them anew:

    python -m tests.truck.test_hardest_runs
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Mapping
from pathlib import Path

import pytest

from rapc.base.values import Atom
from rapc.runtime.events.trace import JsonTrace
from rapc.runtime.interpreter import Interpreter
from rapc.worlds.registry import build_world
from rapc.worlds.truck import TruckWorld
from tests.effort import first

from .runs import STDLIB, agenda, library

GOLDEN = Path(__file__).parent / "golden" / "hardest-runs.txt"
SEEDS = range(20)
UNTIL = 3000

Options = Mapping[str, Atom | bool]

DEMON: Options = {"shuffle-interval": 8, "shuffle-efficiency": 100}
SETTINGS: tuple[Options, ...] = (
    {},
    DEMON,
    {"shuffle-interval": 20, "enemy-interval": 150},
    {**DEMON, "shuffle-tools": True, "enemy-interval": 40},
)
"""Each seed has one of them, in turn."""


def digest(seed: int) -> str:
    """The trace of a run as JSON Lines, in a few letters.

    Its first line is left out: it has the digest of the library and all settings.
    """
    world = build_world(TruckWorld, seed, SETTINGS[seed % len(SETTINGS)])
    interpreter = Interpreter(library(STDLIB / "truck"), world, seed)
    stream = io.StringIO()
    interpreter.listen(JsonTrace(stream))
    for each in agenda("nine-orders"):
        interpreter.submit(each)
    interpreter.run(until=UNTIL)
    text = stream.getvalue().replace(str(STDLIB), "stdlib")
    text = text.partition("\n")[2]
    assert text.count("\n") > 500
    return hashlib.sha256(text.encode()).hexdigest()[:16]


@pytest.mark.parametrize("seed", first(2, SEEDS))
def test_the_trace_is_known(seed: int) -> None:
    golden = GOLDEN.read_text(encoding="utf-8").splitlines()
    assert digest(seed) == golden[seed]


if __name__ == "__main__":
    GOLDEN.write_text("".join(f"{digest(seed)}\n" for seed in SEEDS), encoding="utf-8")
