"""The truck's handlers do what `world.rap` says of them: `rapc.strict`.

200 runs are made by hand: examples/experiments/held-to-their-word.toml.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import pytest

from rapc.base.values import Atom
from rapc.runtime.settings import Settings
from tests.effort import first

from .runs import STDLIB, Run, agenda, library

HARDEST = {"shuffle-tools": True, "enemy-interval": 40, "shuffle-efficiency": 100}
OPTIONS: Mapping[str, Mapping[str, Atom | bool]] = {
    "every-8": {"shuffle-interval": 8, "shuffle-efficiency": 40},
    "among-troops": {"shuffle-interval": 8, **HARDEST},
    "still": {},
    "every-100": {"shuffle-interval": 100, "shuffle-efficiency": 40},
    "a-lot": {"shuffle-interval": 15, "shuffle-efficiency": 80},
}
"""Settings of chapter 6, and the hardest ones. Items merge under seed 0."""


@pytest.mark.parametrize("case", first(1, product(range(4), OPTIONS)), ids=str)
def test_handlers_keep_their_word(case: tuple[int, str]) -> None:
    seed, name = case
    run = Run(
        *agenda("nine-orders"),
        seed=seed,
        options=OPTIONS[name],
        compiled=library(STDLIB / "truck"),
        settings=Settings(strict=True),
    )
    assert run.reason in ("done", "world")
    assert run.faults == []
