"""Draws of chance that runs make all the time, and random streams as plain values."""

from __future__ import annotations

import random

Stream = tuple[int, tuple[int, ...], float | None]
"""The state of a random stream, as `random.Random.getstate` has it."""


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


def stream_state(rng: random.Random) -> Stream:
    """Return the state of a random stream."""
    version, internal, gauss = rng.getstate()
    return version, tuple(internal), gauss


def stream_in(state: Stream) -> random.Random:
    """Return a random stream in a state.

    Raises:
        ValueError: if it is no state of a stream.
    """
    rng = random.Random()
    try:
        rng.setstate(state)
    except (TypeError, OverflowError) as error:
        raise ValueError(f"no state of a random stream: {error}") from error
    return rng
