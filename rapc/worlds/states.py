"""Saved states of worlds, and what is raised for data that are none."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def reading_state(of: str) -> Iterator[None]:
    """Raise a ValueError that names the world for what is wrong with saved data."""
    try:
        yield
    except (KeyError, ValueError) as error:
        raise ValueError(f"no state of {of}: {error}") from error
