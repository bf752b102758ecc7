"""Pauses of Python's garbage collector while many lasting objects are made."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def gc_paused() -> Iterator[None]:
    """Pause the garbage collector while a library is read or checked.

    The objects made meanwhile last and have no cycles. A collection would find
    nothing, and its time grows with the number of objects in the program. Afterwards
    the collector is on if it was on before.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@contextmanager
def gc_aged() -> Iterator[None]:
    """Pause the garbage collector, and count the present objects as old afterwards.

    Otherwise the first collection after the pause would visit all objects made
    meanwhile. An old object is visited only by the rare collections of all objects.
    """
    with gc_paused():
        yield
        gc.freeze()
        gc.unfreeze()


@contextmanager
def gc_spared() -> Iterator[None]:
    """Pause the garbage collector, and exclude the present objects from it for good.

    For imports: modules stay until the process ends. The collection at the end of the
    process would take as long as the import of a tenth of the modules.
    """
    with gc_paused():
        yield
        gc.freeze()
