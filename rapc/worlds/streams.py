"""Random streams as plain values, for worlds that save their state."""

from __future__ import annotations

import random

Stream = tuple[int, tuple[int, ...], float | None]
"""The state of a random stream, as `random.Random.getstate` has it."""


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
