"""Draws of chance that runs make all the time."""

from __future__ import annotations

import random


def below(rng: random.Random, count: int) -> int:
    """Return a number from 0 to `count` - 1: what `rng.randrange(count)` would return.

    It takes as many random bits as that, and a third of the time: there is nothing to
    look at but a `count` of at least 1.
    """
    bits = count.bit_length()
    drawn = rng.getrandbits(bits)
    while drawn >= count:
        drawn = rng.getrandbits(bits)
    return drawn
