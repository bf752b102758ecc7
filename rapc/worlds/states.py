"""Saved states of worlds, and the error for invalid data."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def reading_state(of: str) -> Iterator[None]:
    """Raise a ValueError with the name of the world if saved data are invalid."""
    try:
        yield
    except (KeyError, ValueError) as error:
        raise ValueError(f"no state of {of}: {error}") from error
