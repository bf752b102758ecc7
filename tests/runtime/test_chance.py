"""Draws of chance are those of Python's own generator."""

from __future__ import annotations

import random

from rapc.base.chance import below


def test_draws_below_a_number_are_those_of_randrange() -> None:
    ours, theirs = random.Random("draws"), random.Random("draws")
    counts = [*range(1, 70), 2**31 - 1, 2**31, 2**40 + 1]
    for count in counts * 5:
        assert below(ours, count) == theirs.randrange(count)
    assert ours.getstate() == theirs.getstate()
