"""Holding Python's search for reference cycles back while much is made that is kept."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def gc_paused() -> Iterator[None]:
    """Hold the search for reference cycles back while a library is read or checked.

    What is made then is kept and holds no cycles, so the search would find nothing,
    and its share of the time grows with all that the program holds. It goes on
    afterwards if it was on before.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@contextmanager
def gc_spared() -> Iterator[None]:
    """Hold the search back, and leave all that there is then out of every later one.

    For imports: modules stay until the process ends, and the last search of all, which
    Python makes when it ends, would take as long as importing a tenth of them.
    """
    with gc_paused():
        yield
        gc.freeze()
